// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/cli.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

namespace nacre::app {
namespace {

std::vector<std::string> words(const std::string& line) {
  std::istringstream in(line);
  return {std::istream_iterator<std::string>(in), {}};
}

template <class T>
T parsed(const std::string& line) {
  const Result<Command> command = parse_command_line(words(line));
  EXPECT_TRUE(command.has_value()) << line << ": " << command.error().message;
  if (!command) return {};
  const T* typed = std::get_if<T>(&*command);
  EXPECT_NE(typed, nullptr) << line;
  return typed ? *typed : T{};
}

/// The message of a command line that must be refused.
std::string refused(const std::string& line) {
  const Result<Command> command = parse_command_line(words(line));
  EXPECT_FALSE(command.has_value()) << line;
  if (command) return "";
  EXPECT_EQ(command.error().code, ErrorCode::kBadInput) << line;
  EXPECT_EQ(command.error().message.find('\n'), std::string::npos) << command.error().message;
  return command.error().message;
}

TEST(ParseEncode, DefaultsToAQuality) {
  const auto command = parsed<EncodeCommand>("encode scan.ply -o out.ncr");
  EXPECT_EQ(command.scan, "scan.ply");
  EXPECT_EQ(command.output, "out.ncr");
  EXPECT_EQ(command.goal, (Goal{Goal::Kind::kQuality, 75}));
  EXPECT_FALSE(command.has_goal);
  EXPECT_EQ(command.transform, wavelet::Transform::kButterfly);
  EXPECT_EQ(command.theta_degrees, 1.0);
  EXPECT_EQ(command.remesh.levels, 0);
  EXPECT_EQ(command.remesh.base_vertices, 0);
  EXPECT_EQ(command.remesh.repair, remesh::RepairPolicy::kSafe);
  EXPECT_EQ(command.common.threads, 0);
  EXPECT_EQ(command.common.verbosity, Verbosity::kNormal);
  EXPECT_FALSE(command.common.overwrite);
  EXPECT_TRUE(command.report.empty());
}

TEST(ParseEncode, TakesEveryOption) {
  const auto command = parsed<EncodeCommand>(
      "encode --size 6Ki --profile paper --transform loop --theta 0.5 --levels 4 --base-vertices "
      "120 --repair strict --threads 2 --report r.json --samples 2000 -f -v -o out.ncr scan.obj");
  EXPECT_EQ(command.goal, (Goal{Goal::Kind::kSize, 6144}));
  EXPECT_TRUE(command.has_goal);
  EXPECT_EQ(command.profile, codec::Profile::kPaper);
  EXPECT_EQ(command.transform, wavelet::Transform::kLoop);
  EXPECT_EQ(command.theta_degrees, 0.5);
  EXPECT_EQ(command.remesh.levels, 4);
  EXPECT_EQ(command.remesh.base_vertices, 120);
  EXPECT_EQ(command.remesh.repair, remesh::RepairPolicy::kStrict);
  EXPECT_EQ(command.common.threads, 2);
  EXPECT_EQ(command.common.verbosity, Verbosity::kVerbose);
  EXPECT_TRUE(command.common.overwrite);
  EXPECT_EQ(command.report, "r.json");
  EXPECT_EQ(command.samples, 2000u);
  EXPECT_EQ(command.scan, "scan.obj");
}

TEST(ParseEncode, TakesEveryGoal) {
  using Kind = Goal::Kind;
  const auto goal = [](const std::string& words) {
    return parsed<EncodeCommand>("encode a -o b.ncr " + words).goal;
  };
  EXPECT_EQ(goal("--bits-per-vertex 0.25"), (Goal{Kind::kBitsPerInputVertex, 0.25}));
  EXPECT_EQ(goal("--bits-per-vertex=8"), (Goal{Kind::kBitsPerInputVertex, 8}));
  EXPECT_EQ(goal("--bits-per-semi-regular-vertex 0.5"),
            (Goal{Kind::kBitsPerSemiRegularVertex, 0.5}));
  EXPECT_EQ(goal("--psnr 80.5"), (Goal{Kind::kPsnr, 80.5}));
  EXPECT_EQ(goal("--quality 0"), (Goal{Kind::kQuality, 0}));
  EXPECT_EQ(goal("--max-error 0.05"), (Goal{Kind::kMaxError, 0.05}));
  EXPECT_EQ(goal("--max-error 0.02%"), (Goal{Kind::kMaxErrorPercent, 0.02}));
}

TEST(ParseEncode, RefusesWhatItCannotDo) {
  EXPECT_NE(refused("encode").find("SCAN"), std::string::npos);
  EXPECT_NE(refused("encode a").find("-o is required"), std::string::npos);
  for (const char* two : {"--size 4k --bits-per-vertex 1", "--psnr 80 --quality 50",
                          "--max-error 1 --bits-per-semi-regular-vertex 1"}) {
    EXPECT_NE(refused(std::string("encode a -o b.ncr ") + two).find("at most 1"),
              std::string::npos);
  }
  for (const char* bad :
       {"--quality 101", "--quality -1", "--quality nan", "--psnr 0", "--psnr inf", "--max-error 0",
        "--max-error -1", "--max-error 5x", "--max-error nan", "--max-error %"}) {
    refused(std::string("encode a -o b.ncr ") + bad);
  }
  EXPECT_NE(refused("encode a -o b.ncr --size 4q").find("6Ki"), std::string::npos);
  refused("encode a b -o c.ncr");
  refused("encode a -o b.ncr -q -v");
  refused("encode a -o b.ncr --levels 0");
  refused("encode a -o b.ncr --levels 13");
  refused("encode a -o b.ncr --levels x");
  refused("encode a -o b.ncr --base-vertices 3");
  refused("encode a -o b.ncr --threads 0");
  refused("encode a -o b.ncr --size");
  refused("encode a -o b.ncr --size=");
  refused("encode a -o b.ncr --size 0");
  refused("encode a -o b.ncr --repair most");
  refused("encode a -o b.ncr --profile worst");
  for (const char* bad : {"0", "-1", "nan", "inf", "x", "1e400"}) {
    refused(std::string("encode a -o b.ncr --bits-per-vertex ") + bad);
  }
  for (const char* bad : {"-1", "91", "nan", "inf", "x"}) {
    refused(std::string("encode a -o b.ncr --theta ") + bad);
  }
}

TEST(Parse, GuessesWhatWasMeant) {
  EXPECT_NE(refused("encod a").find("did you mean 'encode'"), std::string::npos);
  EXPECT_NE(refused("comapre a b").find("did you mean 'compare'"), std::string::npos);
  EXPECT_EQ(refused("transmogrify a").find("did you mean"), std::string::npos);
  EXPECT_NE(refused("encode a -o b.ncr --sise 4").find("did you mean '--size'"), std::string::npos);
  EXPECT_NE(refused("encode a -o b.ncr --level=4").find("did you mean '--levels'"),
            std::string::npos);
  EXPECT_EQ(refused("encode a -o b.ncr --frobnicate").find("did you mean"), std::string::npos);
  EXPECT_NE(refused("--size 3 encode a").find("verb comes first"), std::string::npos);
  refused("");
}

TEST(ParseDecode, TakesLevelAndPartial) {
  const auto plain = parsed<DecodeCommand>("decode a.ncr -o b.ply");
  EXPECT_TRUE(plain.choice.is_all());
  EXPECT_FALSE(plain.partial);
  const auto command = parsed<DecodeCommand>("decode a.ncr -o b.glb --level 0 --partial -q");
  EXPECT_EQ(command.stream, "a.ncr");
  EXPECT_EQ(command.output, "b.glb");
  EXPECT_EQ(command.choice.level, 0);
  EXPECT_TRUE(command.partial);
  EXPECT_EQ(command.common.verbosity, Verbosity::kQuiet);
  refused("decode a.ncr -o b.ply --level -1");
  EXPECT_EQ(parsed<DecodeCommand>("decode a.ncr -o b.glb --bytes 6k").choice.bytes, 6000u);
  const auto near = parsed<DecodeCommand>("decode a.ncr -o b.glb --max-error 0.5%");
  EXPECT_EQ(near.choice.max_error->value, 0.5);
  EXPECT_TRUE(near.choice.max_error->is_percent);
  refused("decode a.ncr -o b.ply --bytes 6k --max-error 1");
  refused("decode a.ncr -o b.ply --level 1 --max-error 1");
  refused("decode a.ncr");
}

TEST(ParseCut, NeedsAPlace) {
  const auto command = parsed<CutCommand>("cut a.ncr --size 6Ki -o b.ncr -f");
  EXPECT_EQ(command.choice.bytes, 6144u);
  EXPECT_TRUE(command.common.overwrite);
  EXPECT_FALSE(command.partial);
  EXPECT_EQ(parsed<CutCommand>("cut a.ncr --level 2 -o b.ncr").choice.level, 2);
  EXPECT_TRUE(parsed<CutCommand>("cut a.ncr --partial -o b.ncr").partial);
  EXPECT_NE(refused("cut a.ncr -o b.ncr").find("--size"), std::string::npos);
  refused("cut a.ncr --size 1k");
  refused("cut a.ncr --size 1k --level 2 -o b.ncr");
}

TEST(ParseRemesh, SharesTheRemeshOptions) {
  const auto command =
      parsed<RemeshCommand>("remesh a.ply -o b.ply --levels 3 --repair none --report r.json");
  EXPECT_EQ(command.remesh.levels, 3);
  EXPECT_EQ(command.remesh.repair, remesh::RepairPolicy::kNone);
  EXPECT_EQ(command.report, "r.json");
  refused("remesh a.ply -o b.ply --size 4k");
}

TEST(ParseRemesh, TakesStepsToWriteDown) {
  const auto wants = [](const RemeshCommand& command) {
    return std::count(command.dump.stages.begin(), command.dump.stages.end(), true);
  };
  EXPECT_EQ(wants(parsed<RemeshCommand>("remesh a.ply -o b.ply")), 0);
  const auto all = parsed<RemeshCommand>("remesh --work-dir w --dump all a.ply -o b.ply");
  EXPECT_EQ(wants(all), 5);
  EXPECT_EQ(all.dump.work_dir, "w");
  EXPECT_EQ(all.scan, "a.ply");
  const auto two =
      parsed<RemeshCommand>("remesh a.ply -o b.ply --work-dir w --dump base,normal-mesh");
  EXPECT_EQ(wants(two), 2);
  EXPECT_TRUE(two.dump.wants(DumpStage::kBase));
  EXPECT_TRUE(two.dump.wants(DumpStage::kNormalMesh));
  EXPECT_FALSE(two.dump.wants(DumpStage::kClean));
  refused("remesh a.ply -o b.ply --dump all");
  refused("remesh a.ply -o b.ply --work-dir w");
  EXPECT_NE(refused("remesh a.ply -o b.ply --work-dir w --dump bass").find("base"),
            std::string::npos);
}

TEST(ParseCompare, TakesMapAndPicture) {
  const auto plain = parsed<CompareCommand>("compare a.ply b.ncr");
  EXPECT_FALSE(plain.json);
  EXPECT_FALSE(plain.map_max.has_value());
  EXPECT_EQ(plain.samples, 500'000u);
  const auto command = parsed<CompareCommand>(
      "compare a b --json --map m.ply --map-max 0.5 --picture p.png --up z --azimuth -90");
  EXPECT_TRUE(command.json);
  EXPECT_EQ(command.map, "m.ply");
  EXPECT_EQ(command.map_max, 0.5);
  EXPECT_EQ(command.picture, "p.png");
  EXPECT_EQ(command.view.up, View::Up::kZ);
  EXPECT_EQ(command.view.azimuth_deg, -90);
  refused("compare a");
  refused("compare a b --samples 10");
  EXPECT_FALSE(plain.certify);
  EXPECT_EQ(parsed<CompareCommand>("compare a b --certify").certify_percent, 1);
  refused("compare a b --certify-tolerance 2");
  refused("compare a b --certify --certify-tolerance 101");
  refused("compare a b --map-max 1");
  refused("compare a b --map m.ply --map-max 0");
  refused("compare a b --up z");
  refused("compare a b --picture p.png --up w");
  refused("compare a b --picture p.png --elevation 91");
}

TEST(ParseHelp, TeachesByExamples) {
  const std::string general = parsed<PrintText>("--help").text;
  for (const char* verb : {"encode", "decode", "remesh", "compare", "info", "Exit codes"}) {
    EXPECT_NE(general.find(verb), std::string::npos) << verb;
  }
  for (const char* verb : {"encode", "decode", "remesh", "compare", "info"}) {
    const std::string help = parsed<PrintText>(std::string(verb) + " --help").text;
    EXPECT_NE(help.find(std::string("nacre ") + verb), std::string::npos) << help;
    EXPECT_NE(help.find("Example"), std::string::npos) << verb;
  }
}

TEST(ParseHelp, ListsEveryGoal) {
  const std::string help = parsed<PrintText>("encode --help").text;
  for (const char* goal : {"--size", "--bits-per-vertex", "--bits-per-semi-regular-vertex",
                           "--psnr", "--max-error", "--quality"}) {
    EXPECT_NE(help.find(goal), std::string::npos) << goal;
  }
}

TEST(ParseVersion, IsOneLine) {
  const std::string version = parsed<PrintText>("--version").text;
  EXPECT_TRUE(version.starts_with("nacre "));
  EXPECT_EQ(version.find('\n'), version.size() - 1);
}

}  // namespace
}  // namespace nacre::app
