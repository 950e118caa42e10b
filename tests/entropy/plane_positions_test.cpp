// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <string>

#include "entropy/connectivity.h"
#include "entropy/plane_position_writer.h"
#include "entropy/plane_positions_decode.h"
#include "tests/entropy/connectivity_shapes.h"

namespace nacre::entropy {
namespace {

using test::Random;
using test::random_points;
using test::Surface;

TEST(PlanePositions, RoundTripOfRandomPoints) {
  Random random(7);
  for (const auto& [name, surface] : test::all_shapes()) {
    const auto encoded = encode_connectivity(surface.triangles, surface.vertex_count);
    ASSERT_TRUE(encoded.has_value());
    for (const int bits : {1, 2, 3, 6, 11, 16, 20, 24}) {
      SCOPED_TRACE(name + " at " + std::to_string(bits) + " bits");
      std::vector<GridPoint> points = random_points(surface.vertex_count, bits, random);
      if (bits % 4 == 0) {  // corners of the grid, where predictions leave it
        for (GridPoint& p : points)
          for (std::int32_t& x : p) x = x % 2 == 0 ? 0 : (1 << bits) - 1;
      }
      const auto bytes = encode_positions_by_planes(points, encoded->decoded, bits);
      const auto decoded = decode_positions_by_planes(bytes, encoded->decoded, bits);
      ASSERT_TRUE(decoded.has_value());
      EXPECT_EQ(*decoded, points);
      EXPECT_EQ(encode_positions_by_planes(*decoded, encoded->decoded, bits), bytes);
    }
  }
}

TEST(PlanePositions, RejectsEveryTruncationAndSurvivesFlippedBits) {
  Random random(8);
  const Surface surface = test::mixed(random);
  const auto encoded = encode_connectivity(surface.triangles, surface.vertex_count);
  ASSERT_TRUE(encoded.has_value());
  const std::vector<GridPoint> points = random_points(surface.vertex_count, 10, random);
  const auto full = encode_positions_by_planes(points, encoded->decoded, 10);
  test::expect_every_truncation_is_corrupt(full, [&](const std::vector<std::uint8_t>& cut) {
    return decode_positions_by_planes(cut, encoded->decoded, 10);
  });
  for (int round = 0; round < 400; ++round) {
    const std::vector<std::uint8_t> bytes = test::damaged(full, round, random);
    const int bits = round % 3 == 0 ? 24 : 10;
    const auto decoded = decode_positions_by_planes(bytes, encoded->decoded, bits);
    if (!decoded) continue;
    for (const GridPoint& p : *decoded)
      for (const std::int32_t x : p) EXPECT_TRUE(x >= 0 && x < 1 << bits);
  }
}

TEST(PlanePositions, RejectsBadArguments) {
  const Connectivity none;
  EXPECT_FALSE(decode_positions_by_planes({}, none, 0).has_value());
  EXPECT_FALSE(decode_positions_by_planes({}, none, 25).has_value());
  EXPECT_TRUE(decode_positions_by_planes({}, none, 12).has_value());
  const Connectivity torn{3, {{0, 1, 1}}};
  EXPECT_FALSE(decode_positions_by_planes({}, torn, 12).has_value());
}

// A plane through the point and the normal, both as the coder has them.
TEST(PlanePrediction, SolvesPlanesAndLines) {
  const Plane floor{{0, 0, 16 * 100}, {0, 0, 5}};
  const Plane wall{{16 * 40, 0, 0}, {-3, 0, 0}};
  const Plane slope{{0, 0, 0}, {-1, 0, 2}};  // z = x / 2
  EXPECT_EQ(solve_plane(floor, 2, {7, 9, 0}, 10), 100);
  EXPECT_EQ(solve_plane(slope, 2, {31, 9, 0}, 10), 16);     // 15.5, halves away from zero
  EXPECT_EQ(solve_plane(slope, 0, {0, 9, 600}, 10), 1023);  // 1200, held inside
  EXPECT_TRUE(have_line(floor, wall, 1));
  EXPECT_FALSE(have_line(floor, wall, 0));
  EXPECT_FALSE(have_line(floor, floor, 1));
  EXPECT_EQ(solve_line(floor, wall, 1, 0, {0, 77, 0}, 10), 40);
  EXPECT_EQ(solve_line(wall, floor, 1, 2, {0, 77, 0}, 10), 100);
  EXPECT_EQ(solve_line(wall, slope, 1, 2, {0, 77, 0}, 10), 20);
}

// Nothing is left to tell of a plane's points but where they are in it.
TEST(PlanePositions, FlatMeshCostsTwoCoordinates) {
  Random random(3);
  constexpr int kSide = 24, kBits = 12;
  const auto triangles = shapes::grid(kSide - 1, kSide - 1).triangles;
  const auto encoded = encode_connectivity(triangles, kSide * kSide);
  ASSERT_TRUE(encoded.has_value());
  std::vector<GridPoint> flat, thick;
  for (const std::uint32_t v : encoded->vertex_order) {
    const auto x = static_cast<std::int32_t>(v / kSide * 128 + random.below(32));
    const auto y = static_cast<std::int32_t>(v % kSide * 128 + random.below(32));
    flat.push_back({x, y, 512 + x / 4});
    thick.push_back({x, y, 512 + x / 4 + static_cast<std::int32_t>(random.below(32))});
  }
  const auto bits = [&](const std::vector<GridPoint>& points) {
    return 8.0 *
           static_cast<double>(encode_positions_by_planes(points, encoded->decoded, kBits).size()) /
           static_cast<double>(points.size());
  };
  // 5 bits are random along each axis.
  EXPECT_LT(bits(flat), 2 * 5 + 5);
  EXPECT_GT(bits(thick), bits(flat) + 3);
}

}  // namespace
}  // namespace nacre::entropy
