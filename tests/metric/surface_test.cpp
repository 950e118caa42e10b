// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "metric/metric.h"
#include "metric/sampling.h"
#include "metric/triangle.h"
#include "support/shapes.h"

namespace nacre::metric {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

double uniform(std::mt19937_64& engine) { return static_cast<double>(engine() >> 11) * 0x1p-53; }
Vec3 uniform_point(std::mt19937_64& engine) {
  const double x = uniform(engine), y = uniform(engine), z = uniform(engine);
  return {x, y, z};
}

Scan random_soup(std::mt19937_64& engine, std::uint32_t triangles, double size) {
  Scan scan;
  for (std::uint32_t f = 0; f < triangles; ++f) {
    const Vec3 at = uniform_point(engine);
    for (int k = 0; k < 3; ++k) scan.positions.push_back(at + size * uniform_point(engine));
    scan.triangles.push_back({3 * f, 3 * f + 1, 3 * f + 2});
  }
  return scan;
}

/// Nearest point by ternary search over both barycentric coordinates: slow, but shares no thought
/// with the real one. The squared distance is convex over the triangle, so nested searches are
/// safe.
double slow_distance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto minimum = [](const auto& f, double low, double high) {
    for (int i = 0; i < 60; ++i) {
      const double l = low + (high - low) / 3, h = high - (high - low) / 3;
      (f(l) < f(h) ? high : low) = f(l) < f(h) ? h : l;
    }
    return f((low + high) / 2);
  };
  return std::sqrt(minimum(
      [&](double u) {
        return minimum([&](double v) { return (a + u * (b - a) + v * (c - a) - p).squaredNorm(); },
                       0.0, 1 - u);
      },
      0.0, 1.0));
}

TEST(ClosestOnTriangle, AgreesWithSearch) {
  std::mt19937_64 engine(3);
  for (int i = 0; i < 300; ++i) {
    const Vec3 a = uniform_point(engine), b = uniform_point(engine), c = uniform_point(engine);
    const Vec3 p = 4 * (uniform_point(engine) - Vec3::Constant(0.5));
    const double fast = norm(p - closest_on_triangle(p, a, b, c));
    EXPECT_NEAR(fast, slow_distance(p, a, b, c), 1e-7);
  }
}

TEST(ClosestOnTriangle, ThinAndDegenerateTrianglesGiveTheirNearestPoint) {
  std::mt19937_64 engine(4);
  for (const double thickness : {1e-3, 1e-6, 1e-8, 1e-12, 1e-16, 0.0}) {
    for (int i = 0; i < 100; ++i) {
      const Vec3 a = uniform_point(engine), b = uniform_point(engine);
      const Vec3 c = a + uniform(engine) * (b - a) + thickness * uniform_point(engine);
      const Vec3 p = 3 * uniform_point(engine);
      const Vec3 q = closest_on_triangle(p, a, b, c);
      ASSERT_TRUE(q.allFinite());
      EXPECT_NEAR(norm(p - q), norm(p - closest_on_sides(p, a, b, c)), 2 * thickness + 1e-12);
    }
  }
  const Vec3 point(1, 2, 3);
  EXPECT_EQ(closest_on_triangle({9, 9, 9}, point, point, point), point);
}

TEST(Surface, NearestAgreesWithTryingEveryTriangle) {
  std::mt19937_64 engine(5);
  for (const std::uint32_t triangles : {1u, 2u, 3u, 4u, 5u, 17u, 400u}) {
    const Scan soup = random_soup(engine, triangles, triangles > 100 ? 0.1 : 1.0);
    const Surface surface = *Surface::build(soup);
    Surface::Nearest last;
    for (int i = 0; i < 300; ++i) {
      const Vec3 p = 2 * uniform_point(engine) - Vec3::Constant(0.5);
      double expected = kInf;
      for (const Triangle& t : soup.triangles)
        expected = std::min(
            expected, norm(p - closest_on_triangle(p, soup.positions[t[0]], soup.positions[t[1]],
                                                   soup.positions[t[2]])));
      const Surface::Nearest found = surface.nearest(p);
      last = surface.nearest(p, last);  // any answer is a fair hint
      EXPECT_DOUBLE_EQ(found.distance, expected);
      EXPECT_DOUBLE_EQ(last.distance, expected);
      const Triangle& t = soup.triangles[found.triangle];
      const Vec3 foot =
          closest_on_triangle(p, soup.positions[t[0]], soup.positions[t[1]], soup.positions[t[2]]);
      EXPECT_EQ(found.point, foot);
    }
  }
}

