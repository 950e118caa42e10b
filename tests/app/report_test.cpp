// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/report.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "support/shapes.h"

namespace nacre::app {
namespace {

using nlohmann::json;

metric::Comparison example_comparison() {
  metric::Comparison c;
  c.a_to_b = {0.01, 0.008, 0.05, {1, 2, 3}, 1000, {}};
  c.b_to_a = {0.02, 0.009, 0.04, {4, 5, 6}, 2000, {}};
  c.bbox_diagonal = 10;
  c.psnr_db = 53.979;
  return c;
}

EncodeRun example_run() {
  EncodeRun run;
  run.command.scan = "dir/scan.ply";
  run.command.output = "dir/scan.ncr";
  run.command.goal = {Goal::Kind::kSize, 4000};
  run.target_bytes = 4000;
  run.input.file = "dir/scan.ply";
  run.input.read.format = "ply-le";
  run.input.read.file_bytes = 8'000'000;
  run.input.read.not_carried = {"red"};
  run.input.vertices = run.input.goal_vertices = 500;
  run.input.faces = 996;
  run.input.bbox_diagonal = 10;
  run.remesh.clean.actions = {{"welded vertices", 12, {3, 4}}};
  run.remesh.clean.pieces = 2;
  run.remesh.pieces = {{900, 20, 0, 0, ""}, {96, 4, 1, 0, "kept flat: too small"}};
  run.remesh.bands = {{30, 27, 0}};
  run.remesh.levels = 1;
  run.remesh.vertices = 42;
  run.coded.bytes = 3990;
  run.coded.bytes_base = 100;
  run.coded.predicted_distortion = 1.1;
  run.coded.measured_distortion = 1.0;
  run.coded.bands = {{30, 1.5, 0.25, 600, 0.9, 0.001, {{0.25, 20, 0.001}, {0.5, 10, 0.004}}}};
  run.distance = example_comparison();
  run.costs = {{"read", 0.25, 1000}, {"remesh", 2, 5000}, {"encode", 1, 4000}};
  run.seconds = 3.5;
  return run;
}

TEST(EncodeReport, HasThePublishedKeys) {
  const json report = json::parse(to_json(example_run()));
  EXPECT_EQ(report["schema"], "nacre-report/0");
  EXPECT_EQ(report["bytes"], 3990);
  EXPECT_EQ(report["bytes_base"], 100);
  EXPECT_EQ(report["psnr_db"], 53.979);
  EXPECT_TRUE(report["remesh_psnr_db"].is_null());
  EXPECT_EQ(report["max_error"], 0.05);
  EXPECT_NEAR(report["max_error_percent"].get<double>(), 0.5, 1e-12);
  EXPECT_NEAR(report["bits_per_input_vertex"].get<double>(), 3990 * 8 / 500.0, 1e-12);
  EXPECT_EQ(report["input"]["vertices"], 500);
  EXPECT_EQ(report["input"]["not_carried"][0], "red");
  EXPECT_EQ(report["options"]["goal"]["kind"], "size");
  EXPECT_EQ(report["options"]["target_bytes"], 4000);
  EXPECT_EQ(report["options"]["repair"], "safe");
  EXPECT_NEAR(report["allocation"]["relative_error"].get<double>(), 0.1, 1e-12);
  EXPECT_EQ(report["distance"]["rms_b_to_a"], 0.02);
}

TEST(EncodeReport, ListsBandsStagesCleaningAndPieces) {
  const json report = json::parse(to_json(example_run()));
  const json& band = report["bands"][0];
  EXPECT_EQ(band["vertices"], 30);
  EXPECT_EQ(band["step"], 0.25);
  EXPECT_EQ(band["bits"], 600);
  EXPECT_EQ(band["bits_per_vertex"], 20);
  EXPECT_EQ(band["normal_only_fraction"], 0.9);
  ASSERT_EQ(band["samples"].size(), 2u);
  EXPECT_EQ(band["samples"][1]["bits_per_vertex"], 10);
  EXPECT_EQ(report["seconds"]["remesh"], 2);
  EXPECT_EQ(report["seconds"]["total"], 3.5);
  EXPECT_EQ(report["peak_bytes"]["encode"], 4000);
  EXPECT_EQ(report["peak_bytes"]["total"], 5000);
  EXPECT_EQ(report["clean"]["actions"][0]["kind"], "welded vertices");
  EXPECT_EQ(report["clean"]["actions"][0]["count"], 12);
  EXPECT_EQ(report["clean"]["actions"][0]["first_ids"], json({3, 4}));
  EXPECT_EQ(report["clean"]["pieces"], 2);
  ASSERT_EQ(report["pieces"].size(), 2u);
  EXPECT_EQ(report["pieces"][1]["fallback"], "kept flat: too small");
  EXPECT_EQ(report["remesh"]["bands"][0]["normal_only"], 27);
}

TEST(EncodeReport, HasTheRemeshQualityWhenMeasured) {
  EncodeRun run = example_run();
  run.remesh_distance = example_comparison();
  run.remesh_distance->psnr_db = 90;
  const json report = json::parse(to_json(run));
  EXPECT_EQ(report["remesh_psnr_db"], 90);
  EXPECT_EQ(report["remesh_distance"]["psnr_db"], 90);
}

TEST(EncodeReport, SurvivesNamesThatAreNotText) {
  EncodeRun run = example_run();
  run.input.file = "caf\xe9.ply";
  EXPECT_TRUE(json::accept(to_json(run)));
}

TEST(CompareReport, HasThePublishedKeys) {
  const json report = json::parse(to_json(example_comparison()));
  for (const char* key :
       {"psnr_db", "rms_a_to_b", "rms_b_to_a", "mean_a_to_b", "mean_b_to_a", "max_a_to_b",
        "max_b_to_a", "max_a_to_b_at", "max_b_to_a_at", "bbox_diagonal", "samples"}) {
    EXPECT_TRUE(report.contains(key)) << key;
  }
  EXPECT_EQ(report["max_b_to_a_at"], json({4, 5, 6}));
}

TEST(CompareReport, SaysNullForEqualSurfaces) {
  metric::Comparison equal = example_comparison();
  equal.psnr_db = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(json::parse(to_json(equal))["psnr_db"].is_null());
}

TEST(Summary, SaysWhatTheUserWantsToKnow) {
  const std::string line = summary_line(example_run());
  EXPECT_TRUE(
      line.starts_with("scan.ply 996 faces 8.00 MB -> scan.ncr 3.99 kB (2005x), max error "
                       "0.05 (0.5 %), PSNR 53.98 dB, 3.5 s, "))
      << line;
}

TEST(Summary, NamesCleaningAndFallbacks) {
  remesh::CleanReport clean;
  EXPECT_EQ(describe_cleaning(clean), "");
  clean.actions = {{"welded vertices", 1200, {}}, {"duplicate faces", 3, {}}};
  EXPECT_EQ(describe_cleaning(clean), "cleaned: 1,200 welded vertices, 3 duplicate faces");
  std::vector<remesh::PieceReport> pieces(8);
  EXPECT_TRUE(describe_fallbacks(pieces).empty());
  for (remesh::PieceReport& piece : pieces) piece.fallback = "as it is";
  const std::vector<std::string> lines = describe_fallbacks(pieces);
  ASSERT_EQ(lines.size(), 6u);
  EXPECT_EQ(lines[0], "piece 0 (0 triangles): as it is");
  EXPECT_EQ(lines[5], "3 more such pieces; --report lists them");
}

TEST(InputFacts, CountDistinctVerticesOfAnStlOnly) {
  io::ReadResult read;
  for (const Triangle& t : shapes::octahedron().triangles) {
    const auto first = static_cast<std::uint32_t>(read.scan.positions.size());
    for (const std::uint32_t v : t) {
      read.scan.positions.push_back(shapes::octahedron().positions[v]);
    }
    read.scan.triangles.push_back({first, first + 1, first + 2});
  }
  read.report.format = "stl-binary";
  EXPECT_EQ(input_facts("a.stl", read).goal_vertices, 6u);
  EXPECT_EQ(input_facts("a.stl", read).vertices, 24u);
  read.report.format = "ply-le";
  EXPECT_EQ(input_facts("a.ply", read).goal_vertices, 24u);
}

TEST(StageClock, ListsPartsBeforeTheirStage) {
  StageClock clock;
  clock.finish("read");
  clock.finish("remesh", {{"clean", 0.5, 100}});
  ASSERT_EQ(clock.costs().size(), 3u);
  EXPECT_EQ(clock.costs()[0].stage, "read");
  EXPECT_EQ(clock.costs()[1].stage, "remesh/clean");
  EXPECT_EQ(clock.costs()[2].stage, "remesh");
  EXPECT_GE(clock.costs()[2].seconds, 0);
  EXPECT_GT(clock.costs()[2].peak_bytes, 0u);
  EXPECT_GE(clock.total_seconds(), clock.costs()[0].seconds + clock.costs()[2].seconds);
}

}  // namespace
}  // namespace nacre::app
