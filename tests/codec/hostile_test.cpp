// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "codec/codec.h"
#include "codec/stream_format.h"
#include "codec/stream_writer.h"
#include "synthetic.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace nacre::codec {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// A small file with every kind of section: a boundary, an origin, two coded bands.
Bytes make_small_file(Profile profile) {
  SemiRegularMesh mesh =
      synthetic::normal_mesh(shapes::grid(2, 2), {.levels = 2, .amplitude = 0.1});
  mesh.origin = Vec3(1, 2, 3);
  auto encoded = encode(mesh, {.profile = profile, .target_bytes = 300});
  EXPECT_TRUE(encoded.has_value());
  return encoded->bytes;
}

const Bytes& small_file(Profile profile = Profile::kPaper) {
  static const Bytes paper = make_small_file(Profile::kPaper),
                     best = make_small_file(Profile::kBest);
  return profile == Profile::kPaper ? paper : best;
}

class EveryProfileHostile : public testing::TestWithParam<Profile> {};
INSTANTIATE_TEST_SUITE_P(Hostile, EveryProfileHostile,
                         testing::Values(Profile::kPaper, Profile::kBest));

ErrorCode code_of(const Bytes& bytes, const DecodeOptions& options = {}) {
  const auto mesh = decode(bytes, options);
  const auto info = inspect(bytes, options);
  EXPECT_FALSE(mesh.has_value());
  if (mesh.has_value()) return ErrorCode::kBadInput;
  EXPECT_LE(mesh.error().where, bytes.size());
  if (!info.has_value()) {
    EXPECT_EQ(info.error().code, mesh.error().code);
  }
  return mesh.error().code;
}

TEST_P(EveryProfileHostile, TheFileItselfDecodes) {
  ASSERT_TRUE(decode(small_file(GetParam())).has_value());
  EXPECT_EQ(inspect(small_file(GetParam()))->sections.size(), 4u);
}

TEST_P(EveryProfileHostile, EveryTruncationIsCorrupt) {
  for (std::size_t size = 0; size < small_file(GetParam()).size(); ++size) {
    const Bytes cut(small_file(GetParam()).data(), small_file(GetParam()).data() + size);
    ASSERT_EQ(code_of(cut), ErrorCode::kCorruptStream) << size;
  }
}

TEST_P(EveryProfileHostile, PrefixesDecodeFromTheBaseMeshOn) {
  const std::size_t base = inspect(small_file(GetParam()))->levels[0].bytes;
  int previous = 0;
  for (std::size_t size = 0; size < small_file(GetParam()).size(); ++size) {
    const Bytes cut(small_file(GetParam()).data(), small_file(GetParam()).data() + size);
    if (size < base) {
      ASSERT_EQ(code_of(cut, {.accept_prefix = true}), ErrorCode::kCorruptStream) << size;
    } else {
      const auto mesh = decode(cut, {.accept_prefix = true});
      ASSERT_TRUE(mesh.has_value()) << size << mesh.error().message;
      ASSERT_GE(mesh->level_count, previous);
      previous = mesh->level_count;
    }
  }
  EXPECT_EQ(previous, 1);
}

