// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/comparators.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstring>

#include "codec/codec.h"
#include "codec/stream_writer.h"
#include "synthetic.h"

namespace nacre::codec {
namespace {

using Bytes = std::vector<std::uint8_t>;
const DecodeOptions kAll = {.comparators = decode_comparator_bands};

class Comparator : public testing::TestWithParam<Profile> {
 protected:
  static Encoded encode_at(const SemiRegularMesh& mesh, std::size_t bytes) {
    auto encoded = encode(mesh, {.profile = GetParam(), .target_bytes = bytes});
    EXPECT_TRUE(encoded.has_value()) << encoded.error().message;
    return encoded ? *encoded : Encoded{};
  }
};

INSTANTIATE_TEST_SUITE_P(Codec, Comparator, testing::Values(Profile::kNmc, Profile::kEqmc),
                         [](const testing::TestParamInfo<Profile>& profile) {
                           return std::string(profile_name(profile.param));
                         });

const SemiRegularMesh& sphere_like() {
  static const SemiRegularMesh mesh = synthetic::normal_mesh(synthetic::irregular_base());
  return mesh;
}

TEST_P(Comparator, DecodesToWhatItReports) {
  for (const Scan& base : {shapes::torus(6, 5), shapes::grid(4, 3), shapes::icosahedron()}) {
    SemiRegularMesh mesh = synthetic::normal_mesh(base, {.levels = 3, .amplitude = 0.05});
    mesh.origin = Vec3(500000.25, 4649776.5, -3);
    const Encoded encoded = encode_at(mesh, 1500);
    const auto decoded = decode(encoded.bytes, kAll);
    ASSERT_TRUE(decoded.has_value()) << decoded.error().message;
    EXPECT_EQ(decoded->origin, mesh.origin);
    ASSERT_EQ(decoded->positions.size(), mesh.positions.size());
    EXPECT_GT(encoded.report.measured_distortion, 0);
    EXPECT_LT(std::sqrt(encoded.report.measured_distortion), 0.02);
    // What the encoder believed its decoder to see is what it saw.
    EXPECT_EQ(encoded.report.predicted_distortion, encoded.report.measured_distortion);
  }
}

TEST_P(Comparator, SizeIsNeverAboveAndCloseBelow) {
  double previous = 1e300;
  for (const std::size_t target : {700u, 1300u, 2500u, 5000u, 10000u, 20000u}) {
    const Encoded encoded = encode_at(sphere_like(), target);
    EXPECT_LE(encoded.bytes.size(), target);
    EXPECT_GE(encoded.bytes.size(), target - target / (target < 2000 ? 30 : 100));
    EXPECT_LT(encoded.report.measured_distortion, previous) << target;
    previous = encoded.report.measured_distortion;
  }
}

/// Published coders, not straw men: nearly as good as the paper's or better.
TEST_P(Comparator, KeepsUpWithTheLattice) {
  for (const std::size_t bytes : {1500u, 6000u}) {
    const auto paper = encode(sphere_like(), {.profile = Profile::kPaper, .target_bytes = bytes});
    ASSERT_TRUE(paper.has_value());
    EXPECT_LT(encode_at(sphere_like(), bytes).report.measured_distortion,
              1.2 * paper->report.measured_distortion)
        << bytes;
  }
}

TEST_P(Comparator, IsUnknownToTheDecodingHalf) {
  const Bytes bytes = encode_at(sphere_like(), 2000).bytes;
  const auto mesh = decode(bytes);
  ASSERT_FALSE(mesh.has_value());
  EXPECT_EQ(mesh.error().code, ErrorCode::kUnsupportedVersion);
  const auto info = inspect(bytes);
  ASSERT_TRUE(info.has_value());
  EXPECT_EQ(info->profile, GetParam());
  // The base mesh needs no band.
  EXPECT_TRUE(decode(bytes, {.max_level = 0, .comparators = decode_comparator_bands}).has_value());
}

TEST_P(Comparator, CoarserLevelsAreThoseOfTheWhole) {
  const Bytes bytes = encode_at(sphere_like(), 4000).bytes;
  const auto whole = decode(bytes, kAll);
  ASSERT_TRUE(whole.has_value());
  const auto info = inspect(bytes);
  for (std::size_t j = 0; j < info->levels.size(); ++j) {
    const auto& level = info->levels[j];
    const Bytes prefix(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(level.bytes));
    const auto coarse = decode(prefix, {.max_level = static_cast<int>(j),
                                        .accept_prefix = true,
                                        .comparators = decode_comparator_bands});
    ASSERT_TRUE(coarse.has_value()) << coarse.error().message;
    ASSERT_EQ(coarse->positions.size(), level.vertices);
    EXPECT_EQ(std::memcmp(coarse->positions.data(), whole->positions.data(),
                          coarse->positions.size() * sizeof(Vec3)),
              0)
        << j;
  }
}

TEST_P(Comparator, SameBytesAtAnyThreadCount) {
  std::vector<Bytes> results;
  for (const std::size_t threads : {1u, 3u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    results.push_back(encode_at(sphere_like(), 3000).bytes);
  }
  EXPECT_EQ(results[0], results[1]);
}

TEST_P(Comparator, MeshesWithNothingToCode) {
  const Scan base = shapes::grid(4, 4);
  SemiRegularMesh flat{base.triangles, 25, 2, base.positions, Vec3::Zero()};
  const Topology topology = *Topology::build(flat.base_triangles, 25, 2);
  for (int j = 0; j < 2; ++j)
    for (const Edge& e : topology.level(j).edges)
      flat.positions.push_back((flat.positions[e.vertex[0]] + flat.positions[e.vertex[1]]) / 2);
  const auto decoded = decode(encode_at(flat, 1000).bytes, kAll);
  ASSERT_TRUE(decoded.has_value());
  for (const Vec3& p : decoded->positions) EXPECT_NEAR(p[2], 0, 1e-6);
  const SemiRegularMesh coarse{base.triangles, 25, 0, base.positions, Vec3::Zero()};
  EXPECT_TRUE(decode(encode_at(coarse, 1000).bytes, kAll).has_value());
}

TEST_P(Comparator, RefusesWhatItCannotDo) {
  const auto code = [](EncodeOptions options) {
    options.profile = GetParam();
    const auto encoded = encode(sphere_like(), options);
    EXPECT_FALSE(encoded.has_value());
    return encoded ? ErrorCode::kNoConvergence : encoded.error().code;
  };
  EXPECT_EQ(code({.target_bytes = 40}), ErrorCode::kGoalUnreachable);
  EXPECT_EQ(code({.transform = wavelet::Transform::kLoop, .target_bytes = 4000}),
            ErrorCode::kBadInput);
}

/// Damage behind good checksums.
TEST_P(Comparator, DamagedBandsAreHarmless) {
  const SemiRegularMesh mesh =
      synthetic::normal_mesh(shapes::grid(2, 2), {.levels = 2, .amplitude = 0.1});
  const Bytes bytes = encode_at(mesh, 300).bytes;
  const auto layout = read_layout(bytes);
  ASSERT_TRUE(layout.has_value());
  std::vector<Bytes> sections;
  for (const SectionRange& s : layout->sections) {
    const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(s.offset);
    sections.emplace_back(begin, begin + static_cast<std::ptrdiff_t>(s.payload_bytes));
  }
  synthetic::Random random(11);
  for (int round = 0; round < 3000; ++round) {
    std::vector<Bytes> bands(sections.begin() + 2, sections.end());
    Bytes& band = bands[random.below(static_cast<std::uint32_t>(bands.size()))];
    for (std::uint32_t k = random.below(3) + 1; k > 0; --k)
      band[random.below(static_cast<std::uint32_t>(band.size()))] =
          static_cast<std::uint8_t>(random.below(256));
    if (random.below(3) == 0) band.resize(random.below(static_cast<std::uint32_t>(band.size())));
    const auto decoded =
        decode(write_stream(layout->header, sections[0], sections[1], bands), kAll);
    if (!decoded) {
      EXPECT_EQ(decoded.error().code, ErrorCode::kCorruptStream) << decoded.error().message;
    }
  }
}

TEST(ComparatorHeader, OutOfPlaceFieldsAreCorrupt) {
  Header good;
  good.profile = Profile::kNmc;
  good.base_vertices = good.base_triangles = 4;
  good.grid_bits = 8;
  good.levels = 2;
  good.bands = {{0, 0}};
  const auto code = [&](auto&& change) {
    Header header = good;
    change(header);
    const auto layout = read_layout(
        write_stream(header, {1, 2, 3}, {1, 2}, std::vector<Bytes>(header.bands.size(), {0, 1})));
    return layout ? std::optional<ErrorCode>() : layout.error().code;
  };
  EXPECT_EQ(code([](Header&) {}), std::nullopt);
  EXPECT_EQ(code([](Header& h) { h.grid_bits = 25; }), ErrorCode::kCorruptStream);
  EXPECT_EQ(code([](Header& h) { h.transform = wavelet::Transform::kLoop; }),
            ErrorCode::kCorruptStream);
  EXPECT_EQ(code([](Header& h) { h.bands.push_back({0, 0}); }), ErrorCode::kCorruptStream);
}

}  // namespace
}  // namespace nacre::codec
