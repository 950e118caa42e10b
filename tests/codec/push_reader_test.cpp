// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/push_reader.h"

#include <gtest/gtest.h>

#include "codec/codec.h"
#include "codec/comparators.h"
#include "codec/edit_stream.h"
#include "synthetic.h"

namespace nacre::codec {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Of three levels, the last of which has no band.
const Bytes& stream(Profile profile) {
  static std::array<Bytes, 4> made;
  Bytes& bytes = made[static_cast<std::size_t>(profile)];
  if (bytes.empty()) {
    const SemiRegularMesh mesh =
        synthetic::normal_mesh(shapes::icosahedron(), {.levels = 3, .amplitude = 0.1});
    auto encoded = encode(mesh, {.profile = profile, .target_bytes = 260});
    EXPECT_TRUE(encoded.has_value()) << encoded.error().message;
    bytes = encoded->bytes;
  }
  return bytes;
}

DecodeOptions options_for(Profile profile) {
  DecodeOptions options;
  options.accept_prefix = true;
  if (profile == Profile::kNmc || profile == Profile::kEqmc)
    options.comparators = decode_comparator_bands;
  return options;
}

/// What a reader hands over when it is fed pieces of `piece` bytes.
std::vector<SemiRegularMesh> levels_of(const Bytes& bytes, const DecodeOptions& options,
                                       std::size_t piece) {
  std::vector<SemiRegularMesh> levels;
  PushReader reader(options);
  for (std::size_t at = 0; at < bytes.size(); at += piece) {
    const auto ok = reader.push(std::span(bytes).subspan(at, std::min(piece, bytes.size() - at)),
                                [&](const SemiRegularMesh& mesh) { levels.push_back(mesh); });
    EXPECT_TRUE(ok.has_value()) << ok.error().message;
  }
  EXPECT_TRUE(reader.done());
  EXPECT_TRUE(reader.finish().has_value());
  return levels;
}

class EveryProfilePushed : public testing::TestWithParam<Profile> {};
INSTANTIATE_TEST_SUITE_P(PushReader, EveryProfilePushed,
                         testing::Values(Profile::kPaper, Profile::kBest, Profile::kNmc,
                                         Profile::kEqmc));

TEST_P(EveryProfilePushed, GivesEachLevelOnceWhateverThePieces) {
  const DecodeOptions options = options_for(GetParam());
  const Bytes& bytes = stream(GetParam());
  for (const std::size_t piece : {std::size_t{1}, std::size_t{7}, std::size_t{100}, bytes.size()}) {
    const auto levels = levels_of(bytes, options, piece);
    ASSERT_FALSE(levels.empty());
    EXPECT_EQ(levels.front().level_count, 0);
    EXPECT_EQ(levels.back().level_count, 3);
    for (std::size_t i = 0; i < levels.size(); ++i) {
      EXPECT_GT(levels[i].level_count, i > 0 ? levels[i - 1].level_count : -1);
      DecodeOptions at_level = options;
      at_level.max_level = levels[i].level_count;
      const auto expected = decode(bytes, at_level);
      ASSERT_TRUE(expected.has_value());
      EXPECT_EQ(levels[i].positions, expected->positions);  // to the bit
      EXPECT_EQ(levels[i].base_triangles, expected->base_triangles);
    }
    const bool one_by_one = GetParam() == Profile::kPaper || GetParam() == Profile::kBest;
    EXPECT_EQ(levels.size(), one_by_one ? 4u : 2u);
  }
}

TEST_P(EveryProfilePushed, ALevelComesWithTheLastByteOfItsBand) {
  const DecodeOptions options = options_for(GetParam());
  const Bytes& bytes = stream(GetParam());
  const StreamInfo info = *inspect(bytes, options);
  PushReader reader(options);
  for (std::size_t size = 1; size <= bytes.size(); ++size) {
    ASSERT_TRUE(reader.push(std::span(bytes).subspan(size - 1, 1)).has_value());
    int expected = -1;
    for (std::size_t j = 0; j < info.levels.size(); ++j)
      if (info.levels[j].bytes <= size) expected = static_cast<int>(j);
    if (GetParam() == Profile::kPaper || GetParam() == Profile::kBest) {
      ASSERT_EQ(reader.level(), expected) << size;
    }
    ASSERT_EQ(reader.finish().has_value(), reader.level() >= 0) << size;
    ASSERT_EQ(reader.mesh() != nullptr, reader.level() >= 0);
  }
  EXPECT_TRUE(reader.done());
}

TEST(PushReader, KnowsTheHeaderAsSoonAsItIsThere) {
  const Bytes& bytes = stream(Profile::kBest);
  const StreamInfo expected = *inspect(bytes);
  PushReader reader;
  for (std::size_t size = 1; size <= bytes.size(); ++size) {
    ASSERT_TRUE(reader.push(std::span(bytes).subspan(size - 1, 1)).has_value());
    ASSERT_EQ(reader.info().has_value(), size >= expected.bytes_header) << size;
  }
  EXPECT_EQ(reader.info()->bytes_whole, bytes.size());
  EXPECT_EQ(reader.info()->levels.size(), expected.levels.size());
}

TEST(PushReader, StopsAtTheLevelAskedForAndTakesTheRestUnread) {
  Bytes bytes = stream(Profile::kBest);
  const StreamInfo info = *inspect(bytes);
  bytes.back() ^= 0x55;  // damage where nobody looks
  DecodeOptions options;
  options.max_level = 1;
  PushReader reader(options);
  ASSERT_TRUE(reader.push(std::span(bytes).first(info.levels[1].bytes)).has_value());
  EXPECT_TRUE(reader.done());
  EXPECT_TRUE(reader.finish().has_value());
  EXPECT_TRUE(reader.push(std::span(bytes).subspan(info.levels[1].bytes)).has_value());
  EXPECT_EQ(reader.mesh()->level_count, 1);
}

TEST(PushReader, WithoutAcceptPrefixACutStreamIsCorruptAtTheEndOnly) {
  const Bytes& bytes = stream(Profile::kBest);
  PushReader reader;
  ASSERT_TRUE(reader.push(std::span(bytes).first(bytes.size() - 1)).has_value());
  EXPECT_GE(reader.level(), 0);
  EXPECT_EQ(reader.finish().error().code, ErrorCode::kCorruptStream);
  EXPECT_EQ(reader.finish().error().where, bytes.size() - 1);
}

TEST(PushReader, DamageIsFoundWithItsSectionAndStays) {
  const Bytes& bytes = stream(Profile::kBest);
  const StreamInfo info = *inspect(bytes);
  for (std::size_t bit = 0; bit < 8 * bytes.size(); bit += 3) {
    Bytes damaged = bytes;
    damaged[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
    PushReader reader;
    int levels = 0;
    auto ok = reader.push(damaged, [&](const SemiRegularMesh&) { ++levels; });
    if (!ok) {
      ASSERT_FALSE(reader.push({}).has_value()) << bit;
    } else {
      ok = reader.finish();  // a length that has grown
    }
    ASSERT_FALSE(ok.has_value()) << bit;
    ASSERT_NE(ok.error().code, ErrorCode::kBadInput);
    int expected = 0;  // levels whose sections lie before the damage
    for (const auto& level : info.levels) expected += level.bytes <= bit / 8 ? 1 : 0;
    ASSERT_LE(levels, expected) << bit;
  }
}

TEST(PushReader, BytesAfterTheEndAreCorrupt) {
  Bytes bytes = stream(Profile::kPaper);
  bytes.push_back(0);
  PushReader reader;
  EXPECT_EQ(reader.push(bytes).error().code, ErrorCode::kCorruptStream);
}

TEST(PushReader, ForeignBytesAreRefusedAtTheFirst) {
  PushReader reader;
  const Bytes no = {'P'};
  EXPECT_EQ(reader.push(no).error().code, ErrorCode::kCorruptStream);
  PushReader newer;
  const Bytes next = {'N', 'C', 'R', 1};
  EXPECT_EQ(newer.push(next).error().code, ErrorCode::kUnsupportedVersion);
}

TEST(PushReader, KeepsTheLimit) {
  DecodeOptions options;
  options.max_vertices = 100;
  PushReader reader(options);
  EXPECT_EQ(reader.push(stream(Profile::kBest)).error().code, ErrorCode::kLimitExceeded);
  options.max_level = 1;  // 42 vertices
  PushReader coarse(options);
  EXPECT_TRUE(coarse.push(stream(Profile::kBest)).has_value());
}

TEST(PushReader, SaysThatItHasNoComparators) {
  PushReader reader;
  EXPECT_EQ(reader.push(stream(Profile::kEqmc)).error().code, ErrorCode::kUnsupportedVersion);
  EXPECT_EQ(reader.level(), 0);  // the base came through
}

}  // namespace
}  // namespace nacre::codec
