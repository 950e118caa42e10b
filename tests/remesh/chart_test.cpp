// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/chart.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "map_checks.h"
#include "remesh/adjacency.h"
#include "support/random.h"

namespace nacre::remesh {
namespace {

using Vec2 = Eigen::Vector2d;

BaseMesh base_of(const Scan& scan) {
  BaseMesh base;
  base.triangles = scan.triangles;
  base.neighbors =
      side_neighbors(scan.triangles, static_cast<std::uint32_t>(scan.positions.size()));
  for (std::uint32_t v = 0; v < scan.positions.size(); ++v) base.scan_vertex.push_back(v);
  return base;
}

/// K triangles around vertex 0; a closed fan, or an open one with vertex 0 on the boundary.
BaseMesh fan(std::uint32_t K, bool closed) {
  Scan scan;
  scan.positions.resize(closed ? K + 1 : K + 2);
  for (std::uint32_t m = 0; m < K; ++m)
    scan.triangles.push_back({0, 1 + m, closed ? 1 + (m + 1) % K : 2 + m});
  return base_of(scan);
}

DomainPoint random_point(TestRandom& random, std::uint32_t face) {
  double a = random.unit(), b = random.unit();
  if (a + b > 1) a = 1 - a, b = 1 - b;
  return {face, {1 - a - b, a, b}};
}

void expect_same(const DomainPoint& p, const DomainPoint& q) {
  EXPECT_EQ(p.face, q.face);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(p.weight[k], q.weight[k], 1e-12);
}

/// Every point of the faces comes back from the plane.
void expect_round_trip(const Atlas::Chart& chart, const std::vector<std::uint32_t>& faces,
                       TestRandom& random) {
  for (int i = 0; i < 50; ++i) {
    const DomainPoint p = random_point(random, faces[random.below(faces.size())]);
    const auto place = chart.map(p);
    ASSERT_TRUE(place.has_value());
    expect_same(chart.unmap(*place), p);
  }
}

TEST(Chart, RoundTripsOneTriangleAndPairs) {
  TestRandom random(1);
  for (const Scan& scan : {shapes::icosahedron(), shapes::torus(5, 4), shapes::grid(3, 3)}) {
    const BaseMesh base = base_of(scan);
    const Atlas atlas(base);
    for (std::uint32_t f = 0; f < base.triangles.size(); ++f) {
      expect_round_trip(atlas.triangle_chart(f), {f}, random);
      for (const std::uint32_t g : base.neighbors[f]) {
        if (g == kNone) continue;
        const std::vector<std::uint32_t> pair = {f, g};
        const auto chart = atlas.common_chart(pair);
        ASSERT_TRUE(chart.has_value());
        expect_round_trip(*chart, pair, random);
      }
    }
  }
}

TEST(Chart, RoundTripsStarsOfAllValences) {
  TestRandom random(2);
  for (std::uint32_t K = 3; K <= 9; ++K) {
    for (const bool closed : {true, false}) {
      const BaseMesh base = fan(K, closed);
      const Atlas atlas(base);
      const std::vector<std::uint32_t> three = {0, 1, 2};
      const auto chart = atlas.common_chart(three);
      ASSERT_TRUE(chart.has_value());
      std::vector<std::uint32_t> all(K);
      for (std::uint32_t f = 0; f < K; ++f) all[f] = f;
      for (int i = 0; i < 20; ++i) expect_round_trip(*chart, all, random);
      // The centre is the corner of all of them.
      for (std::uint32_t f = 0; f < K; ++f) EXPECT_LT(chart->map({f, {1, 0, 0}})->norm(), 1e-15);
    }
  }
}

TEST(Chart, UnfoldsWithoutOverlap) {
  TestRandom random(3);
  for (std::uint32_t K = 3; K <= 9; ++K) {
    for (const bool closed : {true, false}) {
      const BaseMesh base = fan(K, closed);
      const Atlas atlas(base);
      const std::vector<std::uint32_t> three = {0, 1, 2};
      const auto chart = atlas.common_chart(three);
      for (std::uint32_t f = 0; f < K; ++f) {
        const Vec2 a = *chart->map({f, {1, 0, 0}}), b = *chart->map({f, {0, 1, 0}}),
                   c = *chart->map({f, {0, 0, 1}});
        EXPECT_GT((b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0], 0.1);
      }
    }
  }
}

/// A point of a shared side is at one place, whichever of its triangles it is seen from.
void expect_continuous(const Atlas::Chart& chart, const BaseMesh& base, std::uint32_t f,
                       std::uint32_t k, double t) {
  const std::uint32_t g = base.neighbors[f][k];
  DomainPoint p{f, {}}, q{g, {}};
  p.weight[k] = 1 - t;
  p.weight[(k + 1) % 3] = t;
  q.weight[corner_of(base.triangles[g], base.triangles[f][k])] = 1 - t;
  q.weight[corner_of(base.triangles[g], base.triangles[f][(k + 1) % 3])] = t;
  EXPECT_LT((*chart.map(p) - *chart.map(q)).norm(), 1e-14);
}

TEST(Chart, IsContinuousAcrossSharedSides) {
  const BaseMesh base = base_of(shapes::icosahedron());
  const Atlas atlas(base);
  for (std::uint32_t f = 0; f < base.triangles.size(); ++f) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::vector<std::uint32_t> pair = {f, base.neighbors[f][k]};
      for (const double t : {0.0, 0.3, 1.0})
        expect_continuous(*atlas.common_chart(pair), base, f, k, t);
      // The star around the side's first corner has the pair and one more.
      const std::vector<std::uint32_t> three = {f, pair[1], base.neighbors[f][(k + 2) % 3]};
      for (const double t : {0.0, 0.3, 1.0})
        expect_continuous(*atlas.common_chart(three), base, f, k, t);
    }
  }
}

