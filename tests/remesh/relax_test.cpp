// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/relax.h"

#include <gtest/gtest.h>

#include "map_checks.h"
#include "remesh/adjacency.h"
#include "remesh/untangle.h"

namespace nacre::remesh {
namespace {

Parameterisation simplified(const Scan& scan, int base_vertices) {
  SimplifyOptions options;
  options.base_vertices = base_vertices;
  return *simplify(scan, options);
}

Parameterisation relaxed(const Scan& scan, Parameterisation map) {
  relax(scan, map, {});
  return map;
}

TEST(Relax, IsTheSameAtAnyThreadCount) {
  for (const auto& [name, scan] : testing::scans_of_all_kinds()) {
    SCOPED_TRACE(name);
    const Parameterisation start = simplified(scan, 40);
    const auto one = testing::with_threads(1, [&] { return relaxed(scan, start); });
    const auto two = testing::with_threads(2, [&] { return relaxed(scan, start); });
    for (std::size_t v = 0; v < one.point.size(); ++v) {
      ASSERT_EQ(one.point[v].face, two.point[v].face);
      ASSERT_EQ(one.point[v].weight, two.point[v].weight);
    }
  }
}

TEST(Relax, KeepsEveryPointValidAndTheBaseAsItIs) {
  for (const auto& [name, scan] : testing::scans_of_all_kinds()) {
    SCOPED_TRACE(name);
    const Parameterisation before = simplified(scan, 40), after = relaxed(scan, before);
    EXPECT_EQ(after.base.triangles, before.base.triangles);
    EXPECT_EQ(after.base.scan_vertex, before.base.scan_vertex);
    for (const DomainPoint& p : after.point)
      ASSERT_TRUE(testing::is_valid(p, after.base.triangles.size()));
  }
}

TEST(Relax, LeavesFewTurnedTriangles) {
  for (const int size : {8, 30, 120}) {
    const Scan scan = shapes::sphere(5);
    const auto found = testing::orientation_of(scan, relaxed(scan, simplified(scan, size)));
    EXPECT_GT(found.known, scan.triangles.size() * 9 / 10);
    EXPECT_LT(found.share(), 0.005) << size << " base vertices";
  }
  for (const auto& [name, scan] : testing::scans_of_all_kinds()) {
    const auto found = testing::orientation_of(scan, relaxed(scan, simplified(scan, 60)));
    EXPECT_LT(found.share(), 0.02) << name;
  }
}

/// Largest over smallest scan area per domain area among the triangles inside one base triangle,
/// without the most extreme percent at each end.
double stretch_range(const Scan& scan, const Parameterisation& map) {
  std::vector<double> stretch;
  for (const Triangle& t : scan.triangles) {
    const auto &a = map.point[t[0]], &b = map.point[t[1]], &c = map.point[t[2]];
    if (a.face != b.face || b.face != c.face) continue;
    const double flat = std::abs((b.weight[1] - a.weight[1]) * (c.weight[2] - a.weight[2]) -
                                 (b.weight[2] - a.weight[2]) * (c.weight[1] - a.weight[1]));
    const double area = (scan.positions[t[1]] - scan.positions[t[0]])
                            .cross(scan.positions[t[2]] - scan.positions[t[0]])
                            .norm();
    stretch.push_back(flat / area);
  }
  std::sort(stretch.begin(), stretch.end());
  const std::size_t cut = stretch.size() / 100;
  return stretch[stretch.size() - 1 - cut] / stretch[cut];
}

TEST(Relax, EvensOutTheMap) {
  const Scan scan = shapes::sphere(5);
  const Parameterisation before = simplified(scan, 30), after = relaxed(scan, before);
  EXPECT_LT(stretch_range(scan, after), 0.7 * stretch_range(scan, before));
}

TEST(Relax, SpreadsTheBoundaryByArcLength) {
  for (const Scan& scan : {shapes::hemisphere(4), shapes::holed_grid(16, 5, 11)}) {
    const Parameterisation map = relaxed(scan, simplified(scan, 30));
    const auto boundary = testing::boundary_vertices(scan);
    const auto base_boundary_side = [&](const DomainPoint& p) {
      for (std::uint32_t k = 0; k < 3; ++k)
        if (map.base.neighbors[p.face][k] == kNone && p.weight[(k + 2) % 3] == 0) return k;
      return kNone;
    };
    std::vector<char> corner(scan.positions.size(), 0);
    for (const std::uint32_t v : map.base.scan_vertex) corner[v] = 1;
    // Neighbours on the boundary between two corners: domain step over length is one constant.
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::pair<double, double>> pace;
    std::size_t checked = 0;
    for (const Triangle& t : scan.triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = t[k], b = t[(k + 1) % 3];
        if (!boundary[a] || !boundary[b] || corner[a] || corner[b]) continue;
        const DomainPoint &p = map.point[a], &q = map.point[b];
        const std::uint32_t side = base_boundary_side(p);
        ASSERT_NE(side, kNone);
        ASSERT_NE(base_boundary_side(q), kNone);
        if (p.face != q.face || side != base_boundary_side(q)) continue;
        if (q.weight[(side + 1) % 3] <= p.weight[(side + 1) % 3]) continue;  // not a boundary side
        const double step = (q.weight[(side + 1) % 3] - p.weight[(side + 1) % 3]) /
                            (scan.positions[a] - scan.positions[b]).norm();
        auto& [low, high] =
            pace.emplace(std::pair(p.face, side), std::pair(step, step)).first->second;
        low = std::min(low, step);
        high = std::max(high, step);
        ++checked;
      }
    }
    EXPECT_GT(checked, 10u);
    for (const auto& [side, range] : pace) EXPECT_NEAR(range.second / range.first, 1, 1e-9);
  }
}

TEST(Relax, SurvivesWhatIsSmallOrWithoutArea) {
  const Scan triangle = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  Scan flat = shapes::grid(8, 8), point = shapes::sphere(2);
  for (Vec3& p : flat.positions) p[1] = 0;
  for (Vec3& p : point.positions) p = {1, 2, 3};
  for (const Scan& scan : {triangle, shapes::tetrahedron(), flat, point}) {
    const Parameterisation map = relaxed(scan, simplified(scan, 5));
    for (const DomainPoint& p : map.point)
      EXPECT_TRUE(testing::is_valid(p, map.base.triangles.size()));
  }
}

/// Scan triangles upside down in the domain, in the chart of their corners.
std::size_t turned(const Scan& scan, const Parameterisation& map) {
  const Atlas atlas(map.base);
  std::size_t count = 0;
  for (const Triangle& t : scan.triangles) {
    const auto area = atlas.doubled_area({map.point[t[0]], map.point[t[1]], map.point[t[2]]});
    count += !area || *area < 0;
  }
  return count;
}

TEST(Untangle, TurnsTrianglesTheRightWayRound) {
  for (const Scan& scan : {shapes::sphere(4), shapes::torus(40, 20), shapes::bumpy_sphere(4)}) {
    Parameterisation map = relaxed(scan, simplified(scan, 40));
    ASSERT_EQ(turned(scan, map), 0u);
    // Swap the places of neighbours here and there: the triangles around them turn over.
    for (std::size_t f = 0; f < scan.triangles.size(); f += 97)
      std::swap(map.point[scan.triangles[f][0]], map.point[scan.triangles[f][1]]);
    EXPECT_GT(turned(scan, map), 5u);
    EXPECT_EQ(untangle(scan, map), 0u);
    EXPECT_EQ(turned(scan, map), 0u);
  }
}

TEST(Relax, DoesNotShrinkSmallClosedPieces) {
  const Scan scan = shapes::bumpy_sphere(4);
  const Parameterisation map = relaxed(scan, simplified(scan, 4));
  ASSERT_EQ(map.base.triangles.size(), 4u);
  const auto pinned = pinned_vertices(map);
  EXPECT_EQ(std::count(pinned.begin(), pinned.end(), 1), 4);
  for (std::uint32_t v = 0; v < 4; ++v) {
    const DomainPoint& p = map.point[map.base.scan_vertex[v]];
    EXPECT_EQ(map.base.triangles[p.face][corner_of(map.base.triangles[p.face], v)], v);
    EXPECT_EQ(p.weight[corner_of(map.base.triangles[p.face], v)], 1);
  }
  for (std::uint32_t f = 0; f < 4; ++f)
    EXPECT_GT(std::count_if(map.point.begin(), map.point.end(),
                            [f](const DomainPoint& p) { return p.face == f; }),
              static_cast<std::ptrdiff_t>(map.point.size() / 12));
}

}  // namespace
}  // namespace nacre::remesh
