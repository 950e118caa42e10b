// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/edit_stream.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "codec/codec.h"
#include "codec/comparators.h"
#include "codec/stream_format.h"
#include "synthetic.h"

namespace nacre::codec {
namespace {

using Bytes = std::vector<std::uint8_t>;
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr Profile kProfiles[] = {Profile::kPaper, Profile::kBest, Profile::kNmc, Profile::kEqmc};

const DecodeOptions kAll = {.comparators = decode_comparator_bands};

const Bytes& stream(Profile profile) {
  static std::array<Bytes, 4> made;
  Bytes& bytes = made[static_cast<std::size_t>(profile)];
  if (bytes.empty()) {
    SemiRegularMesh mesh =
        synthetic::normal_mesh(shapes::icosahedron(), {.levels = 3, .amplitude = 0.1});
    mesh.origin = {1, 2, 3};
    auto encoded = encode(mesh, {.profile = profile, .target_bytes = 330});
    EXPECT_TRUE(encoded.has_value()) << encoded.error().message;
    bytes = encoded->bytes;
  }
  return bytes;
}

LevelTable example_table() { return {2.0, {{20.049, 0.1}, {33.3, 0.0123}, {kInf, 0}, {-3, 1000}}}; }

TEST(LevelTable, ErrorCodesGrowByLessThanOnePerCent) {
  EXPECT_EQ(table_error(0), 0x1p-31);
  EXPECT_EQ(table_error(kNoErrorCode), kInf);
  for (int code = 1; code < kNoErrorCode; ++code) {
    ASSERT_GT(table_error(code), table_error(code - 1));
    ASSERT_LE(table_error(code), table_error(code - 1) * (1 + 1.0 / 128));
  }
}

TEST(LevelTable, RoundTripsRoundedTheSafeWay) {
  for (const Profile profile : kProfiles) {
    const LevelTable table = example_table();
    const auto bytes = with_quality(stream(profile), table, 0.0121);
    ASSERT_TRUE(bytes.has_value()) << bytes.error().message;
    EXPECT_EQ(bytes->size(), stream(profile).size() + level_table_bytes(profile, 3) +
                                 certified_error_bytes(profile, true));
    const StreamInfo info = *inspect(*bytes, kAll);
    ASSERT_TRUE(info.level_table.has_value());
    EXPECT_EQ(info.level_table->bbox_diagonal, 2.0);
    ASSERT_EQ(info.level_table->cuts.size(), 4u);
    const auto& cuts = info.level_table->cuts;
    EXPECT_DOUBLE_EQ(cuts[0].psnr_db, 20.0);
    EXPECT_DOUBLE_EQ(cuts[1].psnr_db, 33.3);
    EXPECT_DOUBLE_EQ(cuts[2].psnr_db, 204.75);
    EXPECT_DOUBLE_EQ(cuts[3].psnr_db, 0);
    for (std::size_t j = 0; j < 2; ++j) {
      EXPECT_GE(cuts[j].max_error, table.cuts[j].max_error);
      EXPECT_LE(cuts[j].max_error, table.cuts[j].max_error * 1.008);
    }
    EXPECT_EQ(cuts[2].max_error, 2 * 0x1p-31);
    EXPECT_EQ(cuts[3].max_error, kInf);
    ASSERT_TRUE(info.certified_error.has_value());
    EXPECT_GE(*info.certified_error, 0.0121);
    EXPECT_LE(*info.certified_error, 0.0121 * (1 + 1e-6));
  }
}

TEST(LevelTable, WhatWasReadIsWrittenTheSame) {
  const auto once = with_quality(stream(Profile::kBest), example_table(), 0.0121);
  const StreamInfo info = *inspect(*once);
  EXPECT_EQ(*with_quality(*once, info.level_table, info.certified_error), *once);
}

TEST(LevelTable, ChangesNothingElseAndComesOffAgain) {
  for (const Profile profile : kProfiles) {
    const Bytes& plain = stream(profile);
    EXPECT_FALSE(inspect(plain, kAll)->level_table.has_value());
    const auto with = with_quality(plain, example_table());
    EXPECT_FALSE(inspect(*with, kAll)->certified_error.has_value());
    EXPECT_EQ(decode(*with, kAll)->positions, decode(plain, kAll)->positions);
    EXPECT_EQ(inspect(*with, kAll)->profile, profile);
    EXPECT_EQ(*with_quality(*with, std::nullopt), plain);
    const auto only_error = with_quality(plain, std::nullopt, 1.5);
    EXPECT_EQ(only_error->size(), plain.size() + certified_error_bytes(profile, false));
    EXPECT_EQ(*inspect(*only_error, kAll)->certified_error, 1.5);
  }
}

TEST(LevelTable, RefusesWhatIsNoTable) {
  LevelTable table = example_table();
  table.cuts.pop_back();
  EXPECT_EQ(with_quality(stream(Profile::kBest), table).error().code, ErrorCode::kBadInput);
  for (const double bad : {-1.0, std::numeric_limits<double>::quiet_NaN()}) {
    table = example_table();
    table.cuts[1].max_error = bad;
    EXPECT_EQ(with_quality(stream(Profile::kBest), table).error().code, ErrorCode::kBadInput);
    EXPECT_EQ(with_quality(stream(Profile::kBest), std::nullopt, bad).error().code,
              ErrorCode::kBadInput);
  }
  table = example_table();
  table.cuts[1].psnr_db = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(with_quality(stream(Profile::kBest), table).error().code, ErrorCode::kBadInput);
  Bytes cut = stream(Profile::kBest);
  cut.pop_back();
  EXPECT_EQ(with_quality(cut, example_table()).error().code, ErrorCode::kCorruptStream);
}

TEST(LevelTable, EveryTruncationAndFlippedBitOfItIsFound) {
  const Bytes bytes = *with_quality(stream(Profile::kBest), example_table(), 0.0121);
  const std::size_t header = inspect(bytes)->bytes_header;
  for (std::size_t size = 0; size < header; ++size) {
    const Bytes cut(bytes.data(), bytes.data() + size);
    ASSERT_EQ(inspect_header(cut, bytes.size()).error().code, ErrorCode::kCorruptStream) << size;
  }
  for (std::size_t bit = 0; bit < 8 * header; ++bit) {
    Bytes damaged = bytes;
    damaged[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
    ASSERT_FALSE(decode(damaged).has_value()) << bit;
  }
}

TEST(LevelTable, FlagsThatNoWriterSetsAreCorrupt) {
  // A byte of its own for the grid bits without a flag, and the reserved bit.
  const Bytes plain = *with_quality(stream(Profile::kBest), std::nullopt, 1.0);
  for (const int follows : {0x0A, 0x8A, 0xCA, 0x40, 0x59}) {
    Bytes bytes = plain;
    bytes[6] = static_cast<std::uint8_t>(follows);
    const std::size_t fields = inspect(plain)->bytes_header - 2;
    const std::uint16_t check = crc16(std::span(bytes).first(fields));
    bytes[fields] = static_cast<std::uint8_t>(check & 0xFF);
    bytes[fields + 1] = static_cast<std::uint8_t>(check >> 8);
    const auto info = inspect(bytes);
    ASSERT_FALSE(info.has_value()) << follows;
    EXPECT_EQ(info.error().code, ErrorCode::kCorruptStream) << follows;
  }
}

TEST(CutAtLevel, GivesAWholeStreamThatDecodesToThatLevel) {
  for (const Profile profile : {Profile::kPaper, Profile::kBest, Profile::kEqmc}) {
    const auto bytes = with_quality(stream(profile), example_table(), 0.5);
    const StreamInfo info = *inspect(*bytes, kAll);
    for (int level = 0; level <= 3; ++level) {
      const auto cut = cut_at_level(*bytes, level);
      ASSERT_TRUE(cut.has_value()) << cut.error().message;
      EXPECT_LE(cut->size(), info.levels[static_cast<std::size_t>(level)].bytes);
      const auto mesh = decode(*cut, kAll);
      ASSERT_TRUE(mesh.has_value()) << mesh.error().message;
      EXPECT_EQ(mesh->level_count, level);
      DecodeOptions at_level = kAll;
      at_level.max_level = level;
      const auto expected = decode(*bytes, at_level);
      EXPECT_EQ(mesh->positions, expected->positions);
      EXPECT_EQ(mesh->origin, expected->origin);
      const StreamInfo after = *inspect(*cut, kAll);
      ASSERT_TRUE(after.level_table.has_value());
      ASSERT_EQ(after.level_table->cuts.size(), static_cast<std::size_t>(level) + 1);
      EXPECT_EQ(after.level_table->cuts[0].max_error, info.level_table->cuts[0].max_error);
      EXPECT_EQ(after.certified_error.has_value(), level == 3);
      EXPECT_EQ(*cut_at_level(*cut, level), *cut);
    }
  }
}

TEST(CutAtLevel, NeedsOnlyTheSectionsItKeeps) {
  const Bytes& bytes = stream(Profile::kBest);
  const StreamInfo info = *inspect(bytes);
  const Bytes prefix(bytes.begin(),
                     bytes.begin() + static_cast<std::ptrdiff_t>(info.levels[1].bytes));
  EXPECT_EQ(*cut_at_level(prefix, 1), *cut_at_level(bytes, 1));
  EXPECT_EQ(cut_at_level(prefix, 2).error().code, ErrorCode::kCorruptStream);
}

TEST(CutAtLevel, DoesNotPassDamageOn) {
  Bytes bytes = stream(Profile::kBest);
  bytes[inspect(bytes)->sections[2].offset] ^= 1;
  EXPECT_TRUE(cut_at_level(bytes, 0).has_value());
  EXPECT_EQ(cut_at_level(bytes, 1).error().code, ErrorCode::kCorruptStream);
}

TEST(CutAtLevel, RefusesLevelsThatAreNotThere) {
  for (const int level : {-1, 4, 100})
    EXPECT_EQ(cut_at_level(stream(Profile::kBest), level).error().code, ErrorCode::kBadInput);
  EXPECT_EQ(cut_at_level(stream(Profile::kNmc), 1).error().code, ErrorCode::kBadInput);
  EXPECT_EQ(decode(*cut_at_level(stream(Profile::kNmc), 0), kAll)->level_count, 0);
  EXPECT_EQ(*cut_at_level(stream(Profile::kNmc), 3), stream(Profile::kNmc));
}

}  // namespace
}  // namespace nacre::codec
