// SPDX-License-Identifier: GPL-3.0-or-later
//
// Runs that stop, go on, and go on after an edit, with the built command. The scan is remeshed
// three times in all, which is most of the time.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "app/files.h"
#include "app/npy.h"
#include "codec/decode.h"
#include "io/io.h"
#include "run_command.h"
#include "support/random.h"

namespace nacre::app::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A wavy sheet: one boundary, no symmetry.
Scan sheet() {
  Scan scan = shapes::grid(20, 20);
  for (Vec3& p : scan.positions) p[2] = 2 * std::sin(p[0] / 4) * std::cos(p[1] / 5 + p[0] / 9);
  return scan;
}

const std::vector<std::string> kMeshOptions = {"--levels", "3",         "--base-vertices",
                                               "24",       "--samples", "1000"};
const std::vector<std::string> kGoal = {"--size", "700"};

std::vector<std::string> joined(std::vector<std::string> a, const std::vector<std::string>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

class StageRun : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    scratch = new Scratch;
    save(*scratch, "scan.ply", sheet());
    const Outcome outcome =
        run(joined(encode("out.ncr"), joined(kGoal, {"--work-dir", path("w"), "--dump", "all"})));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    whole = scratch->read("out.ncr");
    ASSERT_FALSE(whole.empty());
  }
  static void TearDownTestSuite() {
    delete scratch;
    scratch = nullptr;
  }

  static std::string path(const std::string& name) { return scratch->file(name).string(); }
  static std::vector<std::string> encode(const std::string& output) {
    return joined({"encode", path("scan.ply"), "-o", path(output), "-f"}, kMeshOptions);
  }
  /// The bytes of a run from a stage; what it says is in `last`.
  std::string from(const std::string& stage, const std::vector<std::string>& options) {
    last = run(joined(encode("again.ncr"), joined({"--from", path(stage)}, options)));
    EXPECT_EQ(last.exit_code, 0) << last.err;
    return last.exit_code == 0 ? scratch->read("again.ncr") : "";
  }
  void expect_error(int code, const std::string& named, const std::vector<std::string>& arguments) {
    last = run(arguments);
    EXPECT_EQ(last.exit_code, code) << last.err;
    EXPECT_NE(last.err.find(named), std::string::npos) << last.err;
  }
  void expect_from_error(int code, const std::string& named, const std::string& stage) {
    expect_error(code, named, joined(encode("no.ncr"), {"--from", path(stage), "-q"}));
    EXPECT_FALSE(scratch->has("no.ncr"));
  }

  /// A copy of the work folder to edit.
  static std::string copy(const std::string& name) {
    fs::remove_all(scratch->file(name));
    fs::copy(scratch->file("w"), scratch->file(name), fs::copy_options::recursive);
    return name;
  }
  template <class Row>
  static std::vector<Row> array(const std::string& name) {
    const std::string bytes = scratch->read(name);
    const auto rows =
        from_npy<Row>(std::span(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()));
    EXPECT_TRUE(rows.has_value()) << name;
    return rows ? *rows : std::vector<Row>();
  }
  template <class Row>
  static void set_array(const std::string& name, const std::vector<Row>& rows) {
    const auto bytes = to_npy(std::span<const Row>(rows));
    scratch->write(name, std::string(bytes.begin(), bytes.end()));
  }
  static SemiRegularMesh decoded(const std::string& bytes) {
    const auto mesh =
        codec::decode(std::span(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()));
    EXPECT_TRUE(mesh.has_value());
    return mesh ? *mesh : SemiRegularMesh{};
  }
  static double distance_to_base(const SemiRegularMesh& mesh, const Vec3& place) {
    double least = 1e300;
    for (std::size_t v = 0; v < mesh.base_vertex_count; ++v)
      least = std::min(least, (mesh.positions[v] + mesh.origin - place).norm());
    return least;
  }
  /// Of the third band's section.
  static std::size_t last_band_bytes(const std::string& bytes) {
    const auto info = codec::inspect(
        std::span(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()));
    EXPECT_TRUE(info.has_value());
    return info && info->sections.size() > 4 ? info->sections[4].bytes : 0;
  }
  /// A base vertex well inside of the sheet.
  static std::size_t inner_vertex(const std::vector<Vec3>& positions, std::size_t count) {
    std::size_t best = 0;
    double least = 1e300;
    for (std::size_t v = 0; v < count; ++v) {
      const double d = std::hypot(positions[v][0] - 10, positions[v][1] - 10);
      if (d >= least) continue;
      least = d;
      best = v;
    }
    return best;
  }

  static Scratch* scratch;
  static std::string whole;
  Outcome last;
};

