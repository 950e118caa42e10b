// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/codec.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstring>
#include <string>

#include "codec/best_targets.h"
#include "synthetic.h"

namespace nacre::codec {
namespace {

using Bytes = std::vector<std::uint8_t>;

Encoded encode_to(const SemiRegularMesh& mesh, std::size_t bytes, EncodeOptions options = {}) {
  options.target_bytes = bytes;
  auto encoded = encode(mesh, options);
  EXPECT_TRUE(encoded.has_value()) << encoded.error().message;
  return encoded ? *encoded : Encoded{};
}

const SemiRegularMesh& sphere_like() {
  static const SemiRegularMesh mesh = synthetic::normal_mesh(synthetic::irregular_base());
  return mesh;
}

/// What holds for every profile.
class EveryProfile : public testing::TestWithParam<Profile> {
 protected:
  static EncodeOptions options() { return {.profile = GetParam()}; }
  static Encoded encode_at(const SemiRegularMesh& mesh, std::size_t bytes) {
    return encode_to(mesh, bytes, options());
  }
};

INSTANTIATE_TEST_SUITE_P(Codec, EveryProfile, testing::Values(Profile::kPaper, Profile::kBest),
                         [](const testing::TestParamInfo<Profile>& profile) {
                           return std::string(profile.param == Profile::kPaper ? "Paper" : "Best");
                         });

bool same_bits(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec3)) == 0;
}

/// Mean over the vertices of `a` of the squared distance to the nearest vertex of `b`.
double mean_squared_to_nearest(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double sum = 0;
  for (const Vec3& p : a) {
    double least = (p - b[0]).squaredNorm();
    for (const Vec3& q : b) least = std::min(least, (p - q).squaredNorm());
    sum += least;
  }
  return sum / static_cast<double>(a.size());
}

TEST_P(EveryProfile, DecodedMeshIsTheInputWithinTheReportedError) {
  for (const Scan& base : {shapes::torus(6, 5), shapes::grid(4, 3), shapes::icosahedron()}) {
    SemiRegularMesh mesh = synthetic::normal_mesh(base, {.levels = 3, .amplitude = 0.05});
    mesh.origin = Vec3(500000.25, 4649776.5, -3);
    const Encoded encoded = encode_at(mesh, 1500);
    const auto decoded = decode(encoded.bytes);
    ASSERT_TRUE(decoded.has_value()) << decoded.error().message;
    EXPECT_EQ(decoded->origin, mesh.origin);
    EXPECT_EQ(decoded->level_count, 3);
    ASSERT_EQ(decoded->positions.size(), mesh.positions.size());
    // The decoder's numbering is its own; a vertex's nearest neighbour is at most as far as itself.
    const double error = encoded.report.measured_distortion;
    EXPECT_GT(error, 0);
    EXPECT_LT(std::sqrt(error), 0.02);
    EXPECT_LE(mean_squared_to_nearest(mesh.positions, decoded->positions), 1.0001 * error);
    EXPECT_LE(mean_squared_to_nearest(decoded->positions, mesh.positions), 1.0001 * error);
  }
}

TEST_P(EveryProfile, MoreBytesMeanLessError) {
  double previous = 1e300;
  for (const std::size_t bytes : {600u, 1200u, 2500u, 5000u, 10000u, 20000u}) {
    const Encoded encoded = encode_at(sphere_like(), bytes);
    EXPECT_LT(encoded.report.measured_distortion, previous) << bytes;
    previous = encoded.report.measured_distortion;
  }
}

TEST_P(EveryProfile, HighRateReachesTheFloatingPointNoise) {
  const SemiRegularMesh mesh = synthetic::normal_mesh(shapes::icosahedron(), {.levels = 2});
  const Encoded encoded = encode_at(mesh, 1 << 20);
  EXPECT_LT(std::sqrt(encoded.report.measured_distortion), 1e-5);
}

TEST_P(EveryProfile, SizeIsNeverAboveAndCloseBelow) {
  synthetic::Random random(3);
  for (int i = 0; i < 12; ++i) {
    const auto target = static_cast<std::size_t>(500 * std::exp2(6 * random.uniform()));
    const Encoded encoded = encode_at(sphere_like(), target);
    EXPECT_EQ(encoded.bytes.size(), encoded.report.bytes);
    EXPECT_LE(encoded.bytes.size(), target);
    const double unused =
        1 - static_cast<double>(encoded.bytes.size()) / static_cast<double>(target);
    EXPECT_LE(unused, target < 2000 ? 0.03 : 0.01) << target;
  }
}

TEST_P(EveryProfile, PredictionIsWithinFivePercent) {
  for (const std::size_t bytes : {1000u, 2000u, 4000u, 8000u, 16000u, 32000u}) {
    const EncodeReport report = encode_at(sphere_like(), bytes).report;
    EXPECT_NEAR(report.predicted_distortion / report.measured_distortion, 1, 0.05) << bytes;
  }
}

