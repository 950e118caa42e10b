// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/goal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "run_command.h"
#include "support/corpus.h"

namespace nacre::app::test {
namespace {

using nlohmann::json;
using Kind = Goal::Kind;

TEST(Goal, QualityHalvesTheStepEveryTwelveAndAHalfPoints) {
  EXPECT_EQ(step_of_quality(0), 1.0 / 16);
  EXPECT_EQ(step_of_quality(100), 1.0 / 4096);
  EXPECT_DOUBLE_EQ(step_of_quality(50) / step_of_quality(62.5), 2);
}

TEST(Goal, UsualFiguresAreMonotoneAndInverse) {
  double psnr = 0, bytes = 0;
  for (double fineness = 2; fineness < 25; fineness += 0.25) {
    const double step = std::exp2(-fineness);
    EXPECT_GT(usual_psnr_db(step), psnr);
    EXPECT_GT(usual_bytes(step), bytes);
    psnr = usual_psnr_db(step);
    bytes = usual_bytes(step);
    EXPECT_NEAR(std::log2(usual_step(psnr)), -fineness, 1e-9);
  }
}

TEST(Goal, BaseAndLevelsGrowWithTheSize) {
  const RemeshSettings small = for_size({}, 1000, 50'000), large = for_size({}, 16'000, 50'000);
  EXPECT_EQ(small.least_base_vertices, 113);
  EXPECT_EQ(large.least_base_vertices, 455);
  EXPECT_EQ(large.most_base_vertices, 1024);
  EXPECT_EQ(large.least_triangles, 528'000u);
  EXPECT_EQ(for_size({}, 1e5, 50'000).least_base_vertices, 480);
  // A base mesh stays much coarser than the scan.
  EXPECT_EQ(for_size({}, 1e6, 800).least_base_vertices, 100);
  EXPECT_EQ(for_size({}, 10, 5).least_base_vertices, 4);
  RemeshSettings own;
  own.base_vertices = 7;
  own.levels = 3;
  EXPECT_EQ(for_size(own, 1000, 50'000).base_vertices, 7);
  EXPECT_EQ(for_size(own, 1000, 50'000).levels, 3);
}

TEST(Goal, OptionsAreThoseOfTheCommandLine) {
  EXPECT_EQ(option_of({Kind::kSize, 6000}), "--size 6000");
  EXPECT_EQ(option_of({Kind::kMaxErrorPercent, 0.02}), "--max-error 0.02%");
  EXPECT_EQ(option_of({Kind::kPsnr, 79.5}), "--psnr 79.5");
  EXPECT_EQ(name_of(Kind::kMaxError), "max_error");
}

class Goals : public testing::Test {
 protected:
  Goals() { save(scratch_, "ball.ply", shapes::bumpy_sphere(4)); }

  Outcome encode(const std::vector<std::string>& goal) const {
    std::vector<std::string> words = {"encode", file("ball.ply"), "-o",   file("ball.ncr"),
                                      "-f",     "--samples",      "20000"};
    words.insert(words.end(), goal.begin(), goal.end());
    return run(words);
  }
  json compared() const {
    const Outcome out = run({"compare", file("ball.ply"), file("ball.ncr"), "--json", "--certify",
                             "--samples", "20000"});
    EXPECT_EQ(out.exit_code, 0) << out.err;
    return json::parse(out.out, nullptr, false);
  }
  /// With the PSNR that compare finds.
  std::pair<Outcome, double> encode_fandisk(const std::string& option,
                                            const std::string& value) const {
    const std::string scan = corpus::mesh("fandisk.obj").string();
    const Outcome out =
        run({"encode", scan, "-o", file("fandisk.ncr"), option, value, "--samples", "20000"});
    EXPECT_EQ(out.exit_code, 0) << out.err;
    const Outcome compared =
        run({"compare", scan, file("fandisk.ncr"), "--json", "--samples", "20000"});
    const json distance = json::parse(compared.out, nullptr, false);
    return {out, distance.is_object() ? distance["psnr_db"].get<double>() : 0.0};
  }
  std::string file(const std::string& name) const { return scratch_.file(name).string(); }
  std::size_t size() const { return scratch_.read("ball.ncr").size(); }

  Scratch scratch_;
};

TEST_F(Goals, ASizeIsHeldAndUsed) {
  for (const std::size_t bytes : {400u, 1500u}) {
    const Outcome out = encode({"--size", std::to_string(bytes)});
    ASSERT_EQ(out.exit_code, 0) << out.err;
    EXPECT_LE(size(), bytes);
    EXPECT_GE(static_cast<double>(size()), 0.995 * static_cast<double>(bytes));
  }
}

TEST_F(Goals, APsnrIsReachedWithinATenthOfADecibel) {
  for (const std::vector<std::string>& coder :
       {std::vector<std::string>{}, {"--profile", "paper"}}) {
    std::vector<std::string> goal = {"--psnr", "75"};
    goal.insert(goal.end(), coder.begin(), coder.end());
    const Outcome out = encode(goal);
    ASSERT_EQ(out.exit_code, 0) << out.err;
    const double psnr = compared()["psnr_db"];
    EXPECT_GE(psnr, 75);
    EXPECT_LE(psnr, 75.1);
  }
}

TEST_F(Goals, AMaximumErrorIsProved) {
  const Outcome out = encode({"--max-error", "0.3%"});
  ASSERT_EQ(out.exit_code, 0) << out.err;
  const json distance = compared();
  EXPECT_LE(distance["certified"]["upper"].get<double>(),
            0.003 * distance["bbox_diagonal"].get<double>() * 1.0001);
}

TEST_F(Goals, NearlyAllThatTheScanHasTakesItsOwnTriangles) {
  const Outcome out = encode({"--psnr", "100"});
  ASSERT_EQ(out.exit_code, 0) << out.err;
  EXPECT_GE(compared()["psnr_db"].get<double>(), 100);
  EXPECT_NE(out.err.find("its own triangles"), std::string::npos) << out.err;
}

TEST_F(Goals, FlatsAndCreasesAreASimplifiedMesh) {
  NACRE_SKIP_WITHOUT("fandisk.obj");
  const auto [out, psnr] = encode_fandisk("--size", "6k");
  EXPECT_LE(scratch_.read("fandisk.ncr").size(), 6000u);
  EXPECT_NE(out.err.find("a simplified mesh"), std::string::npos) << out.err;
  // No semi-regular mesh of that size gets past 80 dB, the scan's own vertices not past 98.
  EXPECT_GT(psnr, 100);
}

TEST_F(Goals, FlatsAndCreasesReachAPsnrInFewBytes) {
  NACRE_SKIP_WITHOUT("fandisk.obj");
  const auto [out, psnr] = encode_fandisk("--psnr", "85");
  EXPECT_LE(scratch_.read("fandisk.ncr").size(), 2400u);
  EXPECT_GE(psnr, 85);
  EXPECT_LE(psnr, 85.1);
}

TEST_F(Goals, WhatCannotBeReachedIsSaidWithTheNearest) {
  const Outcome small = encode({"--size", "20"});
  EXPECT_EQ(small.exit_code, 5);
  EXPECT_NE(small.err.find("nearest is --size"), std::string::npos) << small.err;
  const Outcome fine = encode({"--psnr", "300"});
  EXPECT_EQ(fine.exit_code, 5);
  EXPECT_NE(fine.err.find("nearest is --psnr"), std::string::npos) << fine.err;
  const Outcome held = encode({"--max-error", "0.0001%", "--levels", "2"});
  EXPECT_EQ(held.exit_code, 5);
  EXPECT_NE(held.err.find("nearest is --max-error"), std::string::npos) << held.err;
  EXPECT_NE(held.err.find("--levels"), std::string::npos) << held.err;
  EXPECT_FALSE(std::filesystem::exists(scratch_.file("ball.ncr")));
}

}  // namespace
}  // namespace nacre::app::test
