// SPDX-License-Identifier: GPL-3.0-or-later
//
// Prefixes of .ncr files: decode --level | --bytes | --max-error, cut, and the level table behind
// them.
#include "app/prefix.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <regex>

#include "app/cli_prefix.h"
#include "app/files.h"
#include "app/level_table.h"
#include "codec/codec.h"
#include "codec/edit_stream.h"
#include "io/io.h"
#include "run_command.h"
#include "wavelet/wavelet.h"

namespace nacre::app {
namespace {

using nlohmann::json;
using test::Outcome;
using test::run;
using test::Scratch;

/// A coded sphere with waves, four levels over an icosahedron, and the scan it is of.
struct Coded {
  Scan scan;
  std::vector<std::uint8_t> plain, with_table;

  Coded() {
    const Scan base = shapes::icosahedron();
    SemiRegularMesh mesh = {base.triangles, 12, 4, base.positions, Vec3::Zero()};
    const Topology topology = *Topology::build(mesh.base_triangles, 12, 4);
    for (int j = 0; j < 4; ++j) {
      for (const Vec3& p : wavelet::predict(topology, j, mesh.positions).points)
        mesh.positions.push_back(p / p.norm() * (1 + 0.05 * std::sin(5 * p[0])));
    }
    scan = to_triangles(mesh).value();
    codec::EncodeOptions options;
    options.profile = codec::Profile::kBest;
    options.effort = codec::Effort::kFast;
    options.target_bytes = 1500;
    plain = codec::encode(mesh, options).value().bytes;
    with_table = plain;
    const std::atomic<bool> cancel = false;
    Console console(Verbosity::kQuiet, cancel);
    LevelTableOptions table;
    table.samples = 20'000;
    const Result<void> filled = fill_level_table(with_table, scan, table, console);
    if (!filled) throw std::runtime_error(filled.error().message);
  }
};

const Coded& coded() {
  static const Coded made;
  return made;
}

std::string text(const std::vector<std::uint8_t>& bytes) { return {bytes.begin(), bytes.end()}; }

class Prefixes : public testing::Test {
 protected:
  Prefixes() {
    scratch_.write("plain.ncr", text(coded().plain));
    scratch_.write("table.ncr", text(coded().with_table));
  }
  [[nodiscard]] std::string path(const std::string& name) const {
    return scratch_.file(name).string();
  }
  [[nodiscard]] std::size_t vertices(const std::string& name) const {
    return io::read_scan(scratch_.file(name)).value().scan.positions.size();
  }
  void expect_refused(int exit_code, const std::string& words,
                      const std::vector<std::string>& arguments) const {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
    EXPECT_NE(outcome.err.find(words), std::string::npos) << outcome.err;
    EXPECT_FALSE(scratch_.has("out.ply"));
    EXPECT_FALSE(scratch_.has("out.ncr"));
  }