Scratch* StageRun::scratch = nullptr;
std::string StageRun::whole;

TEST_F(StageRun, GoingOnFromAnyStageMakesTheSameBytes) {
  for (const char* stage : {"01-input", "02-clean", "03-base", "04-parameterisation",
                            "05-normal-mesh", "06-coefficients", "07-rd-curves"}) {
    EXPECT_TRUE(from(std::string("w/") + stage, kGoal) == whole) << stage;
    EXPECT_NE(last.err.find("as it was dumped"), std::string::npos) << last.err;
  }
  for (const char* stage : {"08-steps", "09-symbols", "10-stream"})
    EXPECT_TRUE(from(std::string("w/") + stage, {}) == whole) << stage;
}

TEST_F(StageRun, TheSameForProfilePaperAndLoopWavelets) {
  const std::vector<std::string> coder = {"--profile", "paper",       "--theta",
                                          "3",         "--transform", "loop"};
  const std::string paper =
      from("w/05-normal-mesh",
           joined(joined(kGoal, coder), {"--work-dir", path("paper"), "--dump", "all"}));
  EXPECT_FALSE(scratch->has("paper/05-normal-mesh"));
  EXPECT_FALSE(paper == whole);
  for (const char* stage : {"06-coefficients", "07-rd-curves"})
    EXPECT_TRUE(from(std::string("paper/") + stage, joined(kGoal, coder)) == paper) << stage;
  for (const char* stage : {"08-steps", "09-symbols", "10-stream"}) {
    const std::string report = std::string("paper/") + stage + ".json";
    EXPECT_TRUE(from(std::string("paper/") + stage, {"--report", path(report)}) == paper) << stage;
    const json options = json::parse(scratch->read(report))["options"];
    EXPECT_EQ(options["profile"], "paper") << stage;
    EXPECT_EQ(options["transform"], "loop") << stage;
  }
  EXPECT_GT((array<std::array<double, 3>>("paper/07-rd-curves/band-0.npy").size()), 3u);
}

/// A bumpy ball, and beside it one of noise, which is its own base mesh.
Scan ball_and_tangle() {
  Scan tangle = shapes::sphere(3);
  TestRandom random(3);
  for (Vec3& p : tangle.positions) p += 0.5 * random.point() + Vec3(4, 0, 0);
  return shapes::joined(shapes::bumpy_sphere(5), tangle);
}

TEST(StageRunOfPieces, OneThatIsItsOwnBaseGoesThroughDumps) {
  Scratch scratch;
  save(scratch, "scan.ply", ball_and_tangle());
  const auto path = [&](const std::string& name) { return scratch.file(name).string(); };
  const auto bytes = [&](const std::string& output, const std::vector<std::string>& options) {
    const Outcome outcome = run(
        joined({"encode", path("scan.ply"), "-o", path(output), "--levels", "2", "--base-vertices",
                "60", "--samples", "1000", "--effort", "fast", "--size", "9000"},
               options));
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return outcome.exit_code == 0 ? scratch.read(output) : "";
  };
  const std::string whole =
      bytes("out.ncr", {"--work-dir", path("w"), "--dump", "all", "--report", path("report.json")});
  ASSERT_FALSE(whole.empty());
  const json report = json::parse(scratch.read("report.json"));
  ASSERT_EQ(report["pieces"].size(), 2u);
  EXPECT_EQ(report["pieces"][1]["is_own_base"], true) << report["pieces"][1];
  for (const char* stage : {"03-base", "04-parameterisation", "05-normal-mesh"})
    EXPECT_TRUE(bytes(std::string(stage) + ".ncr", {"--from", path(std::string("w/") + stage)}) ==
                whole)
        << stage;
}