TEST_P(EveryProfile, ReportAddsUp) {
  const Encoded encoded = encode_at(sphere_like(), 4000);
  const EncodeReport& r = encoded.report;
  double bits = 8.0 * static_cast<double>(r.bytes_header + r.bytes_base);
  for (const BandReport& band : r.bands) bits += band.bits;
  EXPECT_EQ(bits, 8.0 * static_cast<double>(r.bytes));
  EXPECT_EQ(r.bytes_base, r.bytes_base_connectivity + r.bytes_base_positions);
  const auto info = inspect(encoded.bytes);
  ASSERT_TRUE(info.has_value());
  EXPECT_EQ(info->sections[0].offset, r.bytes_header);
  EXPECT_EQ(info->sections[0].bytes, r.bytes_base_connectivity);
  EXPECT_EQ(info->bytes_whole, r.bytes);
  EXPECT_EQ(info->base_bits, r.base_bits);
  EXPECT_EQ(info->levels.size(), r.bands.size() + 1);
  EXPECT_EQ(info->levels.back().vertices, sphere_like().positions.size());
  EXPECT_LE(r.bytes_header, 64u);
}

TEST_P(EveryProfile, FixedBaseBitsAreKept) {
  for (const int bits : {6, 9, 14}) {
    const Encoded encoded =
        encode_to(sphere_like(), 4000, {.profile = GetParam(), .base_bits = bits});
    EXPECT_LE(encoded.report.base_bits, bits);
    EXPECT_GE(encoded.report.base_bits, bits - 1);
  }
}

TEST_P(EveryProfile, LoopTransformIsPassedThrough) {
  const SemiRegularMesh mesh = synthetic::normal_mesh(shapes::icosahedron(), {.levels = 3});
  const Encoded encoded =
      encode_to(mesh, 2000, {.profile = GetParam(), .transform = wavelet::Transform::kLoop});
  EXPECT_EQ(inspect(encoded.bytes)->transform, wavelet::Transform::kLoop);
  EXPECT_LT(std::sqrt(encoded.report.measured_distortion), 0.01);
}