  Scratch scratch_;
  codec::StreamInfo info_ = codec::inspect(coded().with_table).value();
};

std::vector<std::string> words(const std::string& line) {
  std::vector<std::string> found;
  std::istringstream in(line);
  for (std::string word; in >> word;) found.push_back(word);
  return found;
}

TEST(LevelTableOfAScan, EqualsRealDecodes) {
  const codec::StreamInfo info = codec::inspect(coded().with_table).value();
  ASSERT_TRUE(info.level_table.has_value());
  ASSERT_EQ(info.level_table->cuts.size(), 5u);
  for (int level = 0; level <= 4; ++level) {
    codec::DecodeOptions options;
    options.max_level = level;
    const Scan decoded = to_triangles(codec::decode(coded().plain, options).value()).value();
    const metric::Comparison c =
        metric::compare(coded().scan, decoded, {.samples = 20'000}).value();
    const codec::LevelTable::Cut& cut = info.level_table->cuts[static_cast<std::size_t>(level)];
    EXPECT_LE(cut.psnr_db, c.psnr_db) << level;
    EXPECT_GT(cut.psnr_db, c.psnr_db - 0.0501) << level;
    const double largest = std::max(c.a_to_b.maximum, c.b_to_a.maximum);
    EXPECT_GE(cut.max_error, largest) << level;  // a bound on what sampling can find
    const metric::Certified certified = metric::certified_distance(coded().scan, decoded).value();
    EXPECT_GE(cut.max_error, certified.upper()) << level;
    EXPECT_LE(cut.max_error, certified.upper() * 1.008) << level;
  }
}

TEST(LevelTableOfAScan, TakesTheBytesThatWereReserved) {
  EXPECT_EQ(coded().with_table.size() - coded().plain.size(),
            reserved_table_bytes(LevelTableMode::kOn, codec::Profile::kBest, 4, 1));
  const std::size_t bytes = codec::level_table_bytes(codec::Profile::kBest, 4);
  EXPECT_EQ(bytes, 20u);  // a byte of flags, the diagonal, five entries
  const auto reserved = [&](LevelTableMode mode, std::uint64_t target) {
    return reserved_table_bytes(mode, codec::Profile::kBest, 4, target);
  };
  EXPECT_EQ(reserved(LevelTableMode::kAuto, 100 * bytes), bytes);
  EXPECT_EQ(reserved(LevelTableMode::kAuto, 100 * bytes - 1), 0u);
  EXPECT_EQ(reserved(LevelTableMode::kOff, 1'000'000), 0u);
}

TEST(ErrorGoals, AreLengthsOrPerCent) {
  EXPECT_EQ(parse_error_goal("0.05")->value, 0.05);
  EXPECT_FALSE(parse_error_goal("5e-3")->is_percent);
  EXPECT_EQ(parse_error_goal("0.02%")->value, 0.02);
  EXPECT_TRUE(parse_error_goal("0.02 %")->is_percent);
  for (const char* bad : {"", "%", "-1", "0", "0%", "nan", "inf", "1mm", "1 2", "0x3"})
    EXPECT_EQ(parse_error_goal(bad).error().code, ErrorCode::kBadInput) << bad;
}

TEST_F(Prefixes, DecodeReadsNoMoreThanTheLevelNeeds) {
  // Everything behind level 2 is garbage, of which nothing must be read.
  std::string damaged = text(coded().with_table);
  for (std::size_t i = info_.levels[2].bytes; i < damaged.size(); ++i) damaged[i] = '?';
  scratch_.write("damaged.ncr", damaged);
  for (const std::string& choice :
       {std::string("--level 2"), "--bytes " + std::to_string(info_.levels[2].bytes),
        "--max-error " + std::to_string(info_.level_table->cuts[2].max_error * 1.001)}) {
    std::vector<std::string> arguments = {"decode", path("damaged.ncr"), "-o", path("out.ply"),
                                          "-f"};
    for (const std::string& word : words(choice)) arguments.push_back(word);
    const Outcome outcome = run(arguments);
    ASSERT_EQ(outcome.exit_code, 0) << choice << outcome.err;
    EXPECT_EQ(vertices("out.ply"), info_.levels[2].vertices) << choice;
    EXPECT_NE(outcome.err.find("PSNR"), std::string::npos) << outcome.err;
  }
}

TEST_F(Prefixes, BytesGiveTheFinestLevelThatTheyHold) {
  for (std::size_t level = 0; level < info_.levels.size(); ++level) {
    const std::size_t bytes = info_.levels[level].bytes;
    PrefixChoice choice;
    choice.bytes = bytes;
    EXPECT_EQ(read_prefix(path("table.ncr"), choice, false)->level, static_cast<int>(level));
    EXPECT_EQ(read_prefix(path("table.ncr"), choice, false)->bytes.size(), bytes);
    if (level == 0) continue;
    choice.bytes = bytes - 1;
    EXPECT_EQ(read_prefix(path("table.ncr"), choice, false)->level, static_cast<int>(level) - 1);
  }
}

TEST_F(Prefixes, MaxErrorGivesTheCoarsestLevelThatIsNearEnough) {
  const codec::LevelTable& table = *info_.level_table;
  for (std::size_t level = 0; level < table.cuts.size(); ++level) {
    PrefixChoice choice;
    choice.max_error = ErrorGoal{table.cuts[level].max_error, false};
    EXPECT_EQ(chosen_level(info_, choice, "x").value(), static_cast<int>(level));
    choice.max_error = ErrorGoal{100.001 * table.cuts[level].max_error / table.bbox_diagonal, true};
    EXPECT_EQ(chosen_level(info_, choice, "x").value(), static_cast<int>(level));
  }
}

TEST_F(Prefixes, ChoicesThatCannotBeMetSayWhatCan) {
  const std::string in = path("table.ncr"), out = path("out.ply");
  expect_refused(5, std::to_string(info_.levels[0].bytes),
                 {"decode", in, "-o", out, "--bytes", "20"});
  expect_refused(5, "level 4 is nearest", {"decode", in, "-o", out, "--max-error", "1e-9"});
  expect_refused(5, "--level-table on",
                 {"decode", path("plain.ncr"), "-o", out, "--max-error", "1%"});
  expect_refused(2, "levels 0 to 4", {"decode", in, "-o", out, "--level", "5"});
  expect_refused(2, "--bytes", {"decode", in, "-o", out, "--level", "1", "--bytes", "1k"});
  expect_refused(2, "is not an error", {"decode", in, "-o", out, "--max-error", "close"});
  expect_refused(2, "--bytes", {"decode", in, "-o", out, "--bytes", "-3"});
}

TEST_F(Prefixes, AFileCutShortOfTheLevelNeedsPartial) {
  const std::string whole = text(coded().with_table);
  scratch_.write("cut.ncr", whole.substr(0, info_.levels[3].bytes - 1));
  expect_refused(7, "--partial",
                 {"decode", path("cut.ncr"), "-o", path("out.ply"), "--level", "3"});
  expect_refused(7, "--partial takes what is there",
                 {"decode", path("cut.ncr"), "-o", path("out.ply")});
  ASSERT_EQ(run({"decode", path("cut.ncr"), "-o", path("fine.ply"), "--level", "2"}).exit_code, 0);
  ASSERT_EQ(run({"decode", path("cut.ncr"), "-o", path("there.ply"), "--level", "3", "--partial"})
                .exit_code,
            0);
  EXPECT_EQ(vertices("fine.ply"), info_.levels[2].vertices);
  EXPECT_EQ(vertices("there.ply"), info_.levels[2].vertices);
}

TEST_F(Prefixes, CutMakesAFileThatDecodesAsItsLevelDoes) {
  for (int level = 0; level <= 4; ++level) {
    const std::string at = std::to_string(level);
    ASSERT_EQ(
        run({"cut", path("table.ncr"), "--level", at, "-o", path("small.ncr"), "-f"}).exit_code, 0);
    ASSERT_EQ(run({"decode", path("small.ncr"), "-o", path("a.ply"), "-f"}).exit_code, 0);
    ASSERT_EQ(
        run({"decode", path("table.ncr"), "--level", at, "-o", path("b.ply"), "-f"}).exit_code, 0);
    EXPECT_EQ(scratch_.read("a.ply"), scratch_.read("b.ply")) << level;
  }
}

TEST_F(Prefixes, CutToASizeIsTheFinestThatFits) {
  for (std::size_t most = 200; most <= coded().with_table.size() + 50; most += 97) {
    const Outcome outcome = run(
        {"cut", path("table.ncr"), "--size", std::to_string(most), "-o", path("small.ncr"), "-f"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const std::string small = scratch_.read("small.ncr");
    EXPECT_LE(small.size(), most);
    const std::vector<std::uint8_t> bytes(small.begin(), small.end());
    const auto level = static_cast<int>(codec::inspect(bytes).value().levels.size()) - 1;
    if (level < 4) {
      EXPECT_GT(codec::cut_at_level(coded().with_table, level + 1).value().size(), most);
    }
  }
}

TEST_F(Prefixes, CutByErrorKeepsThePromise) {
  const double error = info_.level_table->cuts[1].max_error;
  ASSERT_EQ(run({"cut", path("table.ncr"), "--max-error", std::to_string(error * 1.01), "-o",
                 path("small.ncr")})
                .exit_code,
            0);
  const std::string small = scratch_.read("small.ncr");
  const codec::StreamInfo info =
      codec::inspect(std::vector<std::uint8_t>(small.begin(), small.end())).value();
  EXPECT_EQ(info.levels.size(), 2u);
  EXPECT_EQ(info.level_table->cuts.back().max_error, error);
}

TEST_F(Prefixes, CutRefusesWithARemedy) {
  const std::string in = path("table.ncr"), out = path("out.ncr");
  expect_refused(2, "--size", {"cut", in, "-o", out});
  expect_refused(5, "base mesh alone", {"cut", in, "--size", "30", "-o", out});
  expect_refused(5, "level 4 is nearest", {"cut", in, "--max-error", "1e-9", "-o", out});
  expect_refused(5, "--level-table on", {"cut", path("plain.ncr"), "--max-error", "1%", "-o", out});
  expect_refused(2, "levels 0 to 4", {"cut", in, "--level", "9", "-o", out});
  expect_refused(2, ".ncr", {"cut", in, "--level", "1", "-o", path("out.ply")});
  expect_refused(2, "is the input itself", {"cut", in, "--level", "1", "-o", in, "-f"});
  expect_refused(3, "no.ncr", {"cut", path("no.ncr"), "--level", "1", "-o", out});
  expect_refused(2, "exists", {"cut", in, "--level", "1", "-o", path("plain.ncr")});
  std::string damaged = text(coded().with_table);
  damaged[info_.sections[2].offset + 1] ^= 1;
  scratch_.write("damaged.ncr", damaged);
  expect_refused(7, "checksum", {"cut", path("damaged.ncr"), "--level", "1", "-o", out});
}

TEST_F(Prefixes, CutMakesAWholeFileOfOneThatIsCutShort) {
  scratch_.write("part.ncr", text(coded().with_table).substr(0, info_.levels[2].bytes + 3));
  EXPECT_EQ(run({"info", path("part.ncr")}).exit_code, 0);
  ASSERT_EQ(run({"cut", path("part.ncr"), "--partial", "-o", path("whole.ncr")}).exit_code, 0);
  ASSERT_EQ(run({"decode", path("whole.ncr"), "-o", path("a.ply")}).exit_code, 0);
  EXPECT_EQ(vertices("a.ply"), info_.levels[2].vertices);
}

TEST_F(Prefixes, InfoTellsTheTableOrThatThereIsNone) {
  const json with = json::parse(run({"info", path("table.ncr"), "--json"}).out);
  EXPECT_EQ(with["level_table"], true);
  EXPECT_EQ(with["levels"].size(), 5u);
  for (std::size_t j = 0; j < 5; ++j) {
    EXPECT_EQ(with["levels"][j]["psnr_db"], info_.level_table->cuts[j].psnr_db);
    EXPECT_EQ(with["levels"][j]["max_error"], info_.level_table->cuts[j].max_error);
    EXPECT_EQ(with["levels"][j]["prefix_bytes"], info_.levels[j].bytes);
  }
  codec::LevelTable table = *info_.level_table;
  table.cuts[1] = {0, std::numeric_limits<double>::infinity()};
  scratch_.write("gap.ncr", text(codec::with_quality(coded().plain, table).value()));
  const std::string gap = run({"info", path("gap.ncr")}).out;
  EXPECT_EQ(gap.find("inf"), std::string::npos) << gap;
  EXPECT_TRUE(std::regex_search(gap, std::regex("\n1 .* - +-\n"))) << gap;
  const json without = json::parse(run({"info", path("plain.ncr"), "--json"}).out);
  EXPECT_EQ(without["level_table"], false);
  EXPECT_TRUE(without["levels"][0]["psnr_db"].is_null());
  EXPECT_NE(run({"info", path("plain.ncr")}).out.find("no level table"), std::string::npos);
  EXPECT_NE(run({"info", path("table.ncr")}).out.find("PSNR dB"), std::string::npos);
}

TEST_F(Prefixes, CompareCertifiesAndSaysWhere) {
  const test::Outcome json_outcome = run({"compare", path("plain.ncr"), path("table.ncr"), "--json",
                                          "--samples", "2000", "--certify"});
  ASSERT_EQ(json_outcome.exit_code, 0) << json_outcome.err;
  EXPECT_LT(json::parse(json_outcome.out)["certified"]["upper"], 1e-9);
  test::save(scratch_, "scan.ply", coded().scan);
  const Outcome outcome = run({"compare", path("scan.ply"), path("plain.ncr"), "--samples", "2000",
                               "--certify", "--certify-tolerance", "0.5"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const char* word :
       {"max certified", "two-sided maximum: at most", "on A at", "on B at", "distance below"})
    EXPECT_NE(outcome.out.find(word), std::string::npos) << outcome.out;
  const json report = json::parse(run({"compare", path("scan.ply"), path("plain.ncr"), "--samples",
                                       "2000", "--certify", "--json"})
                                      .out);
  EXPECT_LE(report["certified"]["lower"], report["certified"]["upper"]);
  EXPECT_GE(report["certified"]["upper"], report["max"]["value"]);
  EXPECT_EQ(
      run({"compare", path("scan.ply"), path("plain.ncr"), "--certify-tolerance", "1"}).exit_code,
      2);
}

}  // namespace
}  // namespace nacre::app
