// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "meshes.h"
#include "wavelet/wavelet.h"

namespace nacre::wavelet {
namespace {

using testing::random_points;
using testing::topology_of;

/// The stencils as the papers print them, weight by weight, over a map of directed edges.
class ObviousButterfly {
 public:
  ObviousButterfly(const std::vector<Triangle>& triangles, const std::vector<Vec3>& p) : p_(p) {
    for (const Triangle& t : triangles)
      for (std::size_t k = 0; k < 3; ++k) apex_[{t[k], t[(k + 1) % 3]}] = t[(k + 2) % 3];
  }

  [[nodiscard]] Vec3 midpoint(std::uint32_t a, std::uint32_t b) const {
    if (!has(a, b) || !has(b, a)) return boundary(a, b);
    const auto ring_a = ring(a, b), ring_b = ring(b, a);
    const bool odd_a = !ring_a.empty() && ring_a.size() != 6;
    const bool odd_b = !ring_b.empty() && ring_b.size() != 6;
    if (odd_a && odd_b) return (extraordinary(a, ring_a) + extraordinary(b, ring_b)) / 2;
    if (odd_a) return extraordinary(a, ring_a);
    if (odd_b) return extraordinary(b, ring_b);
    const std::uint32_t c = apex_.at({a, b}), d = apex_.at({b, a});
    return (p_[a] + p_[b]) / 2 + (p_[c] + p_[d]) / 8 -
           (wing(b, c, a) + wing(c, a, b) + wing(a, d, b) + wing(d, b, a)) / 16;
  }

 private:
  [[nodiscard]] bool has(std::uint32_t a, std::uint32_t b) const {
    return apex_.count({a, b}) != 0;
  }

  /// Beyond side u → v of the triangle with apex r.
  [[nodiscard]] Vec3 wing(std::uint32_t u, std::uint32_t v, std::uint32_t r) const {
    return has(v, u) ? p_[apex_.at({v, u})] : Vec3(p_[u] + p_[v] - p_[r]);
  }

  /// The neighbours of v counter-clockwise from `start`; empty when v is on the boundary.
  [[nodiscard]] std::vector<std::uint32_t> ring(std::uint32_t v, std::uint32_t start) const {
    std::vector<std::uint32_t> result;
    std::uint32_t u = start;
    do {
      result.push_back(u);
      if (!has(v, u)) return {};
      u = apex_.at({v, u});
    } while (u != start);
    return result;
  }

  [[nodiscard]] Vec3 extraordinary(std::uint32_t v, const std::vector<std::uint32_t>& ring) const {
    const auto K = static_cast<double>(ring.size());
    Vec3 sum = 0.75 * p_[v];
    for (std::size_t j = 0; j < ring.size(); ++j) {
      const double angle = 2 * M_PI * static_cast<double>(j) / K;
      double weight = (0.25 + std::cos(angle) + 0.5 * std::cos(2 * angle)) / K;
      if (ring.size() == 2) weight = j == 0 ? 3.0 / 8 : -1.0 / 8;
      if (ring.size() == 3) weight = j == 0 ? 5.0 / 12 : -1.0 / 12;
      if (ring.size() == 4) weight = j == 0 ? 3.0 / 8 : (j == 2 ? -1.0 / 8 : 0.0);
      sum += weight * p_[ring[j]];
    }
    return sum;
  }

  [[nodiscard]] Vec3 boundary(std::uint32_t a, std::uint32_t b) const {
    if (!has(a, b)) std::swap(a, b);
    // Turn away from the edge inside each end's fan until the mesh ends.
    std::uint32_t before = apex_.at({a, b}), after = before;
    while (has(a, before)) before = apex_.at({a, before});
    while (has(after, b)) after = apex_.at({after, b});
    return 9.0 / 16 * (p_[a] + p_[b]) - 1.0 / 16 * (p_[before] + p_[after]);
  }