TEST_P(EveryProfile, SameBytesAtAnyThreadCount) {
  std::vector<Bytes> results;
  for (const std::size_t threads : {1u, 2u, 4u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    results.push_back(encode_at(sphere_like(), 3000).bytes);
  }
  EXPECT_EQ(results[0], results[1]);
  EXPECT_EQ(results[0], results[2]);
}

TEST_P(EveryProfile, ScaleCostsNothing) {
  SemiRegularMesh mesh = synthetic::normal_mesh(shapes::icosahedron(), {.levels = 3});
  const Bytes plain = encode_at(mesh, 1000).bytes;
  for (Vec3& p : mesh.positions) p *= 1024;
  const Encoded scaled = encode_at(mesh, 1000);
  EXPECT_EQ(plain.size(), scaled.bytes.size());
}

TEST_P(EveryProfile, FlatMeshCodesNoDetail) {
  const Scan base = shapes::grid(4, 4);
  SemiRegularMesh mesh{base.triangles, 25, 2, base.positions, Vec3::Zero()};
  const Topology topology = *Topology::build(mesh.base_triangles, 25, 2);
  for (int j = 0; j < 2; ++j)
    for (const Edge& e : topology.level(j).edges)
      mesh.positions.push_back((mesh.positions[e.vertex[0]] + mesh.positions[e.vertex[1]]) / 2);
  const Encoded encoded = encode_at(mesh, 1000);
  const auto decoded = decode(encoded.bytes);
  ASSERT_TRUE(decoded.has_value());
  for (const Vec3& p : decoded->positions) EXPECT_NEAR(p[2], 0, 1e-6);
}

TEST(Codec, BestIsBetterThanPaper) {
  // Distances to the surface: best does not care where on it the vertices are.
  const auto prepared = prepare(sphere_like(), wavelet::Transform::kButterfly);
  ASSERT_TRUE(prepared.has_value());
  const SurfaceWeights weights = surface_weights(*prepared);
  for (const std::size_t bytes : {800u, 1500u, 3000u, 6000u, 12000u}) {
    const auto error = [&](Profile profile) {
      const auto decoded = decode(encode_to(sphere_like(), bytes, {.profile = profile}).bytes);
      EXPECT_TRUE(decoded.has_value());
      return surface_error(*prepared, weights, decoded->positions);
    };
    EXPECT_LT(error(Profile::kBest), 0.9 * error(Profile::kPaper)) << bytes;
  }
}

TEST(Codec, FastEffortLosesLittle) {
  const auto error = [](Effort effort) {
    return encode_to(sphere_like(), 2000, {.profile = Profile::kBest, .effort = effort})
        .report.measured_distortion;
  };
  EXPECT_LT(error(Effort::kFast), 1.25 * error(Effort::kNormal));
}

/// Its search starts at the step that is usual for a size, which for a small mesh is far off.
TEST(Codec, FastEffortHoldsSizesAndFillsThem) {
  EncodeOptions options{.effort = Effort::kFast};
  for (const std::size_t size : {900u, 1500u, 2500u, 4000u, 7000u, 12000u}) {
    const std::size_t bytes = encode_to(sphere_like(), size, options).bytes.size();
    EXPECT_LE(bytes, size);
    EXPECT_GE(bytes, size * 99 / 100);
  }
  const SemiRegularMesh coarse = synthetic::normal_mesh(shapes::torus(9, 6), {.levels = 2});
  options.target_bytes = 10;
  const auto refused = encode(coarse, options);
  ASSERT_FALSE(refused.has_value());
  const std::size_t smallest = refused.error().where;
  for (std::size_t size = smallest; size < smallest + 200; size += 7)
    EXPECT_LE(encode_to(coarse, size, options).bytes.size(), size);
}

TEST(Codec, RefusesWhatItCannotDo) {
  const auto code = [](const SemiRegularMesh& mesh, EncodeOptions options) {
    const auto encoded = encode(mesh, options);
    EXPECT_FALSE(encoded.has_value());
    return encoded ? ErrorCode::kNoConvergence : encoded.error().code;
  };
  const SemiRegularMesh good = synthetic::normal_mesh(shapes::icosahedron(), {.levels = 2});
  EXPECT_EQ(code(good, {.target_bytes = 30}), ErrorCode::kGoalUnreachable);
  EXPECT_EQ(code(good, {.target_bytes = 0}), ErrorCode::kBadInput);
  EXPECT_EQ(code(good, {.target_bytes = 1000, .base_bits = 30}), ErrorCode::kBadInput);
  SemiRegularMesh bad = good;
  bad.positions[5][1] = std::nan("");
  EXPECT_EQ(code(bad, {.target_bytes = 1000}), ErrorCode::kBadInput);
  bad = good;
  bad.positions.pop_back();
  EXPECT_EQ(code(bad, {.target_bytes = 1000}), ErrorCode::kBadInput);
  bad = good;
  bad.base_triangles.clear();
  EXPECT_EQ(code(bad, {.target_bytes = 1000}), ErrorCode::kBadInput);
}

TEST_P(EveryProfile, SmallestSizeNamedIsReachable) {
  const SemiRegularMesh mesh = synthetic::normal_mesh(shapes::icosahedron(), {.levels = 2});
  const auto refused = encode(mesh, {.profile = GetParam(), .target_bytes = 10});
  ASSERT_FALSE(refused.has_value());
  const std::size_t smallest = refused.error().where;
  EXPECT_LE(encode_at(mesh, smallest).bytes.size(), smallest);
}

/// Where there is hardly more than the base, what one step of the search leaves is not enough for
/// the next.
TEST_P(EveryProfile, SizesJustAboveTheSmallestHold) {
  for (const auto& base : {shapes::icosahedron(), shapes::torus(9, 6)}) {
    const SemiRegularMesh mesh = synthetic::normal_mesh(base, {.levels = 2});
    const auto refused = encode(mesh, {.profile = GetParam(), .target_bytes = 10});
    ASSERT_FALSE(refused.has_value());
    const std::size_t smallest = refused.error().where;
    for (std::size_t size = smallest; size < smallest + 30; ++size) {
      const auto encoded = encode(mesh, {.profile = GetParam(), .target_bytes = size});
      ASSERT_TRUE(encoded.has_value()) << encoded.error().message;
      EXPECT_LE(encoded->bytes.size(), size);
    }
  }
}

TEST_P(EveryProfile, CancelStopsIt) {
  const std::atomic<bool> stop{true};
  RunContext context;
  context.cancel = &stop;
  const auto encoded =
      encode(sphere_like(), {.profile = GetParam(), .target_bytes = 4000}, context);
  ASSERT_FALSE(encoded.has_value());
  EXPECT_EQ(encoded.error().code, ErrorCode::kCancelled);
}

TEST_P(EveryProfile, CoarserLevelsArePrefixesOfTheirOwn) {
  const Encoded encoded = encode_at(sphere_like(), 6000);
  const auto info = inspect(encoded.bytes);
  ASSERT_TRUE(info.has_value());
  for (std::size_t j = 0; j < info->levels.size(); ++j) {
    const auto& level = info->levels[j];
    const auto coarse = decode(encoded.bytes, {.max_level = static_cast<int>(j)});
    ASSERT_TRUE(coarse.has_value());
    EXPECT_EQ(coarse->positions.size(), level.vertices);
    const Bytes prefix(encoded.bytes.begin(),
                       encoded.bytes.begin() + static_cast<std::ptrdiff_t>(level.bytes));
    const auto cut = decode(prefix, {.max_level = static_cast<int>(j), .accept_prefix = true});
    ASSERT_TRUE(cut.has_value()) << cut.error().message;
    EXPECT_TRUE(same_bits(cut->positions, coarse->positions)) << j;
    // One byte less decodes one level less.
    if (j > 0 && level.bytes > info->levels[j - 1].bytes) {
      const Bytes less(prefix.begin(), prefix.end() - 1);
      const auto lower = decode(less, {.accept_prefix = true});
      ASSERT_TRUE(lower.has_value());
      EXPECT_EQ(lower->level_count, static_cast<int>(j) - 1);
    }
  }
}

}  // namespace
}  // namespace nacre::codec