TEST_P(EveryProfileHostile, EveryFlippedBitIsFound) {
  for (std::size_t bit = 0; bit < 8 * small_file(GetParam()).size(); ++bit) {
    Bytes damaged = small_file(GetParam());
    damaged[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
    const auto expected = bit / 8 == 3 ? ErrorCode::kUnsupportedVersion : ErrorCode::kCorruptStream;
    ASSERT_EQ(code_of(damaged), expected) << "bit " << bit;
  }
}

TEST_P(EveryProfileHostile, ExtraBytesAreCorrupt) {
  Bytes longer = small_file(GetParam());
  longer.push_back(0);
  EXPECT_EQ(code_of(longer), ErrorCode::kCorruptStream);
  EXPECT_EQ(code_of(longer, {.accept_prefix = true}), ErrorCode::kCorruptStream);
}

TEST(HostileStream, NewerVersionsAreUnsupported) {
  Bytes newer = small_file();
  newer[3] = 1;
  EXPECT_EQ(code_of(newer), ErrorCode::kUnsupportedVersion);
}

TEST(HostileStream, LimitsAreCheckedBeforeDecoding) {
  const std::uint64_t vertices = decode(small_file())->positions.size();
  EXPECT_TRUE(decode(small_file(), {.max_vertices = vertices}).has_value());
  EXPECT_EQ(code_of(small_file(), {.max_vertices = vertices - 1}), ErrorCode::kLimitExceeded);
  EXPECT_TRUE(decode(small_file(), {.max_level = 0, .max_vertices = vertices - 1}).has_value());
}

/// Streams whose checksums are right and whose contents are not.
TEST(HostileStream, WellFormedNonsenseIsRefused) {
  Header good;
  good.base_vertices = 4;
  good.base_triangles = 4;
  good.grid_bits = 8;
  good.levels = 2;
  const auto code = [&](auto&& change, const Bytes& connectivity = {1, 2, 3}) {
    Header header = good;
    change(header);
    std::vector<Bytes> bands(header.bands.size(), Bytes{0, 200});
    return code_of(write_stream(header, connectivity, {1, 2}, bands));
  };
  EXPECT_EQ(code([](Header&) {}), ErrorCode::kCorruptStream);
  EXPECT_EQ(code([](Header& h) { h.base_vertices = 2; }), ErrorCode::kCorruptStream);
  EXPECT_EQ(code([](Header& h) { h.base_vertices = 13; }), ErrorCode::kCorruptStream);
  EXPECT_EQ(code([](Header& h) { h.boundary_edges = 1; }), ErrorCode::kCorruptStream);
  EXPECT_EQ(code([](Header& h) { h.boundary_edges = 14; }), ErrorCode::kCorruptStream);
  EXPECT_EQ(code([](Header& h) { h.grid_bits = 0; }), ErrorCode::kCorruptStream);
  EXPECT_EQ(code([](Header& h) { h.grid_bits = 25; }), ErrorCode::kCorruptStream);
  EXPECT_EQ(code([](Header& h) { h.grid_step_index = kMaxStepIndex + 1; }),
            ErrorCode::kCorruptStream);
  EXPECT_EQ(code([](Header& h) { h.grid_corner[1] = kMaxGridCorner + 1; }),
            ErrorCode::kCorruptStream);
  EXPECT_EQ(code([](Header& h) { h.origin[0] = std::nan(""); }), ErrorCode::kCorruptStream);
  EXPECT_EQ(code([](Header& h) { h.bands.resize(3); }), ErrorCode::kCorruptStream);
  EXPECT_EQ(code([](Header& h) {
              h.bands.push_back({0, -kMaxStepIndex - 1});
            }),
            ErrorCode::kCorruptStream);
  // A small file that asks for a billion vertices.
  EXPECT_EQ(code([](Header& h) { h.levels = 15; }), ErrorCode::kLimitExceeded);
  EXPECT_EQ(code([](Header& h) { h.base_vertices = h.base_triangles = 0xFFFFFFFEu; }),
            ErrorCode::kLimitExceeded);
}

/// Damage behind checksums that were put right: only the section decoders can find it. The fuzz
/// target checks that what is accepted is whole; sanitizer builds check the rest.
TEST_P(EveryProfileHostile, DamageBehindGoodChecksumsIsHarmless) {
  synthetic::Random random(11);
  for (int round = 0; round < 3000; ++round) {
    Bytes bytes = small_file(GetParam());
    for (std::uint32_t k = random.below(3) + 1; k > 0; --k)
      bytes[4 + random.below(static_cast<std::uint32_t>(bytes.size()) - 4)] =
          static_cast<std::uint8_t>(random.below(256));
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  }
}

TEST(HostileStream, ALengthIsNotBelievedBeforeItIsThere) {
  Header header;
  header.base_vertices = 4;
  header.base_triangles = 4;
  header.grid_bits = 8;
  header.levels = 1;
  header.connectivity_bytes = kMaxPayload;
  header.position_bytes = kMaxPayload;
  header.bands.push_back({kMaxPayload, 0});
  EXPECT_EQ(code_of(write_header(header)), ErrorCode::kCorruptStream);
  header.bands[0].payload_bytes = kMaxPayload + 1;
  EXPECT_EQ(code_of(write_header(header)), ErrorCode::kCorruptStream);
}

}  // namespace
}  // namespace nacre::codec