TEST_F(StageRun, RecordsFollowOneAnother) {
  std::string parent;
  for (const auto& entry : std::set<fs::path>{fs::directory_iterator(scratch->file("w")), {}}) {
    const json record = json::parse(scratch->read(fs::path("w") / entry.filename() / "stage.json"));
    EXPECT_EQ(record["schema"], "nacre-stage/1");
    if (!parent.empty()) {
      EXPECT_EQ(record["parent"], parent) << entry;
    }
    parent = record["hash"];
  }
  for (const char* mesh :
       {"02-clean/clean.ply", "05-normal-mesh/level-3.ply", "06-coefficients/details.ply"})
    EXPECT_TRUE(io::read_scan(scratch->file("w") / mesh).has_value()) << mesh;
}

TEST_F(StageRun, AMovedBaseVertexStaysWhereItWasPut) {
  const std::string w = copy("moved");
  const std::string ply = w + "/05-normal-mesh/level-0.ply";
  auto base = io::read_scan(scratch->file(ply));
  ASSERT_TRUE(base.has_value());
  const std::size_t v = inner_vertex(base->scan.positions, base->scan.positions.size());
  base->scan.positions[v] += Vec3(0.25, 0.5, 3);
  const Vec3 place = base->scan.positions[v];
  save(*scratch, ply, base->scan);
  const SemiRegularMesh mesh =
      decoded(from(w + "/05-normal-mesh", {"--size", "3000", "--report", path("moved.json")}));
  EXPECT_LT(distance_to_base(mesh, place), 0.1);
  EXPECT_GT(distance_to_base(decoded(whole), place), 2);
  const json report = json::parse(scratch->read("moved.json"));
  EXPECT_EQ(report["from"]["stage"], "05-normal-mesh");
  EXPECT_EQ(report["from"]["is_edited"], true);
  EXPECT_EQ(report["from"]["edited"], json::array({"level-0.ply"}));
  EXPECT_NE(last.err.find("edited: level-0.ply"), std::string::npos) << last.err;
}

TEST_F(StageRun, ABaseVertexMovedBeforePiercingLandsOnTheScan) {
  const std::string w = copy("slid");
  auto positions = array<Vec3>(w + "/03-base/positions.npy");
  const std::size_t v = inner_vertex(positions, positions.size());
  const Vec3 was = positions[v];
  positions[v] += Vec3(0.8, 0.3, 0.2);
  set_array(w + "/03-base/positions.npy", positions);
  last = run({"encode", path("scan.ply"), "--from", path(w + "/03-base"), "--work-dir",
              path("slid2"), "--until", "normal-mesh", "--levels", "3", "--base-vertices", "24"});
  ASSERT_EQ(last.exit_code, 0) << last.err;
  const auto before = array<Vec3>("w/05-normal-mesh/positions.npy");
  const auto after = array<Vec3>("slid2/05-normal-mesh/positions.npy");
  ASSERT_EQ(before.size(), after.size());
  std::size_t moved = 0;
  for (std::size_t i = 0; i < positions.size(); ++i) moved += before[i] != after[i];
  EXPECT_EQ(moved, 1u);
  EXPECT_LT((after[v] - positions[v]).norm(), 0.5);
  EXPECT_GT((after[v] - was).norm(), 0.4);
}

TEST_F(StageRun, AChangedStepIsTheOneThatIsUsed) {
  const std::string w = copy("step");
  json steps = json::parse(scratch->read(w + "/08-steps/steps.json"));
  const int index = steps["steps"][1]["index"];
  steps["steps"][1]["index"] = index + 32;
  scratch->write(w + "/08-steps/steps.json", steps.dump());
  const std::string bytes = from(w + "/08-steps", {});
  const auto info =
      codec::inspect(std::span(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()));
  ASSERT_TRUE(info.has_value());
  EXPECT_NEAR(info->sections[2].step, std::exp2((index + 32) / 32.0), 1e-9);
  EXPECT_FALSE(bytes == whole);
}