  const std::vector<Vec3>& p_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> apex_;
};

TEST(Butterfly, AgreesWithTheObviousVersionOnEveryMeshAndLevel) {
  for (const auto& [name, scan] : testing::zoo()) {
    // Vertices of valence 2 make two edges between the same vertices, which no map can tell apart.
    const int levels = name == "two-sided triangle" ? 1 : 3;
    const Topology topology = topology_of(scan, levels);
    for (int j = 0; j < levels; ++j) {
      const LevelTopology& level = topology.level(j);
      const std::vector<Vec3> coarse = random_points(level.vertex_count, 11);
      const LevelPrediction fast = predict(topology, j, coarse);
      const ObviousButterfly slow(level.triangles, coarse);
      ASSERT_EQ(fast.points.size(), level.edges.size());
      for (std::size_t e = 0; e < level.edges.size(); ++e) {
        const auto [a, b] = level.edges[e].vertex;
        ASSERT_LT((fast.points[e] - slow.midpoint(a, b)).norm(), 1e-14)
            << name << ", level " << j << ", edge " << e;
      }
    }
  }
}

TEST(Butterfly, FlippedSphereHasEveryValenceFrom3To12) {
  std::vector<int> seen(20, 0);
  for (const std::uint32_t v : testing::valences(testing::flipped_sphere(2, 400, 5))) ++seen[v];
  for (std::size_t K = 3; K <= 12; ++K) EXPECT_GT(seen[K], 0) << "valence " << K;
}

TEST(Butterfly, WeightsSumToOne) {
  for (const auto& [name, scan] : testing::zoo()) {
    const Topology topology = topology_of(scan, 2);
    const Vec3 constant(0.7, -13.0, 1e3);
    for (int j = 0; j < 2; ++j) {
      const std::vector<Vec3> coarse(topology.level(j).vertex_count, constant);
      const LevelPrediction prediction = predict(topology, j, coarse);
      for (const Vec3& p : prediction.points) EXPECT_LT((p - constant).norm(), 1e-12) << name;
    }
  }
}

TEST(Butterfly, ReproducesCubicsInsideTheRegularGrid) {
  constexpr std::uint32_t n = 8;
  const Scan grid = shapes::grid(n, n);
  const auto cubic = [](double x, double y) {
    return 1 + x - 2 * y + x * x - 3 * x * y + y * y + 0.5 * x * x * x - x * x * y + 2 * x * y * y -
           0.25 * y * y * y;
  };
  std::vector<Vec3> coarse = grid.positions;
  for (Vec3& p : coarse) p[2] = cubic(p[0], p[1]);
  const Topology topology = topology_of(grid, 1);
  const LevelPrediction prediction = predict(topology, 0, coarse);
  int inside = 0;
  for (std::size_t e = 0; e < prediction.points.size(); ++e) {
    const auto [a, b] = topology.level(0).edges[e].vertex;
    const Vec3 middle = (grid.positions[a] + grid.positions[b]) / 2;
    const double margin = std::min({middle[0], middle[1], n - middle[0], n - middle[1]});
    if (margin < 1.1) continue;  // a wing may be a mirror image
    ++inside;
    EXPECT_NEAR(prediction.points[e][0], middle[0], 1e-13);
    EXPECT_NEAR(prediction.points[e][1], middle[1], 1e-13);
    EXPECT_NEAR(prediction.points[e][2], cubic(middle[0], middle[1]), 1e-11);
  }
  EXPECT_GT(inside, 60);
}

TEST(Butterfly, IsExactForLinearFunctionsUpToTheBoundaryButItsCorners) {
  constexpr std::uint32_t n = 5;
  const Topology topology = topology_of(shapes::grid(n, n), 1);
  const std::vector<Vec3> coarse = shapes::grid(n, n).positions;
  const LevelPrediction prediction = predict(topology, 0, coarse);
  for (std::size_t e = 0; e < prediction.points.size(); ++e) {
    const Edge& edge = topology.level(0).edges[e];
    const Vec3 middle = (coarse[edge.vertex[0]] + coarse[edge.vertex[1]]) / 2;
    // The four-point rule bends the curve where the boundary turns.
    const auto at_corner = [&](std::uint32_t v) {
      return (coarse[v][0] == 0 || coarse[v][0] == n) && (coarse[v][1] == 0 || coarse[v][1] == n);
    };
    if (edge.is_boundary() && (at_corner(edge.vertex[0]) || at_corner(edge.vertex[1]))) continue;
    EXPECT_LT((prediction.points[e] - middle).norm(), 1e-14) << e;
  }
}

// [Zorin1996] derives the ring weights from just this: on the regular K-gon the functions z, and
// from K = 4 on also z^2 and |z|^2, are sampled at half the radius.
TEST(Butterfly, RingStencilsReproduceQuadraticsOnRegularPolygons) {
  for (const std::uint32_t K : {3u, 4u, 5u, 7u, 8u, 9u, 12u, 31u, 64u}) {
    const Scan disk = testing::cone(K, false);
    const Topology topology = topology_of(disk, 1);
    std::vector<Vec3> linear(K + 1, Vec3::Zero()), square(K + 1, Vec3::Zero());
    for (std::uint32_t i = 0; i < K; ++i) {
      const double angle = 2 * M_PI * i / K;
      linear[1 + i] = {std::cos(angle), std::sin(angle), 0};
      square[1 + i] = {std::cos(2 * angle), K == 4 ? 0 : std::sin(2 * angle), 1};
    }
    const auto first = predict(topology, 0, linear).points;
    const auto second = predict(topology, 0, square).points;
    for (std::size_t e = 0; e < first.size(); ++e) {
      const Edge& edge = topology.level(0).edges[e];
      if (edge.is_boundary()) continue;
      const std::uint32_t rim = std::max(edge.vertex[0], edge.vertex[1]);
      EXPECT_LT((first[e] - linear[rim] / 2).norm(), 1e-14) << "K = " << K;
      if (K > 3) {
        EXPECT_LT((second[e] - square[rim] / 4).norm(), 1e-14) << "K = " << K;
      }
    }
  }
}

TEST(Butterfly, BoundaryFollowsTheFourPointRule) {
  // Cubics of the position along the bottom row are exact; nothing above it matters.
  constexpr std::uint32_t n = 6;
  const Scan grid = shapes::grid(n, 2);
  std::vector<Vec3> coarse = random_points(grid.positions.size(), 3);
  const auto on_curve = [](double x) { return Vec3(x, x * x, 1 - x * x * x); };
  for (std::uint32_t i = 0; i <= n; ++i) coarse[i * 3] = on_curve(i);
  const Topology topology = topology_of(grid, 1);
  const LevelPrediction prediction = predict(topology, 0, coarse);
  int checked = 0;
  for (std::size_t e = 0; e < prediction.points.size(); ++e) {
    const auto [a, b] = topology.level(0).edges[e].vertex;
    if (a % 3 != 0 || b % 3 != 0) continue;
    const double x = (a + b) / 6.0;
    if (x < 1 || x > n - 1) continue;
    EXPECT_LT((prediction.points[e] - on_curve(x)).norm(), 1e-12);
    ++checked;
  }
  EXPECT_EQ(checked, 4);
}

TEST(Butterfly, MirrorsWingsThatTheBoundaryCutsOff) {
  // Two triangles 0 1 2 and 1 0 3: all four wings of edge 0-1 are mirror images. Their sum is
  // (b+c-a) + (c+a-b) + (a+d-b) + (d+b-a) = 2c + 2d, so the prediction is (a + b) / 2.
  const Topology topology = *Topology::build(std::vector<Triangle>{{0, 1, 2}, {1, 0, 3}}, 4, 1);
  const std::vector<Vec3> coarse = random_points(4, 9);
  const LevelPrediction prediction = predict(topology, 0, coarse);
  EXPECT_LT((prediction.points[0] - (coarse[0] + coarse[1]) / 2).norm(), 1e-15);
}

TEST(Butterfly, CostIsLinearInTheValence) {
  // K^2 products would be 4e10 here, and minutes; the suite's limit would notice.
  constexpr std::uint32_t K = 200000;
  const Scan bipyramid = testing::cone(K, true);
  const Topology topology = topology_of(bipyramid, 1);
  const LevelPrediction prediction = predict(topology, 0, bipyramid.positions);
  for (std::size_t e = 0; e < prediction.points.size(); e += 10007)
    EXPECT_TRUE(prediction.points[e].allFinite());
  const Scan disk = testing::cone(K, false);  // an open fan, seen from its rim's vertices
  EXPECT_EQ(predict(topology_of(disk, 1), 0, disk.positions).points.size(), 2 * K);
}

TEST(Butterfly, OpenFansAreLinearToo) {
  constexpr std::uint32_t K = 200000;
  Scan fan = testing::cone(K, false);
  fan.triangles.pop_back();
  EXPECT_EQ(predict(topology_of(fan, 1), 0, fan.positions).points.size(), 2 * K - 1);
}

}  // namespace
}  // namespace nacre::wavelet
