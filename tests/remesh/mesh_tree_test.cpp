// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/mesh_tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "base/topology.h"
#include "remesh/distance_to_triangle.h"
#include "support/shapes.h"

namespace nacre::remesh {
namespace {

/// A bumpy ball's triangles, split: those of a base triangle together, as piercing leaves them.
Scan split_ball(int levels) {
  const Scan base = shapes::icosahedron();
  const auto topology =
      Topology::build(base.triangles, static_cast<std::uint32_t>(base.positions.size()), levels);
  Scan mesh{base.positions, topology->level(levels).triangles, Vec3::Zero()};
  for (int level = 0; level < levels; ++level)
    for (const Edge& e : topology->level(level).edges)
      mesh.positions.push_back((mesh.positions[e.vertex[0]] + mesh.positions[e.vertex[1]]) / 2);
  for (Vec3& p : mesh.positions)
    p *= (1 + 0.2 * std::sin(7 * p[0]) * std::cos(5 * p[1])) / p.norm();
  return mesh;
}

double slow_distance(const Scan& mesh, const Vec3& p) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Triangle& t : mesh.triangles)
    nearest = std::min(nearest, distance_to_triangle(p, mesh.positions[t[0]], mesh.positions[t[1]],
                                                     mesh.positions[t[2]]));
  return nearest;
}

TEST(MeshTree, FindsTheNearestOfAllTriangles) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> coordinate(-2, 2);
  for (const int levels : {0, 1, 2, 3}) {
    const Scan mesh = split_ball(levels);
    const MeshTree tree(mesh, levels);
    for (int i = 0; i < 300; ++i) {
      const Vec3 p(coordinate(random), coordinate(random), coordinate(random));
      EXPECT_EQ(tree.distance(p), slow_distance(mesh, p)) << levels << " levels";
    }
    for (const Vec3& p : mesh.positions) EXPECT_LT(tree.distance(p), 1e-15);
  }
}

TEST(MeshTree, FindsItFarFromTheOriginToo) {
  // Boxes in single precision are far larger than the triangles there.
  Scan mesh = split_ball(2);
  for (Vec3& p : mesh.positions) p += Vec3(1e6, -3e6, 2e6);
  const MeshTree tree(mesh, 2);
  for (std::size_t v = 0; v < mesh.positions.size(); v += 7) {
    const Vec3 p = mesh.positions[v] + Vec3(0.3, 0.1, -0.2);
    EXPECT_EQ(tree.distance(p), slow_distance(mesh, p));
  }
}

TEST(MeshTree, IsFarFromEverythingWithoutTriangles) {
  const Scan none;
  EXPECT_TRUE(std::isinf(MeshTree(none, 3).distance(Vec3::Zero())));
}

}  // namespace
}  // namespace nacre::remesh