TEST_F(StageRun, AnEditOfTheMeshBesideTheStepsIsMarkedAndNotTakenForTheOld) {
  const std::string w = copy("beside");
  const std::vector<std::string> dump = {"--work-dir", path("after"), "--dump", "symbols"};
  const auto symbols = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments =
        joined({"encode", path("scan.ply"), "-o", path("beside.ncr"), "--samples", "1000", "--from",
                path(w + "/08-steps")},
               joined(dump, more));
    return run(arguments);
  };
  last = symbols({});
  EXPECT_EQ(last.exit_code, 0) << last.err;
  EXPECT_NE(last.err.find("as it was dumped"), std::string::npos) << last.err;
  auto positions = array<Vec3>(w + "/06-coefficients/positions.npy");
  positions[inner_vertex(positions, 24)] += Vec3(0, 0, 0.5);
  set_array(w + "/06-coefficients/positions.npy", positions);
  fs::remove(scratch->file("beside.ncr"));
  last = symbols({});
  EXPECT_EQ(last.exit_code, 2) << last.err;
  EXPECT_NE(last.err.find("after/09-symbols: is of another scan"), std::string::npos) << last.err;
  last = symbols({"-f"});
  EXPECT_EQ(last.exit_code, 0) << last.err;
  EXPECT_NE(last.err.find("edited: ../06-coefficients/positions.npy"), std::string::npos)
      << last.err;
}

TEST_F(StageRun, AZeroedBandIsZero) {
  const std::string w = copy("zeroed");
  auto points = array<std::array<std::int32_t, 3>>(w + "/09-symbols/band-1.npy");
  points.assign(points.size(), {0, 0, 0});
  set_array(w + "/09-symbols/band-1.npy", points);
  const std::string bytes = from(w + "/09-symbols", {});
  const auto info =
      codec::inspect(std::span(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()));
  ASSERT_TRUE(info.has_value());
  EXPECT_TRUE(info->sections.size() <= 3 || info->sections[3].bytes == 0);

  const std::size_t with_details = last_band_bytes(from(w + "/06-coefficients", {"--size", "3k"}));
  auto details = array<Vec3>(w + "/06-coefficients/band-2.npy");
  details.assign(details.size(), Vec3::Zero());
  set_array(w + "/06-coefficients/band-2.npy", details);
  // But for what quantising the coarser bands leaves, there is nothing to code.
  EXPECT_LT(last_band_bytes(from(w + "/06-coefficients", {"--size", "3k"})), with_details / 2);
}

TEST_F(StageRun, StagesThatAreThereAreUsed) {
  const std::vector<std::string> again =
      joined({"--work-dir", path("w"), "--dump", "all", "-v"}, kGoal);
  const auto time = fs::last_write_time(scratch->file("w/05-normal-mesh/stage.json"));
  last = run(joined(encode("same.ncr"), again));
  ASSERT_EQ(last.exit_code, 0) << last.err;
  EXPECT_NE(last.err.find("05-normal-mesh is as it would be made again: used"), std::string::npos)
      << last.err;
  EXPECT_TRUE(scratch->read("same.ncr") == whole);
  EXPECT_EQ(fs::last_write_time(scratch->file("w/05-normal-mesh/stage.json")), time);

  const std::string w = copy("late");  // only late options change
  std::vector<std::string> late =
      joined(encode("late.ncr"), {"--work-dir", path(w), "--dump", "all", "-v", "--size", "500"});
  last = run(late);
  EXPECT_EQ(last.exit_code, 0) << last.err;
  EXPECT_NE(last.err.find("used"), std::string::npos) << last.err;
  EXPECT_EQ(scratch->read("late.ncr").size(), scratch->read(w + "/10-stream/stream.ncr").size());
}

