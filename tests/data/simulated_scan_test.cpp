// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "data/ammonite.h"
#include "data/merge.h"
#include "data/random.h"
#include "data/range_view.h"
#include "data/simulate.h"
#include "io/io.h"
#include "io/write.h"

namespace nacre::data {
namespace {

SimulationOptions small() {
  SimulationOptions options;
  options.turntable_views = 4;
  options.view_pixels = 96;
  options.voxels = 56;
  options.faces = 3000;
  return options;
}

Target sculpture() { return {ammonite, kLipschitz, kBoundingRadius}; }

Target unit_sphere() {
  return {[](const Vec3& p) { return norm(p) - 1; }, 1.0, 1.5};
}

std::vector<std::uint8_t> bytes_of(const Scan& scan) {
  return *io::serialize_mesh(scan, io::MeshFormat::kPly);
}

std::size_t boundary_edges(const Scan& scan) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> sides;
  for (const Triangle& t : scan.triangles)
    for (std::size_t k = 0; k < 3; ++k) sides.insert({t[k], t[(k + 1) % 3]});
  EXPECT_EQ(sides.size(), 3 * scan.triangles.size()) << "a directed edge is used twice";
  return static_cast<std::size_t>(std::count_if(sides.begin(), sides.end(), [&](const auto& s) {
    return sides.count({s.second, s.first}) == 0;
  }));
}

TEST(SimulateScan, IsTheSameBytesInEveryRunAndAtAnyThreadCount) {
  const auto first = simulate_scan(sculpture(), small());
  ASSERT_TRUE(first.has_value());
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto second = simulate_scan(sculpture(), small());
  ASSERT_TRUE(second.has_value());
  EXPECT_EQ(bytes_of(*first), bytes_of(*second));
}

TEST(SimulateScan, AnotherSeedGivesAnotherScan) {
  SimulationOptions other = small();
  ++other.seed;
  EXPECT_NE(bytes_of(*simulate_scan(sculpture(), small())),
            bytes_of(*simulate_scan(sculpture(), other)));
}

TEST(SimulateScan, LiesOnTheTargetUpToItsNoise) {
  SimulationOptions options = small();
  options.dust = 0;
  options.unit = 1;
  const auto scan = simulate_scan(unit_sphere(), options);
  ASSERT_TRUE(scan.has_value());
  double squares = 0, worst = 0;
  for (const Vec3& p : scan->positions) {
    const double d = std::abs(norm(p) - 1);
    squares += d * d;
    worst = std::max(worst, d);
  }
  const double rms = std::sqrt(squares / static_cast<double>(scan->positions.size()));
  EXPECT_LT(rms, 0.012);
  EXPECT_GT(rms, 0.001);  // a scan without noise is none
  EXPECT_LT(worst, 0.12);
}

TEST(SimulateScan, RefusesOptionsOutOfRange) {
  SimulationOptions options = small();
  options.voxels = 1;
  EXPECT_EQ(simulate_scan(sculpture(), options).error().code, ErrorCode::kBadInput);
  options = small();
  options.unit = std::nan("");
  EXPECT_EQ(simulate_scan(sculpture(), options).error().code, ErrorCode::kBadInput);
}

TEST(SimulateScan, RefusesATargetThatNoViewSees) {
  const Target nothing{[](const Vec3&) { return 1.0; }, 1.0, 1.0};
  EXPECT_EQ(simulate_scan(nothing, small()).error().code, ErrorCode::kBadInput);
}

TEST(MergeViews, NoiselessViewsOfASphereGiveItBack) {
  SimulationOptions options = small();
  options.turntable_views = 8;
  options.depth_noise = options.registration = options.rotation_deg = 0;
  options.dust = options.dark_spots = 0;
  const Target target = unit_sphere();
  const Scan scan = drop_islands(merge_views(scan_views(target, options), target, options), 16);
  ASSERT_FALSE(scan.triangles.empty());
  double volume = 0, worst = 0;
  for (const Triangle& t : scan.triangles) {
    volume += dot(scan.positions[t[0]], cross(scan.positions[t[1]], scan.positions[t[2]])) / 6;
    for (const std::uint32_t v : t) {
      const Vec3& p = scan.positions[v];
      if (p[1] > -0.6) worst = std::max(worst, std::abs(norm(p) - 1));  // below, views only graze
    }
  }
  EXPECT_LT(worst, 0.03);            // half a voxel
  EXPECT_GT(volume, 0.9 * 4.18879);  // positive: faces outward; the lower pole may be open
  EXPECT_EQ(component_sizes(scan).size(), 1U);
  boundary_edges(scan);
}

TEST(DropIslands, KeepsLargeComponentsOnly) {
  Scan scan;  // a strip of three faces and a lone one, and a vertex on no face
  for (int i = 0; i < 9; ++i) scan.positions.emplace_back(i, i % 2, 0);
  scan.triangles = {{0, 1, 2}, {1, 3, 2}, {5, 6, 7}, {2, 3, 4}};
  EXPECT_EQ(component_sizes(scan), (std::vector<std::size_t>{3, 1}));
  const Scan kept = drop_islands(scan, 2);
  EXPECT_EQ(kept.triangles.size(), 3U);
  EXPECT_EQ(kept.positions.size(), 5U);
  EXPECT_TRUE(drop_islands(scan, 4).triangles.empty());
}

TEST(Simplify, ReachesItsFaceCountAndKeepsTheShape) {
  SimulationOptions options = small();
  const Target target = unit_sphere();
  const Scan fine = drop_islands(merge_views(scan_views(target, options), target, options), 100);
  const Scan coarse = simplify(fine, 2000);
  EXPECT_LT(coarse.triangles.size(), 2100U);
  EXPECT_GT(coarse.triangles.size(), 1500U);
  for (const Triangle& t : coarse.triangles) EXPECT_NEAR(norm(coarse.positions[t[0]]), 1, 0.1);
}

TEST(Ammonite, ARayMayStepAsFarAsItSays) {
  const Random random{7};
  int steps = 0;
  for (std::uint64_t i = 0; i < 200'000; ++i) {
    const Vec3 p = kBoundingRadius * random.uniform(1, i) * random.direction(2, i);
    const double d = ammonite(p);
    if (d <= 0) continue;
    const double step = 0.999 * d / kLipschitz * random.uniform(4, i);
    ASSERT_GT(ammonite(p + step * random.direction(3, i)), 0) << p.transpose();
    ++steps;
  }
  EXPECT_GT(steps, 50'000);
}

TEST(Ammonite, LiesInItsBoundingBall) {
  const Random random{8};
  for (std::uint64_t i = 0; i < 5000; ++i)
    ASSERT_GT(ammonite(kBoundingRadius * random.direction(1, i)), 0);
}

TEST(DefaultScan, LooksLikeARawScan) {
  const auto read =
      io::read_scan(std::filesystem::path(NACRE_SOURCE_DIR) / "data" / "ammonite_scan.ply");
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_LE(read->report.file_bytes, 2'000'000U);
  const Scan& scan = read->scan;
  EXPECT_GE(scan.triangles.size(), 60'000U);
  EXPECT_LE(scan.triangles.size(), 120'000U);
  const std::size_t components = component_sizes(scan).size();
  EXPECT_GE(components, 4U);
  EXPECT_LE(components, 11U);
  EXPECT_GT(boundary_edges(scan), 100U);
}

}  // namespace
}  // namespace nacre::data
