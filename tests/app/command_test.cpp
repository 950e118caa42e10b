// SPDX-License-Identifier: GPL-3.0-or-later
//
// Whole runs of the built command on scans made here. Few tests with many expectations: each test
// is a process of its own, and the encode in it is what takes the time.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "io/io.h"
#include "run_command.h"

namespace nacre::app::test {
namespace {

using nlohmann::json;

constexpr const char* kSamples = "20000";

class Commands : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const {
    return scratch.file(name).string();
  }
  Outcome good(const std::vector<std::string>& arguments) {
    Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return outcome;
  }
  json good_json(const std::vector<std::string>& arguments) {
    const Outcome outcome = good(arguments);
    EXPECT_TRUE(json::accept(outcome.out)) << outcome.out;
    return json::parse(outcome.out, nullptr, false);
  }
  [[nodiscard]] Scan load(const std::string& name) const {
    const Result<io::ReadResult> read = io::read_scan(scratch.file(name));
    EXPECT_TRUE(read.has_value()) << read.error().message;
    return read ? read->scan : Scan{};
  }
  Scratch scratch;
};

/// A ball with bumps: smooth, but not what any predictor knows by heart.
Scan bumpy_ball(int levels) {
  Scan scan = shapes::sphere(levels);
  for (Vec3& p : scan.positions) {
    p *= 1 + 0.1 * std::sin(5 * p[0]) * std::cos(4 * p[1] + 1) + 0.05 * std::sin(9 * p[2]);
  }
  return scan;
}

TEST_F(Commands, EncodeReportsWhatCompareMeasures) {
  save(scratch, "ball.ply", bumpy_ball(5));
  const Outcome encoded = good({"encode", path("ball.ply"), "-o", path("ball.ncr"), "--size", "2k",
                                "--report", path("ball.json"), "--samples", kSamples});
  EXPECT_EQ(encoded.out, "");
  EXPECT_NE(encoded.err.find("ball.ply 8,192 faces"), std::string::npos) << encoded.err;
  EXPECT_EQ(encoded.err.find('\x1b'), std::string::npos) << "no terminal, no escape codes";

  const std::size_t bytes = scratch.read("ball.ncr").size();
  EXPECT_LE(bytes, 2000u);
  EXPECT_GE(bytes, 1900u);
  const json report = json::parse(scratch.read("ball.json"));
  EXPECT_EQ(report["bytes"], bytes);
  EXPECT_EQ(report["options"]["target_bytes"], 2000);
  EXPECT_EQ(report["input"]["vertices"], 4098);
  EXPECT_GT(report["remesh_psnr_db"], report["psnr_db"]);
  EXPECT_GT(report["psnr_db"], 50.0);
  ASSERT_FALSE(report["bands"].empty());
  for (const char* stage : {"read", "remesh", "encode", "measure_remesh", "total"}) {
    EXPECT_TRUE(report["seconds"].contains(stage)) << stage;
    EXPECT_GT(report["peak_bytes"][stage], 0) << stage;
  }

  // Measured on the file, so that measuring the file again gives the same digits.
  const json compared =
      good_json({"compare", path("ball.ply"), path("ball.ncr"), "--json", "--samples", kSamples});
  EXPECT_EQ(compared, report["distance"]);

  const json info = good_json({"info", path("ball.ncr"), "--json"});
  EXPECT_EQ(info["bytes"], bytes);
  EXPECT_EQ(info["bytes_whole"], bytes);
  EXPECT_EQ(info["levels"].size(), report["bands"].size() + 1);
  std::size_t coded = report["bands"].size();  // the finest bands may be left out
  while (coded > 0 && report["bands"][coded - 1]["bits"] == 0) --coded;
  EXPECT_EQ(info["sections"].back()["name"], "band " + std::to_string(coded - 1));
  EXPECT_NE(good({"info", path("ball.ncr")}).out.find("butterfly"), std::string::npos);
}

TEST_F(Commands, DecodeWritesEveryFormatAndLevel) {
  save(scratch, "ball.ply", bumpy_ball(4));
  good({"encode", path("ball.ply"), "-o", path("ball.ncr"), "--size", "1500", "--levels", "3",
        "--samples", kSamples, "--level-table", "on", "-q"});
  const json info = good_json({"info", path("ball.ncr"), "--json"});
  const std::size_t base = info["base_triangles"];
  for (const char* name : {"out.ply", "out.obj", "out.off", "out.stl"}) {
    const Outcome decoded = good({"decode", path("ball.ncr"), "-o", path(name)});
    EXPECT_EQ(decoded.out, "");
    EXPECT_EQ(load(name).triangles.size(), base * 64) << name;
  }
  good({"decode", path("ball.ncr"), "-o", path("out.glb")});
  EXPECT_TRUE(scratch.read("out.glb").starts_with("glTF"));
  for (int level = 0; level <= 3; ++level) {
    const std::string name = "level" + std::to_string(level) + ".ply";
    good({"decode", path("ball.ncr"), "-o", path(name), "--level", std::to_string(level)});
    EXPECT_EQ(load(name).triangles.size(), base << (2 * level));
    EXPECT_EQ(load(name).positions.size(), info["levels"][level]["vertices"]);
  }

  // What the level table says of each level is what the level has.
  for (int level = 0; level <= 3; ++level) {
    const std::string name = "level" + std::to_string(level) + ".ncr";
    good({"cut", path("ball.ncr"), "-o", path(name), "--level", std::to_string(level)});
    const json real =
        good_json({"compare", path("ball.ply"), path(name), "--json", "--samples", kSamples});
    const json& said = info["levels"][level];
    EXPECT_LE(said["psnr_db"], real["psnr_db"]) << level;
    EXPECT_GT(said["psnr_db"].get<double>(), real["psnr_db"].get<double>() - 0.0501) << level;
    EXPECT_GE(said["max_error"], real["max"]["value"]) << level;
  }

  // A file cut at a level's end still holds that level, and says so.
  const std::size_t cut = info["levels"][2]["prefix_bytes"];
  scratch.write("cut.ncr", scratch.read("ball.ncr").substr(0, cut));
  EXPECT_EQ(run({"decode", path("cut.ncr"), "-o", path("cut.ply")}).exit_code, 7);
  good({"decode", path("cut.ncr"), "-o", path("cut.ply"), "--partial"});
  EXPECT_EQ(scratch.read("cut.ply"), scratch.read("level2.ply"));
  const json cut_info = good_json({"info", path("cut.ncr"), "--json"});
  EXPECT_EQ(cut_info["levels"][2]["present"], true);
  EXPECT_EQ(cut_info["levels"][3]["present"], false);
}

TEST_F(Commands, BytesDoNotDependOnThreads) {
  save(scratch, "torus.ply", shapes::torus(48, 24));
  for (const char* threads : {"1", "2", "3"}) {
    good({"encode", path("torus.ply"), "-o", path(std::string("t") + threads + ".ncr"), "--size",
          "1k", "--threads", threads, "--samples", "1000", "-q"});
  }
  EXPECT_EQ(scratch.read("t1.ncr"), scratch.read("t2.ncr"));
  EXPECT_EQ(scratch.read("t1.ncr"), scratch.read("t3.ncr"));
  const json compared =
      good_json({"compare", path("torus.ply"), path("t1.ncr"), "--json", "--samples", kSamples});
  EXPECT_GT(compared["psnr_db"], 45.0);
}

TEST_F(Commands, FarAwayScansComeBackWhereTheyWere) {
  Scan far = bumpy_ball(3);
  far.origin = {500'000.25, 4'649'776.5, 120};
  save(scratch, "far.ply", far);
  good({"encode", path("far.ply"), "-o", path("far.ncr"), "--size", "1k", "--samples", "1000",
        "-q"});
  good({"decode", path("far.ncr"), "-o", path("back.ply"), "-q"});
  const Scan back = load("back.ply");
  ASSERT_FALSE(back.positions.empty());
  EXPECT_LT((back.positions[0] + back.origin - far.origin).norm(), 2.0);
  const json compared =
      good_json({"compare", path("far.ply"), path("back.ply"), "--json", "--samples", kSamples});
  EXPECT_GT(compared["psnr_db"], 40.0);
}

TEST_F(Commands, BitsPerVertexCountsInputVertices) {
  save(scratch, "ball.ply", bumpy_ball(5));
  good({"encode", path("ball.ply"), "-o", path("two.ncr"), "--bits-per-vertex", "2", "--samples",
        "1000", "-q"});
  const std::size_t target = 4098 * 2 / 8;
  EXPECT_LE(scratch.read("two.ncr").size(), target);
  EXPECT_GE(scratch.read("two.ncr").size(), target * 9 / 10);
}

TEST_F(Commands, RemeshWritesANormalMesh) {
  save(scratch, "ball.ply", bumpy_ball(4));
  const Outcome outcome = good({"remesh", path("ball.ply"), "-o", path("semi.ply"), "--levels", "3",
                                "--report", path("semi.json"), "--samples", kSamples});
  EXPECT_NE(outcome.err.find("PSNR"), std::string::npos);
  const json report = json::parse(scratch.read("semi.json"));
  EXPECT_EQ(report["verb"], "remesh");
  EXPECT_EQ(report["remesh"]["levels"], 3);
  EXPECT_EQ(report["remesh"]["bands"].size(), 3u);
  EXPECT_EQ(load("semi.ply").triangles.size(), report["remesh"]["triangles"]);
  EXPECT_GT(report["remesh_psnr_db"], 55.0);
}

TEST_F(Commands, RemeshWritesItsStepsDown) {
  save(scratch, "cap.ply", shapes::hemisphere(4));
  const std::vector<std::string> remesh = {
      "remesh",      path("cap.ply"), "-o",  path("semi.ply"), "--levels", "2", "--work-dir",
      path("steps"), "--dump",        "all", "--samples",      kSamples};
  const Outcome outcome = good(remesh);
  for (const char* direction : {"A -> B  rms", "B -> A  rms"})
    EXPECT_NE(outcome.err.find(direction), std::string::npos) << outcome.err;
  EXPECT_EQ(load("steps/01-input/scan.ply").triangles, load("cap.ply").triangles);
  EXPECT_EQ(load("steps/02-clean/clean.ply").triangles.size(), load("cap.ply").triangles.size());
  const std::size_t base = load("steps/03-base/base.ply").triangles.size();
  EXPECT_GT(base, 4u);
  EXPECT_GE(load("steps/04-parameterisation/map.ply").triangles.size(),
            load("cap.ply").triangles.size());
  for (int level = 0; level <= 2; ++level) {
    const Scan mesh = load("steps/05-normal-mesh/level-" + std::to_string(level) + ".ply");
    EXPECT_EQ(mesh.triangles.size(), base << (2 * level));
  }
  EXPECT_EQ(load("steps/05-normal-mesh/level-2.ply").positions, load("semi.ply").positions);
  std::vector<std::string> again = remesh;
  again[3] = path("other.ply");
  // The steps are there already, from the same input and options: they are used.
  good(again);
  EXPECT_EQ(load("other.ply").positions, load("semi.ply").positions);
  again[3] = path("third.ply");
  again.insert(again.end(), {"--base-vertices", "12"});
  EXPECT_EQ(run(again).exit_code, 2) << "steps of other options are not overwritten";
  EXPECT_FALSE(scratch.has("third.ply"));
}

TEST_F(Commands, CompareMapsAndDrawsTheDistance) {
  save(scratch, "a.ply", shapes::sphere(3));
  Scan moved = shapes::sphere(3);
  for (Vec3& p : moved.positions) p *= 1.1;
  save(scratch, "b.off", moved);
  const Outcome outcome = good({"compare", path("a.ply"), path("b.off"), "--map", path("map.ply"),
                                "--picture", path("map.png"), "--samples", kSamples});
  EXPECT_NE(outcome.out.find("PSNR"), std::string::npos);
  EXPECT_NE(scratch.read("map.ply").find("property float quality"), std::string::npos);
  EXPECT_TRUE(scratch.read("map.png").starts_with("\x89PNG"));
  EXPECT_EQ(load("map.ply").triangles, shapes::sphere(3).triangles);
  const json measured =
      good_json({"compare", path("a.ply"), path("b.off"), "--json", "--samples", kSamples});
  // A facet of the smaller ball is parallel to the larger one's, 0.1 x its distance from 0 away.
  EXPECT_GT(measured["rms_a_to_b"], 0.09);
  EXPECT_LT(measured["rms_a_to_b"], 0.1);
  EXPECT_NEAR(measured["bbox_diagonal"].get<double>(), std::sqrt(12.0), 1e-6);
  const json equal =
      good_json({"compare", path("a.ply"), path("a.ply"), "--json", "--samples", kSamples});
  EXPECT_TRUE(equal["psnr_db"].is_null() || equal["psnr_db"] > 250.0);
}

TEST_F(Commands, InfoDescribesAScan) {
  Scan scan = shapes::torus(12, 8);
  const auto extra = static_cast<std::uint32_t>(scan.positions.size());
  for (const Vec3& p : shapes::tetrahedron().positions)
    scan.positions.emplace_back(p + Vec3(9, 0, 0));
  for (const Triangle& t : shapes::tetrahedron().triangles) {
    scan.triangles.push_back({t[0] + extra, t[1] + extra, t[2] + extra});
  }
  scan.triangles.push_back(scan.triangles.front());  // a duplicate
  save(scratch, "two.ply", scan);
  const json info = good_json({"info", path("two.ply"), "--json"});
  EXPECT_EQ(info["format"], "ply-le");
  EXPECT_EQ(info["vertices"], 100);
  EXPECT_EQ(info["faces"], 197);
  EXPECT_EQ(info["clean"]["pieces"], 2);
  EXPECT_EQ(info["clean"]["closed_pieces"], 2);
  EXPECT_EQ(info["clean"]["genus"], 1);
  EXPECT_EQ(info["clean"]["triangles"], 196);
  EXPECT_FALSE(info["clean"]["actions"].empty());
  EXPECT_NE(good({"info", path("two.ply")}).out.find("genus 1"), std::string::npos);
}

TEST_F(Commands, ForceOverwritesWholeFiles) {
  save(scratch, "torus.ply", shapes::torus(24, 12));
  scratch.write("t.ncr", "old");
  good({"encode", path("torus.ply"), "-o", path("t.ncr"), "--size", "800", "-f", "--samples",
        "1000", "-q"});
  EXPECT_NE(scratch.read("t.ncr"), "old");
  good({"info", path("t.ncr")});
}

TEST_F(Commands, QuietSaysNothing) {
  save(scratch, "torus.ply", shapes::torus(24, 12));
  const Outcome outcome = good({"encode", path("torus.ply"), "-o", path("t.ncr"), "--size", "800",
                                "--samples", "1000", "-q"});
  EXPECT_EQ(outcome.out + outcome.err, "");
}

}  // namespace
}  // namespace nacre::app::test