TEST_F(StageRun, OtherStagesAreNotOverwrittenUnasked) {
  const std::vector<std::string> other = {
      "encode", path("scan.ply"), "-o",      path("no.ncr"), "--levels",
      "2",      "--work-dir",     path("w"), "--dump",       "base"};
  expect_error(2, "w/03-base: is of another scan, other options", other);
  const std::string w = copy("mine");
  scratch->write(w + "/02-clean/clean.ply", "edited");
  expect_error(2, "02-clean: was edited; use --from",
               joined({"encode", path("scan.ply"), "-o", path("no.ncr"), "--work-dir", path(w),
                       "--dump", "clean", "--size", "700"},
                      kMeshOptions));
}

TEST_F(StageRun, ListSaysWhatIsThereAndWhatWasEdited) {
  const std::string w = copy("listed");
  scratch->write(w + "/05-normal-mesh/level-1.ply", "edited");
  last = run({"stage", "list", path(w)});
  EXPECT_EQ(last.exit_code, 0) << last.err;
  EXPECT_EQ(std::ranges::count(last.out, '\n'), 10);
  EXPECT_NE(last.out.find("edited: level-1.ply"), std::string::npos) << last.out;
  EXPECT_EQ(last.out.find("not made from"), std::string::npos) << last.out;
  const json list = json::parse(run({"stage", "list", path(w), "--json"}).out);
  ASSERT_EQ(list["stages"].size(), 10u);
  EXPECT_EQ(list["stages"][4]["edited"], json::array({"level-1.ply"}));
  EXPECT_EQ(list["stages"][4]["follows"], true);
}

TEST_F(StageRun, DiffNamesTheFirstStageThatDiffersAndByHowMuch) {
  const std::string w = copy("differs");
  auto positions = array<Vec3>(w + "/05-normal-mesh/positions.npy");
  positions[7][1] += 0.5;
  positions[9][2] -= 0.25;
  set_array(w + "/05-normal-mesh/positions.npy", positions);
  last = run({"stage", "diff", path("w"), path(w)});
  EXPECT_EQ(last.exit_code, 0) << last.err;
  EXPECT_NE(last.out.find("first that differs: 05-normal-mesh"), std::string::npos) << last.out;
  EXPECT_NE(last.out.find("2 of "), std::string::npos) << last.out;
  const json diff = json::parse(run({"stage", "diff", path("w"), path(w), "--json"}).out);
  EXPECT_EQ(diff["same"], false);
  EXPECT_EQ(diff["first_different"], "05-normal-mesh");
  EXPECT_EQ(diff["same_stages"].size(), 4u);
  EXPECT_EQ(diff["files"][0]["rows_different"], 2);
  EXPECT_NEAR(diff["files"][0]["largest"].get<double>(), 0.5, 1e-12);
  EXPECT_EQ(diff["files"][0]["largest_row"], 7);
  const double rms = std::sqrt((0.25 + 0.0625) / (3.0 * static_cast<double>(positions.size())));
  EXPECT_NEAR(diff["files"][0]["rms"].get<double>(), rms, 1e-12);
  EXPECT_EQ(json::parse(run({"stage", "diff", path("w"), path("w"), "--json"}).out)["same"], true);
}

TEST_F(StageRun, WhatIsNoStageIsRefused) {
  expect_from_error(3, "nothing: is not the folder of a stage", "nothing");
  expect_from_error(3, "has no stage.json", "w");
  const std::string w = copy("broken");
  scratch->write(w + "/07-rd-curves/band-0.npy", "edited");
  expect_from_error(2, "to be looked at only", w + "/07-rd-curves");
  scratch->write(w + "/05-normal-mesh/positions.npy", "short");
  expect_from_error(3, "positions.npy: is no .npy file", w + "/05-normal-mesh");
  fs::remove(scratch->file(w + "/06-coefficients/base-triangles.npy"));
  expect_from_error(3, "base-triangles.npy", w + "/06-coefficients");
  fs::remove_all(scratch->file(w + "/06-coefficients"));
  expect_from_error(3, "needs 06-coefficients beside it", w + "/08-steps");
  fs::remove_all(scratch->file(w + "/04-parameterisation"));
  expect_from_error(3, "needs 04-parameterisation beside it", w + "/03-base");
  scratch->write(w + "/10-stream/stream.ncr", whole.substr(0, whole.size() / 2));
  expect_from_error(7, "stream.ncr", w + "/10-stream");
}

