// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/symbols.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "codec/decode.h"
#include "codec/recode.h"
#include "synthetic.h"

namespace nacre::codec {
namespace {

using Bytes = std::vector<std::uint8_t>;
constexpr Profile kProfiles[] = {Profile::kBest, Profile::kPaper};

const SemiRegularMesh& mesh() {
  static const SemiRegularMesh made = [] {
    synthetic::Shape shape;
    shape.levels = 3;
    return synthetic::normal_mesh(shapes::octahedron(), shape);
  }();
  return made;
}

EncodeOptions options_for(Profile profile) {
  EncodeOptions options;
  options.profile = profile;
  options.target_bytes = 500;
  return options;
}

const Encoded& encoded(Profile profile) {
  static std::map<Profile, Encoded> made;
  auto it = made.find(profile);
  if (it == made.end())
    it = made.emplace(profile, encode(mesh(), options_for(profile)).value()).first;
  return it->second;
}

TEST(Symbols, AreWrittenAsTheyWereRead) {
  for (const Profile profile : kProfiles) {
    const Bytes& stream = encoded(profile).bytes;
    const auto symbols = read_symbols(stream);
    ASSERT_TRUE(symbols.has_value()) << symbols.error().message;
    EXPECT_EQ(symbols->grid.size(), mesh().base_vertex_count);
    ASSERT_GE(symbols->bands.size(), 2u);
    const auto again = write_symbols(*symbols);
    ASSERT_TRUE(again.has_value()) << again.error().message;
    EXPECT_EQ(*again, stream);
  }
}

TEST(Symbols, ABandOfZerosLosesItsPayload) {
  for (const Profile profile : kProfiles) {
    StreamSymbols symbols = *read_symbols(encoded(profile).bytes);
    for (entropy::DetailPoint& point : symbols.bands[0].points) point = {0, 0, 0};
    const auto bytes = write_symbols(symbols);
    ASSERT_TRUE(bytes.has_value()) << bytes.error().message;
    EXPECT_EQ(inspect(*bytes)->sections[2].bytes, 0u);
    EXPECT_TRUE(decode(*bytes).has_value());
    EXPECT_EQ(read_symbols(*bytes)->bands[1].points, symbols.bands[1].points);
  }
}

TEST(Symbols, EveryTruncationIsCorrupt) {
  for (const Profile profile : kProfiles) {
    const Bytes& stream = encoded(profile).bytes;
    for (std::size_t size = 0; size < stream.size(); ++size) {
      const auto symbols = read_symbols(Bytes(stream.data(), stream.data() + size));
      ASSERT_FALSE(symbols.has_value()) << size;
      ASSERT_EQ(symbols.error().code, ErrorCode::kCorruptStream) << size;
    }
  }
}

TEST(Symbols, OtherProfilesHaveNone) {
  EncodeOptions options = options_for(Profile::kNmc);
  const auto stream = encode(mesh(), options);
  ASSERT_TRUE(stream.has_value());
  EXPECT_EQ(read_symbols(stream->bytes).error().code, ErrorCode::kUnsupportedVersion);
  EXPECT_EQ(choice_of(*stream, options).error().code, ErrorCode::kUnsupportedVersion);
}

TEST(Symbols, WhatDoesNotFitIsRefused) {
  for (const Profile profile : kProfiles) {
    const StreamSymbols good = *read_symbols(encoded(profile).bytes);
    const auto expect_refused = [&](const char* words, const auto& change) {
      StreamSymbols bad = good;
      change(bad);
      const auto bytes = write_symbols(bad);
      ASSERT_FALSE(bytes.has_value()) << words;
      EXPECT_EQ(bytes.error().code, ErrorCode::kBadInput) << words;
      EXPECT_NE(bytes.error().message.find(words), std::string::npos) << bytes.error().message;
    };
    expect_refused("band 1: needs one point per detail",
                   [](auto& s) { s.bands[1].points.pop_back(); });
    expect_refused("past 2^24", [](auto& s) { s.bands[0].points[3][1] = (1 << 24) + 1; });
    expect_refused("offset", [](auto& s) { s.bands[0].shrink_32nds[0] = 16; });
    expect_refused("ratio", [](auto& s) { s.bands[0].ratio_quarters = 16; });
    expect_refused("a band is missing", [](auto& s) { s.bands.pop_back(); });
    expect_refused("a point per vertex", [](auto& s) { s.grid.pop_back(); });
    expect_refused("base vertex 2 lies outside of its grid", [](auto& s) { s.grid[2][0] = -1; });
    expect_refused("counts are out of range", [](auto& s) { s.header.grid_bits = 25; });
  }
}

TEST(StepChoices, GiveTheSameBytesAgain) {
  for (const Profile profile : kProfiles) {
    for (const auto transform : {wavelet::Transform::kButterfly, wavelet::Transform::kLoop}) {
      EncodeOptions options = options_for(profile);
      options.transform = transform;
      const auto first = encode(mesh(), options);
      ASSERT_TRUE(first.has_value()) << first.error().message;
      const auto choice = choice_of(*first, options);
      ASSERT_TRUE(choice.has_value()) << choice.error().message;
      EXPECT_EQ(choice->steps.size(), 4u);
      const auto again = encode_with_steps(mesh(), *choice);
      ASSERT_TRUE(again.has_value()) << again.error().message;
      EXPECT_EQ(again->bytes, first->bytes);
    }
  }
}

TEST(StepChoices, ThatDoNotFitAreRefused) {
  const StepChoice good = *choice_of(encoded(Profile::kBest), options_for(Profile::kBest));
  const auto expect_refused = [&](const char* words, const auto& change) {
    StepChoice bad = good;
    change(bad);
    const auto coded = encode_with_steps(mesh(), bad);
    ASSERT_FALSE(coded.has_value()) << words;
    EXPECT_EQ(coded.error().code, ErrorCode::kBadInput) << words;
    EXPECT_NE(coded.error().message.find(words), std::string::npos) << coded.error().message;
  };
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  const std::vector<std::vector<Vec3>> targets(4);
  expect_refused("3 levels needs 4 steps, 3 are there", [](auto& c) { c.steps.pop_back(); });
  expect_refused("step 2 must lie in -6400 .. 6400", [](auto& c) { c.steps[2] = 6401; });
  expect_refused("bits per coordinate", [](auto& c) { c.steps[0] = -1000; });
  expect_refused("too fine for its coordinates", [](auto& c) { c.steps[0] = -3000; });
  expect_refused("too fine for its coordinates", [&](auto& c) {
    ASSERT_FALSE(c.targets.empty());
    c.targets[0][1] = Vec3(0, 1e300, 0);
  });
  expect_refused("lambda", [&](auto& c) { c.lambda = nan; });
  expect_refused("lambda", [](auto& c) { c.lambda = -1; });
  expect_refused("0 .. 90 degrees", [](auto& c) { c.theta_degrees = 91; });
  expect_refused("best and paper", [](auto& c) { c.profile = Profile::kEqmc; });
  expect_refused("a level has no target", [&](auto& c) { c.targets.assign(2, {}); });
  expect_refused("level 0 needs a target per vertex, 6", [&](auto& c) { c.targets = targets; });
  expect_refused("not finite", [&](auto& c) {
    c.targets = targets;
    c.targets[0].assign(mesh().base_vertex_count, Vec3(0, inf, 0));
  });
}

}  // namespace
}  // namespace nacre::codec
