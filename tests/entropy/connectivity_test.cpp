// SPDX-License-Identifier: GPL-3.0-or-later
#include "entropy/connectivity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <map>
#include <set>

#include "base/topology.h"
#include "entropy/closed_mesh.h"
#include "tests/entropy/connectivity_shapes.h"

namespace nacre::entropy {
namespace {

using test::Random;
using test::Surface;

Triangle turned(const Triangle& t) {
  const auto k = static_cast<std::size_t>(std::min_element(t.begin(), t.end()) - t.begin());
  return {t[k], t[(k + 1) % 3], t[(k + 2) % 3]};
}

std::vector<Triangle> sorted(std::vector<Triangle> triangles) {
  for (Triangle& t : triangles) t = turned(t);
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

/// Encodes and decodes, checks all that the header ensures, and returns the payload.
std::vector<std::uint8_t> expect_round_trip(const Surface& surface) {
  const auto encoded = encode_connectivity(surface.triangles, surface.vertex_count);
  if (!encoded) {
    ADD_FAILURE() << encoded.error().message;
    return {};
  }
  const auto count = static_cast<std::uint32_t>(surface.triangles.size());
  const auto decoded = decode_connectivity(encoded->bytes, count);
  if (!decoded) {
    ADD_FAILURE() << decoded.error().message;
    return {};
  }
  EXPECT_EQ(decoded->vertex_count, surface.vertex_count);
  EXPECT_EQ(decoded->vertex_count, encoded->decoded.vertex_count);
  EXPECT_EQ(decoded->triangles, encoded->decoded.triangles);
  std::vector<std::uint32_t> order = encoded->vertex_order;
  std::vector<Triangle> named = decoded->triangles;
  for (Triangle& t : named)
    for (std::uint32_t& v : t) v = order.at(v);
  EXPECT_EQ(sorted(named), sorted(surface.triangles));
  std::sort(order.begin(), order.end());
  EXPECT_EQ(std::adjacent_find(order.begin(), order.end()), order.end());
  if (count > 0) {
    EXPECT_FALSE(decode_connectivity(encoded->bytes, count - 1).has_value());
  }
  return encoded->bytes;
}

/// Whatever the bytes are, what decodes is a surface.
void expect_error_or_surface(std::span<const std::uint8_t> bytes, std::uint32_t max_triangles) {
  const std::vector<std::uint8_t> own(bytes.begin(), bytes.end());  // so that ASan sees overreads
  const auto decoded = decode_connectivity(own, max_triangles);
  if (!decoded) {
    EXPECT_EQ(decoded.error().code, ErrorCode::kCorruptStream);
    return;
  }
  EXPECT_LE(decoded->triangles.size(), max_triangles);
  EXPECT_TRUE(Topology::build(decoded->triangles, decoded->vertex_count, 0).has_value());
  EXPECT_TRUE(close_mesh(decoded->triangles, decoded->vertex_count).has_value());
  EXPECT_TRUE(encode_connectivity(decoded->triangles, decoded->vertex_count).has_value());
}

TEST(Connectivity, RoundTripOfEveryShape) {
  for (const auto& [name, surface] : test::all_shapes()) {
    SCOPED_TRACE(name);
    expect_round_trip(surface);
  }
}

TEST(Connectivity, NothingIsASurface) { EXPECT_LE(expect_round_trip({}).size(), 1u); }

TEST(Connectivity, RoundTripOfRandomTriangulations) {
  Random random(1);
  for (int round = 0; round < 60; ++round) {
    SCOPED_TRACE(round);
    Surface surface = test::flipped(test::sphere(1 + round % 3), 40u << (round % 5), random);
    surface = test::pierced(surface, round % 7, random);
    expect_round_trip(test::renumbered(surface, random));
  }
}

TEST(Connectivity, SameSurfaceHoweverNumberedCostsAboutTheSame) {
  Random random(2);
  const Surface surface = test::flipped(test::sphere(3), 200, random);
  const double bytes = static_cast<double>(expect_round_trip(surface).size());
  for (int round = 0; round < 5; ++round) {
    const auto again =
        static_cast<double>(expect_round_trip(test::renumbered(surface, random)).size());
    EXPECT_NEAR(again, bytes, 0.05 * bytes);
  }
}

TEST(Connectivity, RegularTorusCostsNextToNothing) {
  EXPECT_LE(expect_round_trip(test::from_scan(shapes::torus(40, 40))).size(), 60u);
}

TEST(Connectivity, RejectsWhatIsNoSurface) {
  const auto code = [](std::vector<Triangle> triangles, std::uint32_t vertex_count) {
    const auto encoded = encode_connectivity(triangles, vertex_count);
    return encoded ? std::string("accepted") : encoded.error().message;
  };
  EXPECT_EQ(code({{0, 1, 3}}, 3), "triangle 0 names a vertex out of range");
  EXPECT_EQ(code({{0, 1, 1}}, 2), "triangle 0 repeats a vertex");
  EXPECT_EQ(code({{0, 1, 2}, {0, 1, 3}}, 4), "triangle 1 is oriented against its neighbour");
  EXPECT_EQ(code({{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}, 5), "triangle 2 is a third one on an edge");
  EXPECT_EQ(code({{0, 1, 2}, {0, 3, 4}}, 5), "vertex 0 joins several boundary loops");
  EXPECT_EQ(code({{0, 1, 2}}, 4), "too many triangles, or vertices without one");
  EXPECT_EQ(code({{0, 1, 2}}, 3), "accepted");
  EXPECT_EQ(code({{0, 1, 2}, {0, 1, 2}}, 3), "triangle 1 is oriented against its neighbour");
  EXPECT_EQ(code({{0, 1, 3}}, 4), "too many triangles, or vertices without one");
  EXPECT_EQ(code({{0, 1, 3}, {1, 0, 4}}, 5), "vertex 2 has no triangle");
  // Two tetrahedra that share a vertex.
  Surface two = test::from_scan(shapes::tetrahedron());
  for (const Triangle& t : shapes::tetrahedron().triangles) {
    Triangle u;
    for (std::size_t k = 0; k < 3; ++k) u[k] = t[k] == 0 ? 0 : t[k] + 3;
    two.triangles.push_back(u);
  }
  EXPECT_EQ(code(two.triangles, 7), "vertex 0 has several fans of triangles");
}

TEST(Connectivity, RejectsEveryTruncationAndExtension) {
  Random random(3);
  for (const Surface& surface :
       {test::flipped(test::sphere(2), 80, random), test::voxel_plate(2), test::holed_grid(9, 3)}) {
    const std::vector<std::uint8_t> full = expect_round_trip(surface);
    for (std::size_t size = 0; size < full.size(); ++size) {
      const std::vector<std::uint8_t> cut(full.data(), full.data() + size);
      const auto decoded = decode_connectivity(cut, 100000);
      ASSERT_FALSE(decoded.has_value()) << "accepted " << size << " of " << full.size();
      EXPECT_EQ(decoded.error().code, ErrorCode::kCorruptStream);
    }
    for (int byte = 0; byte < 256; ++byte) {
      std::vector<std::uint8_t> longer = full;
      longer.push_back(static_cast<std::uint8_t>(byte));
      EXPECT_FALSE(decode_connectivity(longer, 100000).has_value());
    }
  }
}

TEST(Connectivity, SurvivesFlippedBits) {
  Random random(4);
  const std::vector<std::vector<std::uint8_t>> payloads = {
      expect_round_trip(test::flipped(test::sphere(2), 60, random)),
      expect_round_trip(test::voxel_plate(3)), expect_round_trip(test::holed_grid(9, 3)),
      expect_round_trip(test::mixed(random))};
  for (int round = 0; round < 2000; ++round) {
    std::vector<std::uint8_t> bytes = payloads[static_cast<std::size_t>(round) % payloads.size()];
    for (std::uint32_t flips = 1 + random.below(3); flips > 0; --flips)
      bytes[random.below(static_cast<std::uint32_t>(bytes.size()))] ^=
          static_cast<std::uint8_t>(1u << random.below(8));
    expect_error_or_surface(bytes, 4000);
  }
}

TEST(Connectivity, SurvivesRandomBytes) {
  Random random(5);
  for (int round = 0; round < 4000; ++round) {
    std::vector<std::uint8_t> bytes(random.below(40));
    for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(random.below(256));
    if (round % 4 == 0 && !bytes.empty()) std::fill(bytes.begin() + 1, bytes.end(), bytes[0]);
    expect_error_or_surface(bytes, round % 3 == 0 ? 8 : 2000);
  }
}

TEST(Connectivity, LargeMeshInLinearTime) {
  Random random(6);
  const Surface surface = test::flipped(test::sphere(7), 60000, random);  // 65,538 vertices
  const auto start = std::chrono::steady_clock::now();
  expect_round_trip(surface);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  EXPECT_LT(took.count(), 20.0);  // 0.3 s on an idle machine; quadratic would be minutes
}

// A fan and a double cone have a vertex on every triangle.
TEST(Connectivity, HubsInLinearTime) {
  Surface cone;
  constexpr std::uint32_t kRim = 50000;
  for (std::uint32_t i = 0; i < kRim; ++i) {
    const std::uint32_t a = 2 + i, b = 2 + (i + 1) % kRim;
    cone.triangles.push_back({0, a, b});
    cone.triangles.push_back({1, b, a});
  }
  cone.vertex_count = kRim + 2;
  EXPECT_LT(expect_round_trip(cone).size(), 200u);
  const auto encoded = encode_connectivity(cone.triangles, cone.vertex_count);
  const std::vector<GridPoint> points(cone.vertex_count, GridPoint{(1 << 24) - 1, 0, 5});
  const auto bytes = encode_base_positions(points, encoded->decoded, 24);
  const auto decoded = decode_base_positions(bytes, encoded->decoded, 24);
  ASSERT_TRUE(decoded.has_value());
  EXPECT_EQ(*decoded, points);
}

TEST(Positions, RoundTripOfRandomPointsAtEveryWidth) {
  Random random(7);
  for (const auto& [name, surface] : test::all_shapes()) {
    const auto encoded = encode_connectivity(surface.triangles, surface.vertex_count);
    ASSERT_TRUE(encoded.has_value());
    for (int bits = 1; bits <= 24; ++bits) {
      SCOPED_TRACE(name + " at " + std::to_string(bits) + " bits");
      std::vector<GridPoint> points = test::random_points(surface.vertex_count, bits, random);
      if (bits % 4 == 0) {  // corners of the grid, where predictions leave it
        for (GridPoint& p : points)
          for (std::int32_t& x : p) x = x % 2 == 0 ? 0 : (1 << bits) - 1;
      }
      const auto bytes = encode_base_positions(points, encoded->decoded, bits);
      const auto decoded = decode_base_positions(bytes, encoded->decoded, bits);
      ASSERT_TRUE(decoded.has_value());
      EXPECT_EQ(*decoded, points);
    }
  }
}

TEST(Positions, SmoothSurfaceIsPredicted) {
  const Scan sphere = shapes::sphere(4);
  const auto encoded =
      encode_connectivity(sphere.triangles, static_cast<std::uint32_t>(sphere.positions.size()));
  ASSERT_TRUE(encoded.has_value());
  std::vector<GridPoint> points;
  for (const std::uint32_t v : encoded->vertex_order) {
    const Vec3& p = sphere.positions[v];
    GridPoint g;
    for (int k = 0; k < 3; ++k)
      g[static_cast<std::size_t>(k)] = static_cast<std::int32_t>(2048 + 2000 * p[k]);
    points.push_back(g);
  }
  const auto bytes = encode_base_positions(points, encoded->decoded, 12);
  EXPECT_LT(8.0 * static_cast<double>(bytes.size()) / static_cast<double>(points.size()), 18.5);
}

TEST(Positions, RejectsEveryTruncationAndSurvivesFlippedBits) {
  Random random(8);
  const Surface surface = test::mixed(random);
  const auto encoded = encode_connectivity(surface.triangles, surface.vertex_count);
  ASSERT_TRUE(encoded.has_value());
  const std::vector<GridPoint> points = test::random_points(surface.vertex_count, 10, random);
  const auto full = encode_base_positions(points, encoded->decoded, 10);
  test::expect_every_truncation_is_corrupt(full, [&](const std::vector<std::uint8_t>& cut) {
    return decode_base_positions(cut, encoded->decoded, 10);
  });
  for (int round = 0; round < 2000; ++round) {
    const std::vector<std::uint8_t> bytes = test::damaged(full, round, random);
    const auto decoded = decode_base_positions(bytes, encoded->decoded, 10);
    if (!decoded) continue;
    for (const GridPoint& p : *decoded)
      for (const std::int32_t x : p) EXPECT_TRUE(x >= 0 && x < 1024);
  }
}

TEST(Positions, RejectsBadArguments) {
  const Connectivity none;
  EXPECT_FALSE(decode_base_positions({}, none, 0).has_value());
  EXPECT_FALSE(decode_base_positions({}, none, 25).has_value());
  EXPECT_TRUE(decode_base_positions({}, none, 12).has_value());
  const Connectivity torn{3, {{0, 1, 1}}};
  EXPECT_FALSE(decode_base_positions({}, torn, 12).has_value());
}

}  // namespace
}  // namespace nacre::entropy