TEST_F(StageRun, EditsThatDoNotFitAreRefused) {
  const std::string w = copy("misfit");
  auto triangles = array<Triangle>(w + "/02-clean/triangles.npy");
  triangles[3][1] = 1'000'000;
  set_array(w + "/02-clean/triangles.npy", triangles);
  expect_from_error(4, "triangle 3 names vertex 1000000", w + "/02-clean");
  auto scan_vertex = array<std::uint32_t>(w + "/04-parameterisation/scan-vertex.npy");
  std::swap(scan_vertex[0], scan_vertex[1]);
  set_array(w + "/04-parameterisation/scan-vertex.npy", scan_vertex);
  expect_from_error(4, "the map holds for its own triangles", w + "/04-parameterisation");
  auto positions = array<Vec3>(w + "/05-normal-mesh/positions.npy");
  positions.pop_back();
  set_array(w + "/05-normal-mesh/positions.npy", positions);
  expect_from_error(4, "no number of splits", w + "/05-normal-mesh");
  scratch->write(w + "/08-steps/steps.json", R"({"profile": "best"})");
  expect_from_error(3, "steps.json: needs", w + "/08-steps");
  auto details = array<Vec3>(w + "/06-coefficients/band-0.npy");
  details[0][0] = std::nan("");
  set_array(w + "/06-coefficients/band-0.npy", details);
  expect_from_error(4, "row 0 is no usable point", w + "/06-coefficients");
  auto points = array<std::array<std::int32_t, 3>>(w + "/09-symbols/band-0.npy");
  points.pop_back();
  set_array(w + "/09-symbols/band-0.npy", points);
  expect_from_error(4, "one point per detail", w + "/09-symbols");
}

TEST_F(StageRun, OptionsThatDoNotGoTogether) {
  const std::string scan = path("scan.ply"), out = path("no.ncr"), dir = path("none");
  expect_error(2, "--dump needs --work-dir", {"encode", scan, "-o", out, "--dump", "all"});
  expect_error(2, "--work-dir needs --dump", {"encode", scan, "-o", out, "--work-dir", dir});
  expect_error(2, "--until needs --work-dir", {"encode", scan, "--until", "base"});
  expect_error(2, "leave out -o",
               {"encode", scan, "-o", out, "--until", "base", "--work-dir", dir});
  expect_error(2, "-o is required", {"encode", scan});
  expect_error(2, "-o is required", {"remesh", scan});
  expect_error(
      2, "lies before --from",
      {"encode", scan, "--until", "clean", "--work-dir", dir, "--from", path("w/05-normal-mesh")});
  expect_error(2, "has its size already",
               {"encode", scan, "-o", out, "--size", "1k", "--from", path("w/08-steps")});
  expect_error(2, "is a stage of encode",
               {"remesh", scan, "-o", path("no.ply"), "--from", path("w/06-coefficients")});
  expect_error(2, "profile nmc has no steps",
               {"encode", scan, "-o", out, "--profile", "nmc", "--work-dir", dir, "--dump", "all"});
  expect_error(2, "stage diff takes two folders", {"stage", "diff", path("w")});
  expect_error(2, "stage list takes one folder", {"stage", "list", path("w"), path("w")});
  expect_error(3, "none: is not a folder", {"stage", "list", dir});
  expect_error(2, "--reference requires --semi-regular",
               {"encode", scan, "-o", out, "--reference", scan});
  expect_error(2, "--max-memory", {"encode", scan, "-o", out, "--max-memory", "lots"});
  EXPECT_FALSE(scratch->has("no.ncr"));
  EXPECT_FALSE(scratch->has("none"));
}

