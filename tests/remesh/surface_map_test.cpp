// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/surface_map.h"

#include <gtest/gtest.h>

#include "map_checks.h"
#include "remesh/relax.h"
#include "support/random.h"

namespace nacre::remesh {
namespace {

Parameterisation mapped(const Scan& scan, int base_vertices) {
  SimplifyOptions options;
  options.base_vertices = base_vertices;
  Parameterisation map = *simplify(scan, options);
  relax(scan, map, {});
  return map;
}

template <class Point>
Point random_point(TestRandom& random, std::size_t faces) {
  double a = random.unit(), b = random.unit();
  if (a + b > 1) a = 1 - a, b = 1 - b;
  return {random.below(faces), {1 - a - b, a, b}};
}

/// The share of random points p for which to_surface(to_domain(p)) is p.
double round_trips(const Scan& scan, const Parameterisation& map, bool with_hint) {
  const SurfaceMap both(scan, map);
  TestRandom random(17);
  constexpr int kCount = 4000;
  double returned = 0;
  for (int i = 0; i < kCount; ++i) {
    const auto p = random_point<SurfacePoint>(random, scan.triangles.size());
    const DomainPoint q = both.to_domain(p);
    EXPECT_TRUE(testing::is_valid(q, map.base.triangles.size()));
    const SurfacePoint back = both.to_surface(q, with_hint ? p.face : kNone);
    EXPECT_TRUE(testing::is_valid(back, scan.triangles.size()));
    const double off = (position_of(back, scan.triangles, scan.positions) -
                        position_of(p, scan.triangles, scan.positions))
                           .norm();
    returned += off < 1e-6;
  }
  return returned / kCount;
}

TEST(SurfaceMap, ComesBackToNearlyEveryPoint) {
  for (const auto& [name, scan] : testing::scans_of_all_kinds()) {
    SCOPED_TRACE(name);
    const Parameterisation map = mapped(scan, 60);
    for (const bool with_hint : {true, false}) {
      const double returned = round_trips(scan, map, with_hint);
      // Sharp edges turn triangles over, and there a map has more than one way back. A hint leads
      // to the one that the point came from.
      const double least = name == "double torus" ? 0.93 : (with_hint ? 0.99 : 0.97);
      EXPECT_GE(returned, least) << (with_hint ? "with a hint" : "without a hint");
    }
  }
}

TEST(SurfaceMap, TakesScanVerticesToTheirDomainPoints) {
  const Scan scan = shapes::bumpy_sphere(4);
  const Parameterisation map = mapped(scan, 60);
  const SurfaceMap both(scan, map);
  const Atlas atlas(map.base);
  for (std::uint32_t f = 0; f < scan.triangles.size(); ++f) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      SurfacePoint p{f, {}};
      p.weight[k] = 1;
      const DomainPoint q = both.to_domain(p), expected = map.point[scan.triangles[f][k]];
      // The same place, possibly seen from the triangle next door.
      const std::array<std::uint32_t, 2> faces = {q.face, expected.face};
      const auto chart = atlas.common_chart(faces);
      ASSERT_TRUE(chart.has_value());
      EXPECT_LT((*chart->map(q) - *chart->map(expected)).norm(), 1e-9);
    }
  }
}

TEST(SurfaceMap, AnswersEveryDomainPointFromAnyHint) {
  for (const auto& [name, scan] : testing::scans_of_all_kinds()) {
    SCOPED_TRACE(name);
    const Parameterisation map = mapped(scan, 60);
    const SurfaceMap both(scan, map);
    TestRandom random(23);
    std::size_t same = 0;
    constexpr std::size_t kCount = 1000;
    for (std::size_t i = 0; i < kCount; ++i) {
      DomainPoint q = random_point<DomainPoint>(random, map.base.triangles.size());
      if (i % 5 == 0) q.weight = {0, 0.5, 0.5};
      if (i % 5 == 1) q.weight = {0, 0, 1};
      const SurfacePoint a = both.to_surface(q, random.below(scan.triangles.size()));
      const SurfacePoint b = both.to_surface(q, kNone);
      EXPECT_TRUE(testing::is_valid(a, scan.triangles.size()));
      EXPECT_TRUE(testing::is_valid(b, scan.triangles.size()));
      same += (position_of(a, scan.triangles, scan.positions) -
               position_of(b, scan.triangles, scan.positions))
                  .norm() < 1e-6;
    }
    EXPECT_GE(same, kCount * 97 / 100);
  }
}

TEST(SurfaceMap, StartsAtTheScanVertexOfEachBaseVertex) {
  const Scan scan = shapes::torus(40, 20);
  const Parameterisation map = mapped(scan, 60);
  const SurfaceMap both(scan, map);
  for (std::uint32_t v = 0; v < map.base.scan_vertex.size(); ++v) {
    const Triangle& t = scan.triangles[both.start_triangle(v)];
    EXPECT_NE(std::find(t.begin(), t.end(), map.base.scan_vertex[v]), t.end());
  }
}

TEST(SurfaceMap, IsValidOnAScanThatIsItsOwnBase) {
  const Scan triangle = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  for (const Scan& scan : {triangle, shapes::tetrahedron(), shapes::icosahedron(),
                           shapes::grid(4, 4), shapes::torus(6, 5)}) {
    const Parameterisation map = mapped(scan, 1000);
    ASSERT_EQ(map.base.triangles.size(), scan.triangles.size());
    for (const bool with_hint : {true, false}) {
      const double returned = round_trips(scan, map, with_hint);
      if (scan.triangles.size() == 1) {
        EXPECT_EQ(returned, 1);
      }
    }
  }
}

}  // namespace
}  // namespace nacre::remesh