TEST(Chart, PairIsMadeOfUnitTriangles) {
  const BaseMesh base = base_of(shapes::octahedron());
  const Atlas atlas(base);
  const std::vector<std::uint32_t> pair = {0, base.neighbors[0][1]};
  const auto chart = atlas.common_chart(pair);
  for (const std::uint32_t f : pair) {
    std::array<Vec2, 3> c;
    for (std::size_t k = 0; k < 3; ++k) {
      DomainPoint p{f, {}};
      p.weight[k] = 1;
      c[k] = *chart->map(p);
    }
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR((c[k] - c[(k + 1) % 3]).norm(), 1, 1e-14);
  }
}

TEST(CommonChart, IsTheSameInAnyOrder) {
  TestRandom random(4);
  const BaseMesh base = base_of(shapes::icosahedron());
  const Atlas atlas(base);
  Star star;
  const auto first = face_of_vertex(base.triangles, 12);
  for (int i = 0; i < 500; ++i) {
    const std::uint32_t v = random.below(12);
    collect_star(base.triangles, base.neighbors, v, first[v], star);
    std::vector<std::uint32_t> faces;
    const std::uint32_t count = 1 + random.below(5);
    for (std::uint32_t k = 0; k < count; ++k)
      faces.push_back(star.faces[random.below(star.faces.size())]);
    const auto chart = atlas.common_chart(faces);
    ASSERT_TRUE(chart.has_value());
    const DomainPoint p = random_point(random, faces[0]);
    const Vec2 place = *chart->map(p);
    std::sort(faces.begin(), faces.end());
    do {
      EXPECT_EQ(*atlas.common_chart(faces)->map(p), place);
    } while (std::next_permutation(faces.begin(), faces.end()));
  }
}

TEST(CommonChart, IsANetWithoutACommonCorner) {
  TestRandom random(5);
  const BaseMesh base = base_of(shapes::icosahedron());
  const Atlas atlas(base);
  for (std::uint32_t f = 0; f < 20; ++f) {
    // Around a triangle: its three neighbours share no corner. Unfolded, all four have unit sides.
    const std::vector<std::uint32_t> faces = {base.neighbors[f][0], base.neighbors[f][1],
                                              base.neighbors[f][2], f};
    const auto net = atlas.common_chart(faces);
    ASSERT_TRUE(net.has_value());
    expect_round_trip(*net, faces, random);
    for (const std::uint32_t g : faces)
      EXPECT_NEAR((*net->map({g, {1, 0, 0}}) - *net->map({g, {0, 1, 0}})).norm(), 1, 1e-14);
    for (std::uint32_t k = 0; k < 3; ++k)
      for (const double t : {0.0, 0.3, 1.0}) expect_continuous(*net, base, f, k, t);
  }
}

TEST(CommonChart, IsNothingAcrossPieces) {
  Scan two = shapes::icosahedron();
  const auto n = static_cast<std::uint32_t>(two.positions.size());
  const std::size_t faces = two.triangles.size();
  for (std::size_t f = 0; f < faces; ++f) {
    const Triangle t = two.triangles[f];
    two.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
  }
  two.positions.insert(two.positions.end(), two.positions.begin(), two.positions.begin() + n);
  const BaseMesh base = base_of(two);
  const Atlas atlas(base);
  const std::vector<std::uint32_t> apart = {0, 20};
  EXPECT_FALSE(atlas.common_chart(apart).has_value());
}

TEST(Chart, KnowsWhatIsNotItsOwn) {
  const BaseMesh base = base_of(shapes::icosahedron());
  const Atlas atlas(base);
  const std::vector<std::uint32_t> pair = {0, base.neighbors[0][0]};
  const std::vector<std::uint32_t> three = {0, base.neighbors[0][0], base.neighbors[0][2]};
  for (const auto& chart :
       {atlas.triangle_chart(0), *atlas.common_chart(pair), *atlas.common_chart(three)}) {
    std::size_t mapped = 0;
    for (std::uint32_t f = 0; f < 20; ++f) mapped += chart.map({f, {1, 0, 0}}).has_value();
    EXPECT_TRUE(mapped == 1 || mapped == 2 || mapped == 5);
  }
}

TEST(Chart, PutsOutsidePlacesOntoItsBorder) {
  TestRandom random(6);
  for (std::uint32_t K = 3; K <= 9; ++K) {
    for (const bool closed : {true, false}) {
      const BaseMesh base = fan(K, closed);
      const Atlas atlas(base);
      for (const std::vector<std::uint32_t>& faces :
           {std::vector<std::uint32_t>{0}, {0, 1}, {0, 1, 2}}) {
        const auto chart = atlas.common_chart(faces);
        for (int i = 0; i < 50; ++i) {
          const Vec2 place(5 * random.signed_unit(), 5 * random.signed_unit());
          const DomainPoint p = chart->unmap(place);
          EXPECT_TRUE(testing::is_valid(p, base.triangles.size()));
          if (place.norm() > 2.1) {
            EXPECT_NEAR(std::min({p.weight[0], p.weight[1], p.weight[2]}), 0, 1e-12);
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace nacre::remesh