TEST_F(StageRun, RemeshGoesOnFromItsStages) {
  last = run({"remesh", path("scan.ply"), "-o", path("semi.ply"), "--from",
              path("w/04-parameterisation"), "--samples", "1000"});
  ASSERT_EQ(last.exit_code, 0) << last.err;
  const auto semi = io::read_scan(scratch->file("semi.ply"));
  ASSERT_TRUE(semi.has_value());
  const auto positions = array<Vec3>("w/05-normal-mesh/positions.npy");
  EXPECT_EQ(semi->scan.positions.size(), positions.size());
}

TEST_F(StageRun, SemiRegularMeshesAreCodedAsTheyAre) {
  const auto semi = io::read_scan(scratch->file("w/05-normal-mesh/level-3.ply"));
  ASSERT_TRUE(semi.has_value());
  Scan other = semi->scan;  // another order of triangles
  std::ranges::reverse(other.triangles);
  save(*scratch, "semi.off", other);
  last = run({"encode", path("semi.off"), "-o", path("semi.ncr"), "--semi-regular", "--size", "4k",
              "--samples", "1000", "--report", path("semi.json"), "-f"});
  ASSERT_EQ(last.exit_code, 0) << last.err;
  const json itself = json::parse(scratch->read("semi.json"));
  EXPECT_EQ(itself["remesh"]["levels"], 3);
  EXPECT_TRUE(itself["remesh_psnr_db"].is_null() || itself["remesh_psnr_db"] > 120);
  EXPECT_EQ(decoded(scratch->read("semi.ncr")).positions.size(), semi->scan.positions.size());

  last = run({"encode", path("semi.off"), "-o", path("semi.ncr"), "--semi-regular", "--reference",
              path("scan.ply"), "--size", "4k", "--samples", "1000", "--report",
              path("against.json"), "-f"});
  ASSERT_EQ(last.exit_code, 0) << last.err;
  const json against = json::parse(scratch->read("against.json"));
  EXPECT_LT(against["remesh_psnr_db"].get<double>(), 110);
  EXPECT_GT(against["remesh_psnr_db"].get<double>(), 30);

  save(*scratch, "irregular.ply", shapes::icosahedron());
  expect_error(4, "irregular.ply: has no subdivision connectivity",
               {"encode", path("irregular.ply"), "-o", path("no.ncr"), "--semi-regular"});
  expect_error(
      4, "was split 3 times, 9 were asked for",
      {"encode", path("semi.off"), "-o", path("no.ncr"), "--semi-regular", "--levels", "9"});
  expect_error(2, "--semi-regular has no stages",
               {"encode", path("semi.off"), "--semi-regular", "--until", "base", "--work-dir",
                path("none")});
}

TEST_F(StageRun, EstimatesAndLimits) {
  last = run({"encode", path("scan.ply"), "--dry-run"});
  EXPECT_EQ(last.exit_code, 0) << last.err;
  EXPECT_NE(last.out.find("800 faces; about"), std::string::npos) << last.out;
  EXPECT_NE(last.out.find("nothing was written"), std::string::npos);
  expect_error(6, "over --max-memory 100 MB",
               {"encode", path("scan.ply"), "-o", path("no.ncr"), "--max-memory", "100M"});
  expect_error(6, "took more than --max-memory 1.00 MB",
               {"encode", path("scan.ply"), "-o", path("no.ncr"), "--max-memory", "1M"});
  EXPECT_FALSE(scratch->has("no.ncr"));
  last =
      run(joined(encode("again.ncr"),
                 joined(kGoal, {"--from", path("w/05-normal-mesh"), "-q", "--progress", "json"})));
  EXPECT_EQ(last.exit_code, 0);
  std::size_t lines = 0;
  std::istringstream stream(last.err);
  for (std::string line; std::getline(stream, line); ++lines) {
    const json progress = json::parse(line, nullptr, false);
    ASSERT_TRUE(progress.is_object()) << line;
    EXPECT_TRUE(progress["progress"]["stage"].is_string());
    EXPECT_LE(progress["progress"]["fraction"].get<double>(), 1);
  }
  EXPECT_GT(lines, 1u);
}

}  // namespace
}  // namespace nacre::app::test
