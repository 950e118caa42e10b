// SPDX-License-Identifier: GPL-3.0-or-later
#include "entropy/zerotree.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "support/random.h"
#include "support/shapes.h"

namespace nacre::entropy {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Points = std::vector<std::vector<ZerotreePoint>>;

constexpr int kBands = 3;
constexpr std::size_t kPlenty = 1 << 20;

Topology topology_of(const Scan& scan) {
  return *Topology::build(scan.triangles, static_cast<std::uint32_t>(scan.positions.size()),
                          kBands);
}

std::vector<Topology> topologies() {
  std::vector<Topology> out;
  for (const Scan& scan : {shapes::icosahedron(), shapes::grid(3, 2), shapes::torus(5, 4)})
    out.push_back(topology_of(scan));
  return out;
}

/// Magnitudes shrink from band to band, and most tangential components are zero.
Points random_points(const Topology& topology, std::uint64_t seed) {
  TestRandom random(seed);
  Points points;
  for (int j = 0; j < kBands; ++j) {
    std::vector<ZerotreePoint> band(topology.level(j).edges.size());
    for (ZerotreePoint& p : band) {
      for (std::size_t c = 0; c < 3; ++c) {
        if (c > 0 && random.below(10) != 0) continue;
        const auto magnitude =
            static_cast<std::int32_t>(random.below(1u << (2 + random.below(10))) >> (2 * j));
        p[c] = random.below(2) != 0 ? -magnitude : magnitude;
      }
    }
    points.push_back(std::move(band));
  }
  return points;
}

double squared_error(const Points& a, const Points& b) {
  double sum = 0;
  for (std::size_t j = 0; j < a.size(); ++j)
    for (std::size_t i = 0; i < a[j].size(); ++i)
      for (std::size_t c = 0; c < 3; ++c) {
        const double d = a[j][i][c] - b[j][i][c];
        sum += d * d;
      }
  return sum;
}

TEST(Zerotree, TheWholeCodeGivesEveryCoefficient) {
  std::uint64_t seed = 1;
  for (const Topology& topology : topologies()) {
    const Points points = random_points(topology, seed++);
    const Bytes code = encode_zerotree(topology, points, kPlenty);
    const auto decoded = decode_zerotree(code, topology, kBands);
    ASSERT_TRUE(decoded.has_value()) << decoded.error().message;
    EXPECT_EQ(decoded->points, points);
    for (const auto& band : decoded->planes)
      for (const auto& planes : band)
        for (const std::uint8_t plane : planes) ASSERT_EQ(plane, 0);
  }
}

TEST(Zerotree, OneCoefficientAnywhereIsFound) {
  const Topology topology = topology_of(shapes::grid(2, 1));
  for (std::size_t band = 0; band < kBands; ++band) {
    const std::size_t count = topology.level(static_cast<int>(band)).edges.size();
    for (std::size_t i = 0; i < count; ++i) {
      Points points;
      for (int j = 0; j < kBands; ++j) points.emplace_back(topology.level(j).edges.size());
      points[band][i] = {0, 0, -5};
      const auto decoded =
          decode_zerotree(encode_zerotree(topology, points, kPlenty), topology, kBands);
      ASSERT_TRUE(decoded.has_value());
      ASSERT_EQ(decoded->points, points) << band << " " << i;
    }
  }
}

TEST(Zerotree, ACutCodeSaysTheTopBits) {
  const Topology topology = topologies()[0];
  const Points points = random_points(topology, 7);
  const std::size_t whole = encode_zerotree(topology, points, kPlenty).size();
  double previous = 1e300;
  for (std::size_t size = 16; size < whole; size += 40) {
    const Bytes code = encode_zerotree(topology, points, size);
    ASSERT_LE(code.size(), size);
    EXPECT_GE(code.size() + 4, size);
    const auto decoded = decode_zerotree(code, topology, kBands);
    ASSERT_TRUE(decoded.has_value()) << decoded.error().message;
    for (std::size_t j = 0; j < points.size(); ++j)
      for (std::size_t i = 0; i < points[j].size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) {
          const std::int32_t known = decoded->points[j][i][c], truth = points[j][i][c];
          if (known == 0) continue;
          const int plane = decoded->planes[j][i][c];
          ASSERT_EQ(known < 0, truth < 0);
          ASSERT_EQ(std::abs(known), std::abs(truth) >> plane << plane);
        }
    const double error = squared_error(points, decoded->points);
    EXPECT_LT(error, previous) << size;
    previous = error;
  }
}

TEST(Zerotree, AllZeroIsEmpty) {
  const Topology topology = topologies()[1];
  Points points;
  for (int j = 0; j < kBands; ++j) points.emplace_back(topology.level(j).edges.size());
  EXPECT_TRUE(encode_zerotree(topology, points, kPlenty).empty());
  const auto decoded = decode_zerotree({}, topology, kBands);
  ASSERT_TRUE(decoded.has_value());
  EXPECT_EQ(decoded->points, points);
}

TEST(Zerotree, ZeroTreesOfFineBandsCostNearlyNothing) {
  const Topology topology = *Topology::build(shapes::icosahedron().triangles, 12, 6);
  const auto size_of = [&](int bands) {
    TestRandom random(3);
    Points points;
    for (int j = 0; j < bands; ++j) points.emplace_back(topology.level(j).edges.size());
    for (ZerotreePoint& p : points[0]) p[0] = static_cast<std::int32_t>(random.below(4096)) + 1;
    return encode_zerotree(topology, points, kPlenty).size();
  };
  EXPECT_LE(size_of(6), size_of(1) + 8);  // 40,920 edges more
}

TEST(ZerotreeHostile, EveryTruncationAndExtensionIsCorrupt) {
  const Topology topology = topologies()[0];
  const Bytes code = encode_zerotree(topology, random_points(topology, 5), 300);
  for (std::size_t size = 1; size < code.size(); ++size) {
    const auto cut = decode_zerotree(std::span(code).first(size), topology, kBands);
    ASSERT_FALSE(cut.has_value()) << size;
    EXPECT_EQ(cut.error().code, ErrorCode::kCorruptStream);
  }
  Bytes longer = code;
  longer.push_back(0);
  EXPECT_FALSE(decode_zerotree(longer, topology, kBands).has_value());
}

TEST(ZerotreeHostile, RandomBytesAreHarmless) {
  const Topology topology = topologies()[1];
  TestRandom random(9);
  for (int round = 0; round < 3000; ++round) {
    Bytes bytes(random.below(200));
    for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(random.below(256));
    const auto decoded = decode_zerotree(bytes, topology, kBands);
    if (!decoded) {
      EXPECT_EQ(decoded.error().code, ErrorCode::kCorruptStream);
    }
  }
}

}  // namespace
}  // namespace nacre::entropy
