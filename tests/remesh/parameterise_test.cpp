// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/parameterise.h"

#include <gtest/gtest.h>

#include "map_checks.h"
#include "remesh/adjacency.h"
#include "support/random.h"

namespace nacre::remesh {
namespace {

using Vec2 = Eigen::Vector2d;

Parameterisation simplified(const Scan& scan, int base_vertices) {
  SimplifyOptions options;
  options.base_vertices = base_vertices;
  return *simplify(scan, options);
}

/// A flat scan that is its own base, split: the identity is the map that mean values must find.
struct Flat {
  Scan scan;
  Parameterisation map;
};

Flat flat_scan(const Scan& triangle, int levels) {
  Flat out{shapes::split(triangle, levels), {}};
  out.map.base = {triangle.triangles, {{kNone, kNone, kNone}}, {0, 1, 2}};
  const Vec3 &a = triangle.positions[0], &b = triangle.positions[1], &c = triangle.positions[2];
  const auto area = [](const Vec3& p, const Vec3& q, const Vec3& r) {
    return (q - p).cross(r - p)[2];
  };
  for (const Vec3& p : out.scan.positions) {
    const double whole = area(a, b, c);
    out.map.point.push_back(
        {0, {area(p, b, c) / whole, area(a, p, c) / whole, area(a, b, p) / whole}});
  }
  return out;
}

Scan unit_triangle() { return {{{0, 0, 0}, {1, 0, 0}, {0.5, std::sqrt(0.75), 0}}, {{0, 1, 2}}}; }

TEST(Parameterise, FindsTheIdentityOnAFlatTriangle) {
  const Flat exact = flat_scan(unit_triangle(), 4);
  const Atlas atlas(exact.map.base);
  const Atlas::Chart chart = atlas.triangle_chart(0);
  const auto fixed = testing::boundary_vertices(exact.scan);
  Flat flat = exact;
  TestRandom random(7);
  for (std::size_t v = 0; v < flat.map.point.size(); ++v) {
    const Vec2 step(0.008 * random.signed_unit(), 0.008 * random.signed_unit());
    if (!fixed[v]) flat.map.point[v] = chart.unmap(*chart.map(flat.map.point[v]) + step);
  }
  const auto report = parameterise(flat.scan, flat.map);
  EXPECT_EQ(report.solved, 1u);
  for (std::size_t v = 0; v < flat.map.point.size(); ++v) {
    const Vec2 found = *chart.map(flat.map.point[v]), right = *chart.map(exact.map.point[v]);
    ASSERT_LT((found - right).norm(), 1e-12) << "vertex " << v;
  }
}

/// tan(α/2) + tan(β/2) over the length, from the angles themselves.
double mean_value_weight(const Vec3& at, const Vec3& before, const Vec3& to, const Vec3& after) {
  const auto tangent = [&](const Vec3& p) {
    return std::tan(std::acos((p - at).dot(to - at) / ((p - at).norm() * (to - at).norm())) / 2);
  };
  return (tangent(before) + tangent(after)) / (to - at).norm();
}

TEST(Parameterise, PutsInnerVerticesAtTheMeanValueOfTheirNeighbours) {
  const Scan scan = shapes::bumpy_sphere(5);
  const auto n = static_cast<std::uint32_t>(scan.positions.size());
  Parameterisation map = simplified(scan, 12);
  const auto neighbors = side_neighbors(scan.triangles, n);
  const auto first = face_of_vertex(scan.triangles, n);
  const Atlas atlas(map.base);
  const auto furthest_off = [&] {
    std::vector<double> off;
    Star star;
    for (std::uint32_t v = 0; v < n; ++v) {
      collect_star(scan.triangles, neighbors, v, first[v], star);
      const auto chart = atlas.triangle_chart(map.point[v].face);
      Vec2 sum = Vec2::Zero();
      double weights = 0;
      const std::size_t k = star.ring.size();
      bool inside = true;
      for (std::size_t m = 0; m < k && inside; ++m) {
        const auto at = chart.map(map.point[star.ring[m]]);
        inside = at.has_value();
        const double w =
            mean_value_weight(scan.positions[v], scan.positions[star.ring[(m + k - 1) % k]],
                              scan.positions[star.ring[m]], scan.positions[star.ring[(m + 1) % k]]);
        if (inside) sum += w * *at;
        weights += w;
      }
      if (inside) off.push_back((sum / weights - *chart.map(map.point[v])).norm());
    }
    EXPECT_GT(off.size(), n / 2);
    std::sort(off.begin(), off.end());
    return off[off.size() * 49 / 50];  // but for corners put back
  };
  EXPECT_GT(furthest_off(), 1e-4);
  const auto report = parameterise(scan, map);
  EXPECT_EQ(report.solved, map.base.triangles.size());
  EXPECT_LT(furthest_off(), 1e-10);
}

TEST(Parameterise, TurnsNothingOverAndKeepsFacesBoundariesAndTheBase) {
  for (const auto& [name, scan] : testing::scans_of_all_kinds()) {
    SCOPED_TRACE(name);
    const Parameterisation before = simplified(scan, 40);
    Parameterisation after = before;
    const auto report = parameterise(scan, after);
    EXPECT_GT(report.solved, 0u);
    EXPECT_EQ(report.refused, 0u);
    EXPECT_EQ(after.base.triangles, before.base.triangles);
    EXPECT_EQ(after.base.scan_vertex, before.base.scan_vertex);
    const auto boundary = testing::boundary_vertices(scan);
    for (std::size_t v = 0; v < after.point.size(); ++v) {
      ASSERT_TRUE(testing::is_valid(after.point[v], after.base.triangles.size()));
      EXPECT_EQ(after.point[v].face, before.point[v].face);
      if (boundary[v]) {
        EXPECT_EQ(after.point[v].weight, before.point[v].weight);
      }
    }
    EXPECT_LE(testing::orientation_of(scan, after).same_turned,
              testing::orientation_of(scan, before).same_turned);
  }
}

TEST(Parameterise, IsTheSameAtAnyThreadCount) {
  for (const auto& [name, scan] : testing::scans_of_all_kinds()) {
    SCOPED_TRACE(name);
    const Parameterisation start = simplified(scan, 40);
    const auto run = [&] {
      Parameterisation map = start;
      parameterise(scan, map);
      return map;
    };
    const auto one = testing::with_threads(1, run), two = testing::with_threads(2, run);
    for (std::size_t v = 0; v < one.point.size(); ++v) {
      ASSERT_EQ(one.point[v].face, two.point[v].face);
      ASSERT_EQ(one.point[v].weight, two.point[v].weight);
    }
  }
}

TEST(Parameterise, StopsWhenCancelled) {
  const Scan scan = shapes::bumpy_sphere(4);
  Parameterisation map = simplified(scan, 12);
  const auto before = map.point;
  const std::atomic<bool> cancel = true;
  EXPECT_EQ(parameterise(scan, map, {nullptr, &cancel}).solved, 0u);
  for (std::size_t v = 0; v < before.size(); ++v) EXPECT_EQ(map.point[v].weight, before[v].weight);
}

TEST(Parameterise, LeavesAPatchThatIsNoDiskAlone) {
  // All scan vertices of a ring in one base triangle: two borders.
  const Scan ring = shapes::holed_grid(9, 3, 6);
  Parameterisation map;
  map.base = {{{0, 1, 2}}, {{kNone, kNone, kNone}}, {0, 1, 2}};
  for (const Vec3& p : ring.positions)
    map.point.push_back({0, {1 - (p[0] + p[1]) / 18, p[0] / 18, p[1] / 18}});
  const auto before = map.point;
  const auto report = parameterise(ring, map);
  EXPECT_EQ(report.not_disks, 1u);
  EXPECT_EQ(report.solved, 0u);
  for (std::size_t v = 0; v < before.size(); ++v) EXPECT_EQ(map.point[v].weight, before[v].weight);
}

TEST(Parameterise, SurvivesWhatIsSmallOrWithoutArea) {
  const Scan triangle = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  Scan flat = shapes::grid(8, 8), point = shapes::sphere(2);
  for (Vec3& p : flat.positions) p[1] = 0;
  for (Vec3& p : point.positions) p = {1, 2, 3};
  for (const Scan& scan : {triangle, shapes::tetrahedron(), flat, point}) {
    Parameterisation map = simplified(scan, 5);
    parameterise(scan, map);
    for (const DomainPoint& p : map.point)
      EXPECT_TRUE(testing::is_valid(p, map.base.triangles.size()));
  }
}

}  // namespace
}  // namespace nacre::remesh
