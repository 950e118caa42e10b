// SPDX-License-Identifier: GPL-3.0-or-later
#include "wavelet/frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "meshes.h"
#include "wavelet/wavelet.h"

namespace nacre::wavelet {
namespace {

using testing::random_points;
using testing::topology_of;

void expect_orthonormal(const Frame& f) {
  EXPECT_NEAR(f.normal.norm(), 1, 1e-14);
  EXPECT_NEAR(f.tangent1.norm(), 1, 1e-14);
  EXPECT_NEAR(f.tangent2.norm(), 1, 1e-14);
  EXPECT_NEAR(f.normal.dot(f.tangent1), 0, 1e-14);
  EXPECT_LT((f.normal.cross(f.tangent1) - f.tangent2).norm(), 1e-14);
}

TEST(Frames, NormalIsTheAreaWeightedSumOverTheFinerTriangles) {
  for (const auto& [name, scan] : testing::zoo()) {
    if (name == "two-sided triangle" || name == "isolated vertices") continue;
    const Topology topology = topology_of(scan, 2);
    for (int j = 0; j < 2; ++j) {
      const std::uint32_t kept = topology.level(j).vertex_count;
      std::vector<Vec3> p = random_points(kept, 21);
      const LevelPrediction prediction = predict(topology, j, p);
      p.insert(p.end(), prediction.points.begin(), prediction.points.end());
      std::vector<Vec3> sum(p.size(), Vec3::Zero());
      for (const Triangle& t : topology.level(j + 1).triangles) {
        const Vec3 area = (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]);
        for (const std::uint32_t v : t) sum[v] += area;
      }
      for (std::size_t e = 0; e < prediction.frames.size(); ++e) {
        const Frame& f = prediction.frames[e];
        expect_orthonormal(f);
        ASSERT_LT((f.normal - sum[kept + e].normalized()).norm(), 1e-9) << name << ", edge " << e;
      }
    }
  }
}

TEST(Frames, MadeOneByOneAreTheSame) {
  for (const Scan& scan : {shapes::sphere(1), shapes::grid(3, 2)}) {
    const Topology topology = topology_of(scan, 2);
    for (int j = 0; j < 2; ++j) {
      const std::vector<Vec3> p = random_points(topology.level(j).vertex_count, 5);
      const LevelPrediction prediction = predict(topology, j, p);
      const PredictedLevel level = predict_level(topology, j, p);
      ASSERT_EQ(level.size(), prediction.points.size());
      EXPECT_TRUE(std::equal(p.begin(), p.end(), level.positions.begin()));
      for (std::size_t e = 0; e < level.size(); ++e) {
        EXPECT_EQ(level.point(e), prediction.points[e]);
        EXPECT_EQ(level.frame(e).normal, prediction.frames[e].normal);
        EXPECT_EQ(level.frame(e).tangent1, prediction.frames[e].tangent1);
        EXPECT_EQ(level.frame(e).tangent2, prediction.frames[e].tangent2);
      }
    }
  }
}

TEST(Frames, MadeAtNeedAreTheSame) {
  for (const auto& [name, scan] : testing::zoo()) {
    const Topology topology = topology_of(scan, 4);
    for (int j = 0; j < 4; ++j) {
      const std::vector<Vec3> p = random_points(topology.level(j).vertex_count, 7);
      const PredictedLevel all = predict_level(topology, j, p);
      const PredictedLevel some = predict_at_need(topology, j, p);
      EXPECT_EQ(some.positions.empty(), j > 0);
      ASSERT_EQ(some.size(), all.size());
      for (std::size_t e = 0; e < all.size(); ++e) {
        ASSERT_EQ(some.point(e), all.point(e)) << name << ", level " << j << ", edge " << e;
        ASSERT_EQ(some.frame(e).normal, all.frame(e).normal) << name << ", edge " << e;
        ASSERT_EQ(some.frame(e).tangent1, all.frame(e).tangent1);
        ASSERT_EQ(some.frame(e).tangent2, all.frame(e).tangent2);
      }
    }
  }
}

TEST(Frames, SecondTangentRunsAlongTheEdge) {
  const Scan scan = shapes::sphere(3);
  const Topology topology = topology_of(scan, 1);
  const LevelPrediction prediction = predict(topology, 0, scan.positions);
  for (std::size_t e = 0; e < prediction.frames.size(); ++e) {
    const Frame& f = prediction.frames[e];
    EXPECT_GT(f.normal.dot(prediction.points[e].normalized()), 0.99) << "must face outward";
    const auto& v = topology.level(0).edges[e].vertex;
    const Vec3 edge = scan.positions[v[1]] - scan.positions[v[0]];
    EXPECT_LT((f.tangent2 - (edge - edge.dot(f.normal) * f.normal).normalized()).norm(), 1e-14);
  }
}

TEST(Frames, AnEdgeAlongTheNormalFallsBackToTheLeastAlignedAxis) {
  for (const Vec3& edge : {Vec3(0, 0, 2), Vec3(1e-9, 0, 2), Vec3(0, 0, 0)}) {
    const Frame f = frame_of({0, 0, 1}, edge);
    expect_orthonormal(f);
    EXPECT_EQ(f.tangent2, Vec3(1, 0, 0));
  }
}

TEST(Frames, DegenerateGeometryFallsBack) {
  const Scan scan = shapes::octahedron();
  const Topology topology = topology_of(scan, 1);
  // All in one point: no area anywhere.
  const LevelPrediction point = predict(topology, 0, std::vector<Vec3>(6, Vec3(1, 2, 3)));
  for (const Frame& f : point.frames) {
    EXPECT_EQ(f.normal, Vec3(0, 0, 1));
    expect_orthonormal(f);
  }
  // Areas whose squares overflow or vanish, and coordinates that are not numbers.
  for (const double scale : {1e200, 1e-200, std::nan(""), HUGE_VAL}) {
    std::vector<Vec3> p = scan.positions;
    for (Vec3& x : p) x *= scale;
    const LevelPrediction prediction = predict(topology, 0, p);
    for (const Frame& f : prediction.frames) expect_orthonormal(f);
  }
}

TEST(Frames, FallBackToTheCoarseFaces) {
  // On the base of a two-sided triangle everything cancels: both sums vanish, and +z is left.
  const Topology topology = *Topology::build(std::vector<Triangle>{{0, 1, 2}, {0, 2, 1}}, 3, 1);
  const std::vector<Vec3> corners = {{0, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const LevelPrediction flat = predict(topology, 0, corners);
  for (const Frame& f : flat.frames) EXPECT_EQ(f.normal, Vec3(0, 0, 1));

  // With every other vertex in one point the finer triangles vanish but the coarse ones do not.
  const LevelTopology level = topology_of(shapes::octahedron(), 1).level(0);
  std::vector<Vec3> predicted(level.vertex_count + level.edges.size(), Vec3(1, 1, 1));
  predicted[level.edges[0].vertex[0]] = predicted[level.edges[0].vertex[1]] = Vec3(1, 1, 1);
  const std::uint32_t c = level.opposite_corner(level.edges[0].face[0], 0);
  EXPECT_EQ(midpoint_normal(level, predicted, 0), Vec3(0, 0, 1));
  predicted[level.edges[0].vertex[1]] = Vec3(1, 2, 1);
  predicted[c] = Vec3(1, 1, 2);
  EXPECT_EQ(midpoint_normal(level, predicted, 0), Vec3(1, 0, 0));
}

}  // namespace
}  // namespace nacre::wavelet
