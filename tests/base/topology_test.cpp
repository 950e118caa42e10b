// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/topology.h"

#include <gtest/gtest.h>

#include <map>

#include "support/shapes.h"

namespace nacre {
namespace {

Topology build(const Scan& scan, int levels) {
  auto topology = Topology::build(scan.triangles, static_cast<std::uint32_t>(scan.positions.size()), levels);
  EXPECT_TRUE(topology.has_value());
  return *topology;
}

/// Every stored relation of a level, checked against the triangles alone.
void expect_consistent(const LevelTopology& level) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> face_of_side;
  for (std::uint32_t f = 0; f < level.triangles.size(); ++f)
    for (int k = 0; k < 3; ++k)
      face_of_side[{level.triangles[f][k], level.triangles[f][(k + 1) % 3]}] = f;
  for (std::uint32_t f = 0; f < level.triangles.size(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const Edge& e = level.edges.at(level.triangle_edges[f][k]);
      const std::uint32_t a = level.triangles[f][k], b = level.triangles[f][(k + 1) % 3];
      EXPECT_TRUE((e.vertex == std::array{a, b} && e.face[0] == f) ||
                  (e.vertex == std::array{b, a} && e.face[1] == f));
    }
  }
  for (const Edge& e : level.edges) {
    const auto back = face_of_side.find({e.vertex[1], e.vertex[0]});
    EXPECT_EQ(e.face[1], back == face_of_side.end() ? kNone : back->second);
  }
}

TEST(Topology, CountsFollowEuler) {
  for (const auto& [scan, chi] : {std::pair{shapes::icosahedron(), 2}, {shapes::torus(5, 4), 0},
                                  {shapes::grid(3, 2), 1}}) {
    const Topology t = build(scan, 4);
    for (int j = 0; j < 4; ++j) {
      const LevelTopology& level = t.level(j);
      EXPECT_EQ(static_cast<int>(level.vertex_count + level.triangles.size()) -
                    static_cast<int>(level.edges.size()), chi);
      EXPECT_EQ(t.level(j + 1).triangles.size(), 4 * level.triangles.size());
      EXPECT_EQ(t.band_size(j), level.edges.size());
    }
  }
}

TEST(Topology, EveryLevelIsConsistent) {
  for (const Scan& scan : {shapes::tetrahedron(), shapes::torus(4, 3), shapes::grid(2, 3)}) {
    const Topology t = build(scan, 3);
    for (int j = 0; j < 3; ++j) expect_consistent(t.level(j));
  }
}

TEST(Topology, TrianglesThatAreNotStoredAreTheSame) {
  for (const Scan& scan : {shapes::tetrahedron(), shapes::torus(4, 3), shapes::grid(2, 3)}) {
    for (const int levels : {0, 1, 3}) {
      const Topology stored = build(scan, levels);
      const auto counted = Topology::build_for_decoding(
          scan.triangles, static_cast<std::uint32_t>(scan.positions.size()), levels);
      ASSERT_TRUE(counted.has_value());
      if (levels > 0) {
        EXPECT_TRUE(counted->level(levels).triangles.empty());
      }
      for (int j = 0; j <= levels; ++j) {
        const std::vector<Triangle>& triangles = stored.level(j).triangles;
        ASSERT_EQ(stored.triangle_count(j), triangles.size());
        ASSERT_EQ(counted->triangle_count(j), triangles.size());
        for (std::size_t i = 0; i < triangles.size(); ++i) {
          EXPECT_EQ(stored.triangle(j, i), triangles[i]);
          EXPECT_EQ(counted->triangle(j, i), triangles[i]);
        }
      }
    }
  }
}

TEST(Topology, MidpointsKeepGridOnGrid) {
  // On a flat grid the finest triangles must tile the plane: all of equal, positive area.
  const Scan scan = shapes::grid(2, 2);
  const Topology t = build(scan, 3);
  std::vector<Vec3> p = scan.positions;
  for (int j = 0; j < 3; ++j)
    for (const Edge& e : t.level(j).edges) p.push_back((p[e.vertex[0]] + p[e.vertex[1]]) / 2);
  for (const Triangle& f : t.level(3).triangles)
    EXPECT_DOUBLE_EQ(cross(p[f[1]] - p[f[0]], p[f[2]] - p[f[0]])[2], 1.0 / 64);
}

TEST(Topology, RejectsBadBaseMeshes) {
  const auto code = [](std::vector<Triangle> triangles, std::uint32_t n, int levels) {
    const auto t = Topology::build(triangles, n, levels);
    EXPECT_FALSE(t.has_value());
    return t.error().code;
  };
  EXPECT_EQ(code({{0, 1, 3}}, 3, 1), ErrorCode::kBadInput);                          // id out of range
  EXPECT_EQ(code({{0, 1, 1}}, 3, 1), ErrorCode::kBadInput);                          // repeated vertex
  EXPECT_EQ(code({{0, 1, 2}, {0, 1, 3}}, 4, 1), ErrorCode::kBadInput);               // wound alike
  EXPECT_EQ(code({{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}, 5, 1), ErrorCode::kBadInput);    // three faces
  EXPECT_EQ(code({{0, 1, 2}}, 3, 16), ErrorCode::kLimitExceeded);
}

}  // namespace
}  // namespace nacre