TEST(Surface, DistancesAreInOrder) {
  std::mt19937_64 engine(6);
  const Surface surface = *Surface::build(shapes::sphere(4));
  std::vector<Vec3> queries;
  for (int i = 0; i < 5000; ++i) queries.push_back(3 * uniform_point(engine));
  queries[77] = {std::nan(""), 0, 0};
  const std::vector<double> distances = surface.distances(queries);
  ASSERT_EQ(distances.size(), queries.size());
  for (std::size_t i = 0; i < queries.size(); ++i)
    EXPECT_DOUBLE_EQ(distances[i], surface.nearest(queries[i]).distance);
  EXPECT_EQ(distances[77], kInf);
  EXPECT_EQ(surface.nearest(queries[77]).triangle, kNone);
  EXPECT_DOUBLE_EQ(distances[78], surface.nearest(queries[78]).distance);
  EXPECT_TRUE(surface.distances({}).empty());
}

TEST(Sampler, SharesTheSamplesByArea) {
  std::mt19937_64 engine(7);
  const Scan soup = random_soup(engine, 500, 0.3);
  const SurfaceSampler sampler(soup, 10'000, 1);
  std::vector<std::uint32_t> order;
  ASSERT_EQ(sampler.size(), 10'000u);
  EXPECT_EQ(sampler.vertices().size(), soup.positions.size());
  double total = 0;
  for (const Triangle& t : soup.triangles)
    total += twice_area(soup.positions[t[0]], soup.positions[t[1]], soup.positions[t[2]]);
  const Surface surface = *Surface::build(soup);
  std::vector<double> count(soup.triangles.size(), 0);
  sampler.for_each(0, sampler.size(), [&](const Vec3& p) {
    const Surface::Nearest nearest = surface.nearest(p);
    ASSERT_LT(nearest.distance, 1e-14);  // on the surface
    count[nearest.triangle] += 1;
  });
  for (std::size_t f = 0; f < count.size(); ++f) {
    const Triangle& t = soup.triangles[f];
    const double area =
        twice_area(soup.positions[t[0]], soup.positions[t[1]], soup.positions[t[2]]);
    EXPECT_NEAR(count[f], area / total * 10'000, 1.001) << f;
  }
}

TEST(Sampler, FillsATriangleEvenly) {
  Scan scan;
  scan.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  scan.triangles = {{0, 1, 2}};
  const SurfaceSampler sampler(scan, 10'000, 9);
  constexpr int kCells = 10;  // cells of the unit square that lie wholly inside hold 2 / 100 each
  std::vector<int> count(kCells * kCells, 0);
  Vec3 sum = Vec3::Zero();
  sampler.for_each(0, sampler.size(), [&](const Vec3& p) {
    ASSERT_GE(p[0], 0);
    ASSERT_GE(p[1], 0);
    ASSERT_LE(p[0] + p[1], 1 + 1e-15);
    ++count[static_cast<int>(p[0] * kCells) * kCells + static_cast<int>(p[1] * kCells)];
    sum += p;
  });
  for (int i = 0; i < kCells; ++i)
    for (int k = 0; i + k < kCells - 1; ++k) EXPECT_NEAR(count[i * kCells + k], 200, 12);
  EXPECT_NEAR(sum[0] / 10'000, 1.0 / 3, 5e-4);
  EXPECT_NEAR(sum[1] / 10'000, 1.0 / 3, 5e-4);
}

TEST(Sampler, PartsGiveTheSamePointsAsTheWhole) {
  const Scan scan = shapes::torus(12, 9);
  const SurfaceSampler sampler(scan, 5000, 2);
  std::vector<Vec3> whole, parts;
  sampler.for_each(0, 5000, [&](const Vec3& p) { whole.push_back(p); });
  for (std::size_t i = 0; i < 5000; i += 700)
    sampler.for_each(i, std::min<std::size_t>(i + 700, 5000),
                     [&](const Vec3& p) { parts.push_back(p); });
  ASSERT_EQ(whole.size(), 5000u);
  EXPECT_EQ(whole, parts);
}

}  // namespace
}  // namespace nacre::metric
