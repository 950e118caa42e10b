// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "map_checks.h"
#include "remesh/pierce.h"
#include "support/random.h"

namespace nacre::remesh {
namespace {

/// Where a line meets a triangle, by Cramer's rule; nothing when it misses or runs along.
std::optional<std::array<double, 3>> slow_hit(const Scan& scan, std::uint32_t f, const Vec3& origin,
                                              const Vec3& direction) {
  const Triangle& t = scan.triangles[f];
  Eigen::Matrix3d m;
  m.col(0) = scan.positions[t[1]] - scan.positions[t[0]];
  m.col(1) = scan.positions[t[2]] - scan.positions[t[0]];
  m.col(2) = -direction;
  if (std::abs(m.determinant()) < 1e-14) return std::nullopt;
  const Vec3 x = m.inverse() * (origin - scan.positions[t[0]]);
  if (x[0] < 0 || x[1] < 0 || x[0] + x[1] > 1) return std::nullopt;
  return std::array<double, 3>{x[2], x[0], x[1]};
}

double slow_distance(const Scan& scan, const Vec3& q) {
  double best = 1e300;
  for (const Triangle& t : scan.triangles) {
    const std::array<Vec3, 3> c = {scan.positions[t[0]], scan.positions[t[1]],
                                   scan.positions[t[2]]};
    const Vec3 n = (c[1] - c[0]).cross(c[2] - c[0]).normalized();
    bool inside = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 edge = c[(k + 1) % 3] - c[k];
      inside &= edge.cross(q - c[k]).dot(n) >= 0;
      const double s = std::clamp((q - c[k]).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
      best = std::min(best, (c[k] + s * edge - q).norm());
    }
    if (inside) best = std::min(best, std::abs((q - c[0]).dot(n)));
  }
  return best;
}

TEST(LineTree, FindsTheHitsThatTheDefinitionFinds) {
  TestRandom random(5);
  for (const Scan& scan : {shapes::torus(13, 9), shapes::bumpy_sphere(2), shapes::grid(3, 3)}) {
    const LineTree tree(scan);
    std::size_t met = 0;
    for (int i = 0; i < 500; ++i) {
      const Vec3 origin = 1.5 * random.point(), direction = random.direction();
      const double reach = 0.2 + 2 * random.unit();
      std::vector<std::pair<double, std::uint32_t>> expected;
      for (std::uint32_t f = 0; f < scan.triangles.size(); ++f) {
        const auto hit = slow_hit(scan, f, origin, direction);
        if (hit && std::abs((*hit)[0]) <= reach) expected.emplace_back((*hit)[0], f);
      }
      std::sort(expected.begin(), expected.end(),
                [](const auto& a, const auto& b) { return std::abs(a.first) < std::abs(b.first); });
      const auto hits = tree.hits(origin, direction, reach);
      ASSERT_EQ(hits.size(), expected.size());
      met += hits.size();
      for (std::size_t k = 0; k < hits.size(); ++k) {
        EXPECT_NEAR(hits[k].t, expected[k].first, 1e-9);
        EXPECT_EQ(hits[k].point.face, expected[k].second);
        EXPECT_TRUE(testing::is_valid(hits[k].point, scan.triangles.size()));
        EXPECT_LT((position_of(hits[k].point, scan.triangles, scan.positions) -
                   (origin + hits[k].t * direction))
                      .norm(),
                  1e-9);
      }
    }
    EXPECT_GT(met, 20u);
  }
}

TEST(LineTree, FindsTheNearestPoint) {
  TestRandom random(6);
  for (const Scan& scan : {shapes::torus(13, 9), shapes::bumpy_sphere(2), shapes::grid(3, 3)}) {
    const LineTree tree(scan);
    for (int i = 0; i < 500; ++i) {
      const Vec3 q = 3 * random.point();
      const SurfacePoint p = tree.nearest(q);
      ASSERT_TRUE(testing::is_valid(p, scan.triangles.size()));
      EXPECT_NEAR((position_of(p, scan.triangles, scan.positions) - q).norm(),
                  slow_distance(scan, q), 1e-9);
    }
  }
}

TEST(LineTree, SkipsTrianglesWithoutArea) {
  Scan scan = shapes::sphere(2);
  const auto n = static_cast<std::uint32_t>(scan.positions.size());
  scan.positions.insert(scan.positions.end(), {{2, 0, 0}, {3, 0, 0}, {4, 0, 0}});
  scan.triangles.insert(scan.triangles.begin(), {n, n + 1, n + 2});
  const LineTree tree(scan);
  const SurfacePoint p = tree.nearest({3, 0.01, 0});
  EXPECT_NE(p.face, 0u);
  for (const auto& hit : tree.hits({0, 0, 0}, {1, 0, 0}, 10)) EXPECT_NE(hit.point.face, 0u);
}

TEST(LineTree, HoldsOneTriangleOrNone) {
  Scan scan{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, Vec3::Zero()};
  const LineTree one(scan);
  const auto hits = one.hits({0.25, 0.25, 1}, {0, 0, 1}, 2);
  ASSERT_EQ(hits.size(), 1u);
  EXPECT_EQ(hits[0].t, -1);
  EXPECT_EQ(position_of(one.nearest({2, 0, 1}), scan.triangles, scan.positions), Vec3(1, 0, 0));
  scan.positions[2] = {2, 0, 0};
  const LineTree none(scan);
  EXPECT_TRUE(none.hits({0.25, 0, 1}, {0, 0, 1}, 2).empty());
  EXPECT_EQ(none.nearest({2, 0, 1}).face, 0u);
}

}  // namespace
}  // namespace nacre::remesh
