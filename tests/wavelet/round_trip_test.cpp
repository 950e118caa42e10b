// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "meshes.h"
#include "wavelet/wavelet.h"

namespace nacre::wavelet {
namespace {

using testing::random_points;
using testing::topology_of;

constexpr Transform kBoth[] = {Transform::kButterfly, Transform::kLoop};

double largest_difference(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  EXPECT_EQ(a.size(), b.size());
  double worst = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    worst = std::max(worst, (a[i] - b[i]).norm());
  return worst;
}

/// FNV-1a over the bytes, lowest first.
std::uint64_t hash_bits(const std::vector<Vec3>& points, std::uint64_t hash) {
  for (const Vec3& p : points) {
    for (int c = 0; c < 3; ++c) {
      std::uint64_t bits;
      std::memcpy(&bits, &p[c], sizeof bits);
      for (int byte = 0; byte < 8; ++byte)
        hash = (hash ^ ((bits >> (8 * byte)) & 255)) * 0x100000001B3u;
    }
  }
  return hash;
}

TEST(RoundTrip, RandomPositionsOnEveryMesh) {
  for (const Transform transform : kBoth) {
    for (const auto& [name, scan] : testing::zoo()) {
      const Topology topology = topology_of(scan, 4);
      const std::vector<Vec3> positions = random_points(topology.vertex_count(), 1);
      const auto pyramid = analyze(topology, positions, transform);
      ASSERT_TRUE(pyramid.has_value()) << name << ": " << pyramid.error().message;
      ASSERT_EQ(pyramid->bands.size(), 4u);
      const auto rebuilt = synthesize(topology, *pyramid, transform);
      ASSERT_TRUE(rebuilt.has_value()) << name;
      // Ensures (1); random positions in [-1, 1]^3 have extent about 3.
      EXPECT_LT(largest_difference(*rebuilt, positions), 1e-12) << name;
    }
  }
}

TEST(RoundTrip, FarFromTheOrigin) {
  const Topology topology = topology_of(shapes::torus(5, 4), 3);
  std::vector<Vec3> positions = random_points(topology.vertex_count(), 1);
  for (Vec3& p : positions) p += Vec3(4.5e5, 5.2e6, 100);
  for (const Transform transform : kBoth) {
    const auto rebuilt = synthesize(topology, *analyze(topology, positions, transform), transform);
    EXPECT_LT(largest_difference(*rebuilt, positions), 5.2e6 * 1e-15 * 8);
  }
}

TEST(RoundTrip, SynthesisThenAnalysisGivesTheDetailsBack) {
  const Topology topology = topology_of(testing::flipped_sphere(2, 400, 5), 3);
  for (const Transform transform : kBoth) {
    const Pyramid pyramid = testing::random_pyramid(topology, 31);
    const auto positions = synthesize(topology, pyramid, transform);
    ASSERT_TRUE(positions.has_value());
    const auto again = analyze(topology, *positions, transform);
    ASSERT_TRUE(again.has_value());
    EXPECT_LT(largest_difference(again->base_positions, pyramid.base_positions), 1e-11);
    for (std::size_t j = 0; j < 3; ++j)
      EXPECT_LT(largest_difference(again->bands[j], pyramid.bands[j]), 1e-9) << "band " << j;
  }
}

TEST(RoundTrip, EveryPrefixOfBandsDecodesToAPrefixOfThePositions) {
  const Topology topology = topology_of(shapes::grid(3, 4), 3);
  Pyramid pyramid = testing::random_pyramid(topology, 8);
  const std::vector<Vec3> full = *synthesize(topology, pyramid);
  for (int levels = 3; levels >= 0; --levels) {
    const std::vector<Vec3> part = *synthesize(topology, pyramid, Transform::kButterfly, levels);
    ASSERT_EQ(part.size(), topology.level(levels).vertex_count);
    for (std::size_t v = 0; v < part.size(); ++v) ASSERT_EQ(part[v], full[v]);
    pyramid.bands.resize(static_cast<std::size_t>(levels));
    EXPECT_EQ(*synthesize(topology, pyramid), part);
  }
}

TEST(Analyze, PlanarMeshesHaveNoNormalDetail) {
  const Vec3 u(0.48, 0.6, -0.64), v(0.8, -0.6, 0.0), origin(3, -2, 5);  // unit, not orthogonal
  const Topology topology = topology_of(shapes::grid(4, 3), 3);
  for (const Transform transform : kBoth) {
    std::vector<Vec3> positions = random_points(topology.vertex_count(), 4);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      // Random in the plane; the coarse grid stays unfolded so that normals agree in sign.
      const double x = positions[i][0], y = positions[i][1];
      positions[i] = origin + u * x + v * y;
    }
    const auto pyramid = analyze(topology, positions, transform);
    ASSERT_TRUE(pyramid.has_value());
    double tangential = 0;
    for (const auto& band : pyramid->bands) {
      for (const Vec3& d : band) {
        EXPECT_NEAR(d[0], 0, 1e-9);  // slivers have noisy normals; their offsets are of order 1
        tangential = std::max(tangential, std::hypot(d[1], d[2]));
      }
    }
    EXPECT_GT(tangential, 0.1);
  }
}

TEST(Analyze, SmoothShapesHaveSmallMostlyNormalDetails) {
  // A sphere as a semi-regular mesh: each band's details are far smaller than the one before.
  const Topology topology = topology_of(shapes::octahedron(), 6);
  const std::vector<Vec3> positions = shapes::sphere(6).positions;
  const Pyramid pyramid = *analyze(topology, positions);
  double last = 1;
  for (const auto& band : pyramid.bands) {
    double normal = 0;
    for (const Vec3& d : band) normal = std::max(normal, std::abs(d[0]));
    EXPECT_LT(normal, last / 2);
    last = normal;
  }
  EXPECT_LT(last, 5e-4);
}

// Debug, release and sanitizer builds must all give these bits. A change of any rule of
// synthesis changes them, and is a change of the format.
TEST(Synthesize, IsBitIdenticalInEveryBuild) {
  const auto decoded_hash = [](Transform transform) {
    std::uint64_t hash = 0xCBF29CE484222325u;
    for (const auto& [name, scan] : testing::zoo()) {
      if (name == "torus" || name == "three components")
        continue;  // positions not needed, but libm
      const Topology topology = topology_of(scan, 4);
      Pyramid pyramid = testing::random_pyramid(topology, 1234);
      for (auto& band : pyramid.bands) {
        for (std::size_t i = 0; i < band.size(); i += 3) band[i] = {band[i][0], 0, 0};
        for (std::size_t i = 1; i < band.size(); i += 3) band[i] = Vec3::Zero();
      }
      hash = hash_bits(*synthesize(topology, pyramid, transform), hash);
    }
    return hash;
  };
  EXPECT_EQ(decoded_hash(Transform::kButterfly), 12939318792375261800u);
  EXPECT_EQ(decoded_hash(Transform::kLoop), 6644066921629836502u);
}

TEST(Hostile, WrongSizesAreBadInput) {
  const Topology topology = topology_of(shapes::grid(2, 2), 2);
  const Pyramid good = testing::random_pyramid(topology, 5);
  ASSERT_TRUE(synthesize(topology, good).has_value());
  const auto expect_bad = [&](const Pyramid& pyramid, int levels = -1) {
    for (const Transform transform : kBoth) {
      const auto result = synthesize(topology, pyramid, transform, levels);
      ASSERT_FALSE(result.has_value());
      EXPECT_EQ(result.error().code, ErrorCode::kBadInput);
      EXPECT_FALSE(result.error().message.empty());
    }
  };
  Pyramid bad = good;
  bad.base_positions.pop_back();
  expect_bad(bad);
  bad = good;
  bad.bands[1].pop_back();
  expect_bad(bad);
  EXPECT_TRUE(synthesize(topology, bad, Transform::kButterfly, 1).has_value());
  bad = good;
  bad.bands.emplace_back();
  expect_bad(bad);
  expect_bad(good, 3);
  expect_bad({});

  std::vector<Vec3> positions = random_points(topology.vertex_count() - 1, 1);
  const auto short_by_one = analyze(topology, positions);
  ASSERT_FALSE(short_by_one.has_value());
  EXPECT_EQ(short_by_one.error().code, ErrorCode::kBadInput);
}

TEST(Hostile, NumbersThatAreNotFiniteAreBadInput) {
  const Topology topology = topology_of(shapes::grid(2, 2), 2);
  const std::vector<Vec3> positions = random_points(topology.vertex_count(), 1);
  const Pyramid good = testing::random_pyramid(topology, 5);
  for (const Transform transform : kBoth) {
    for (const double value :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      std::vector<Vec3> bad = positions;
      bad[7][2] = value;
      const auto analyzed = analyze(topology, bad, transform);
      ASSERT_FALSE(analyzed.has_value());
      EXPECT_EQ(analyzed.error().code, ErrorCode::kBadInput);
      EXPECT_EQ(analyzed.error().where, 7u);

      Pyramid pyramid = good;
      pyramid.bands[0][3][1] = value;
      EXPECT_EQ(synthesize(topology, pyramid, transform).error().code, ErrorCode::kBadInput);
      pyramid = good;
      pyramid.base_positions[0][0] = value;
      EXPECT_EQ(synthesize(topology, pyramid, transform).error().code, ErrorCode::kBadInput);
    }
    // Finite, but what follows from them is not.
    Pyramid pyramid = good;
    for (Vec3& p : pyramid.base_positions) p *= std::numeric_limits<double>::max();
    EXPECT_FALSE(synthesize(topology, pyramid, transform).has_value());
    std::vector<Vec3> huge = positions;
    for (Vec3& p : huge) p *= std::numeric_limits<double>::max();
    EXPECT_FALSE(analyze(topology, huge, transform).has_value());
  }
}

TEST(Hostile, NothingInNothingOut) {
  const Topology empty = *Topology::build({}, 0, 2);
  for (const Transform transform : kBoth) {
    const auto pyramid = analyze(empty, {}, transform);
    ASSERT_TRUE(pyramid.has_value());
    EXPECT_TRUE(synthesize(empty, *pyramid, transform)->empty());
    EXPECT_EQ(measured_gains(empty, transform).energy.size(), 3u);
  }
  const Topology unsplit = topology_of(shapes::tetrahedron(), 0);
  const std::vector<Vec3> positions = random_points(4, 1);
  for (const Transform transform : kBoth)
    EXPECT_EQ(*synthesize(unsplit, *analyze(unsplit, positions, transform), transform), positions);
}

}  // namespace
}  // namespace nacre::wavelet
