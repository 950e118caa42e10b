// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>

#include "metric/metric.h"
#include "support/shapes.h"

namespace nacre::metric {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

const Options kQuick{.samples = 50'000};

Scan moved(Scan scan, const Vec3& by) {
  for (Vec3& p : scan.positions) p += by;
  return scan;
}

Scan scaled(Scan scan, double by) {
  for (Vec3& p : scan.positions) p *= by;
  return scan;
}

Scan cube() {
  Scan scan;
  for (int i = 0; i < 8; ++i) scan.positions.emplace_back(i & 1, (i >> 1) & 1, (i >> 2) & 1);
  scan.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return scan;
}

void expect_same_bits(const OneSided& x, const OneSided& y) {
  EXPECT_EQ(x.rms, y.rms);
  EXPECT_EQ(x.mean, y.mean);
  EXPECT_EQ(x.maximum, y.maximum);
  EXPECT_EQ(x.maximum_at, y.maximum_at);
  EXPECT_EQ(x.sample_count, y.sample_count);
}

TEST(Compare, ParallelPlanesAreTheirDistanceApart) {
  const Scan a = shapes::grid(5, 7);
  const Comparison c = *compare(a, moved(a, {0, 0, 0.25}));
  for (const OneSided& side : {c.a_to_b, c.b_to_a}) {
    EXPECT_NEAR(side.rms, 0.25, 1e-14);
    EXPECT_NEAR(side.mean, 0.25, 1e-14);
    EXPECT_NEAR(side.maximum, 0.25, 1e-15);
    EXPECT_EQ(side.sample_count, 500'000u);
  }
  EXPECT_DOUBLE_EQ(c.bbox_diagonal, std::sqrt(74.0));
  EXPECT_NEAR(c.psnr_db, 20 * std::log10(std::sqrt(74.0) / 0.25), 1e-9);
}

// The unit square and the same square moved by t in its plane: a strip of width t lies outside, at
// distances uniform in 0 .. t, so mean = t²/2 and mean square = t³/3.
TEST(Compare, SquareMovedInItsPlane) {
  const double t = 0.25;
  const Scan a = shapes::grid(1, 1);
  const Comparison c = *compare(a, moved(a, {t, 0, 0}), kQuick);
  for (const OneSided& side : {c.a_to_b, c.b_to_a}) {
    EXPECT_NEAR(side.mean, t * t / 2, 2e-5);
    EXPECT_NEAR(side.rms, std::sqrt(t * t * t / 3), 2e-4);
    EXPECT_NEAR(side.maximum, t, 1e-15);  // at the vertices
  }
}

// Moved by t along x. One face across x lies outside, t away. The other lies inside: its points are
// min(t, m) away, m the distance to the nearest side face, P(m > s) = (1 − 2 s)². The four faces
// along x stick out by up to t.
TEST(Compare, CubeMovedAlongAnAxis) {
  const double t = 0.125;
  const Comparison c = *compare(cube(), moved(cube(), {t, 0, 0}), kQuick);
  const double inside_mean = t - 2 * t * t + 4 * t * t * t / 3;
  const double inside_square = t * t - 8 * t * t * t / 3 + 2 * t * t * t * t;
  const double rms = std::sqrt((t * t + inside_square + 4 * t * t * t / 3) / 6);
  EXPECT_NEAR(c.a_to_b.rms, rms, 1e-3 * t);
  EXPECT_NEAR(c.b_to_a.rms, rms, 1e-3 * t);
  EXPECT_NEAR(c.a_to_b.mean, (t + inside_mean + 4 * t * t / 2) / 6, 1e-3 * t);
  EXPECT_NEAR(c.a_to_b.maximum, t, 1e-15);
}

TEST(Compare, ConcentricSpheres) {
  const Scan a = shapes::sphere(5);
  const double r = 1.125, h = 1 - std::cos(M_PI / 4 / 32 * 1.6);  // facets' sagitta, from above
  const Comparison c = *compare(a, scaled(a, r), kQuick);
  for (const OneSided& side : {c.a_to_b, c.b_to_a}) {
    EXPECT_LT(side.rms, r - 1 + h);
    EXPECT_GT(side.rms, r - 1 - r * h);
    EXPECT_LE(side.mean, side.rms);
    EXPECT_LE(side.rms, side.maximum);
  }
}

// The square moved by t in its plane: 1 − t of the area is nearer than any edge of the histogram,
// and of the rest, at distances uniform up to t, what lies below an edge is as the edge to t.
TEST(Compare, HistogramCountsAreaByDistance) {
  const double t = 0.25;
  const Scan a = shapes::grid(1, 1);
  const Comparison c = *compare(a, moved(a, {t, 0, 0}), kQuick);
  const double diagonal = std::sqrt(2.0);
  const std::vector<std::uint64_t>& histogram = c.a_to_b.histogram;
  ASSERT_EQ(histogram.size(), static_cast<std::size_t>(kHistogramEdges) + 1);
  std::uint64_t below = 0;
  for (int k = 0; k < kHistogramEdges; ++k) {
    below += histogram[static_cast<std::size_t>(k)];
    const double expected = 1 - t + std::min(t, histogram_edge(k) * diagonal);
    EXPECT_NEAR(static_cast<double>(below) / 50'000, expected, 1e-3) << "edge " << k;
  }
  EXPECT_EQ(below, 50'000u);
  EXPECT_EQ(histogram.back(), 0u);
  EXPECT_EQ(c.a_to_b.quantile(0.5, diagonal), diagonal * histogram_edge(0));
  const double near_all =
      c.a_to_b.quantile(0.99, diagonal);  // 1 % of the area is farther than 0.24
  EXPECT_GE(near_all, 0.24);
  EXPECT_LE(near_all, 0.24 * std::pow(10, 0.1));
}

TEST(Compare, HistogramEdgesAreTwoDecibelsApart) {
  EXPECT_DOUBLE_EQ(histogram_edge(0), 1e-7);
  EXPECT_DOUBLE_EQ(histogram_edge(kHistogramEdges - 1), 1);
  for (int k = 1; k < kHistogramEdges; ++k)
    EXPECT_NEAR(psnr_db(1, histogram_edge(k - 1)) - psnr_db(1, histogram_edge(k)), 2, 1e-9);
}

TEST(Compare, FindsASpikeAtItsVertex) {
  Scan spiked = shapes::grid(20, 20);
  const Vec3 tip(10, 10, 3);
  spiked.positions[10 * 21 + 10] = tip;
  const Scan flat = shapes::grid(20, 20);
  const Comparison c = *compare(spiked, flat, kQuick);
  EXPECT_DOUBLE_EQ(c.a_to_b.maximum, 3.0);
  EXPECT_EQ(c.a_to_b.maximum_at, tip);
  EXPECT_LT(c.b_to_a.maximum, 1.0);  // seen from the plane the spike's sides are near
  EXPECT_GT(c.a_to_b.rms, c.b_to_a.rms);
}

TEST(Compare, PlacesCountForTheMaximumAlone) {
  const Scan flat = shapes::grid(20, 20);
  Scan raised = flat;
  raised.positions[10 * 21 + 10] = Vec3(10, 10, 0.5);
  // Off the surface, where no sample is: 7 above it.
  const Vec3 place(3, 4, 7);
  const Comparison without = *compare(flat, raised, kQuick);
  Options options = kQuick;
  options.places = {Vec3(1, 1, 0), place};
  const Comparison with = *compare(flat, raised, options);
  EXPECT_DOUBLE_EQ(with.a_to_b.maximum, 7.0);
  EXPECT_EQ(with.a_to_b.maximum_at, place);
  EXPECT_LT(without.a_to_b.maximum, 0.5);
  EXPECT_EQ(with.a_to_b.rms, without.a_to_b.rms);
  EXPECT_EQ(with.a_to_b.sample_count, without.a_to_b.sample_count);
  expect_same_bits(with.b_to_a, without.b_to_a);
}

TEST(Compare, SwappingTheSurfacesSwapsTheSides) {
  const Scan a = shapes::torus(24, 16), b = shapes::torus(31, 12, 1.02, 0.38);
  const Comparison ab = *compare(a, b, kQuick), ba = *compare(b, a, kQuick);
  expect_same_bits(ab.a_to_b, ba.b_to_a);
  expect_same_bits(ab.b_to_a, ba.a_to_b);
  EXPECT_GT(std::abs(ab.bbox_diagonal - ba.bbox_diagonal), 0);  // always of the reference
}

TEST(Compare, SameBitsAtAnyThreadCountAndWithAPreparedReference) {
  const Scan a = shapes::torus(40, 30), b = shapes::torus(37, 23, 1.01, 0.41);
  Comparison by_threads[2];
  for (std::size_t threads : {1u, 2u}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    by_threads[threads - 1] = *compare(a, b, kQuick);
  }
  expect_same_bits(by_threads[0].a_to_b, by_threads[1].a_to_b);
  expect_same_bits(by_threads[0].b_to_a, by_threads[1].b_to_a);
  EXPECT_EQ(by_threads[0].psnr_db, by_threads[1].psnr_db);
  const Comparison prepared = *compare(a, *Surface::build(a), b, kQuick);
  expect_same_bits(prepared.a_to_b, by_threads[0].a_to_b);
  expect_same_bits(prepared.b_to_a, by_threads[0].b_to_a);
}

TEST(Compare, RmsHasConvergedAndSeedsAgree) {
  const Scan a = shapes::sphere(4), b = scaled(shapes::icosahedron(), 1.1);
  Options options;
  options.samples = 1'000'000;
  const Comparison fine = *compare(a, b, options);
  options.samples = 100'000;
  for (options.seed = 1; options.seed <= 3; ++options.seed) {
    const Comparison c = *compare(a, b, options);
    EXPECT_EQ(c.a_to_b.sample_count, 100'000u);
    EXPECT_NEAR(c.a_to_b.rms / fine.a_to_b.rms, 1, 2e-4);
    EXPECT_NEAR(c.b_to_a.rms / fine.b_to_a.rms, 1, 2e-4);
  }
}

TEST(Compare, EqualSurfacesHaveInfinitePsnr) {
  const Scan a = moved(shapes::torus(50, 20, 30.0, 1.0), {1000, 0.1, 7});
  const Comparison c = *compare(a, a, kQuick);
  EXPECT_EQ(c.a_to_b.rms, 0);
  EXPECT_EQ(c.b_to_a.maximum, 0);
  EXPECT_EQ(c.psnr_db, kInf);
}

TEST(Compare, TriangulationAndVertexOrderDoNotMatter) {
  const Scan a = shapes::grid(8, 8);
  Scan b = shapes::grid(2, 4);
  for (Vec3& p : b.positions) p = {4 * p[0], 2 * p[1], p[2]};
  EXPECT_LT(compare(a, b, kQuick)->a_to_b.maximum, 1e-14);
  EXPECT_LT(compare(a, b, kQuick)->b_to_a.maximum, 1e-14);
}

TEST(Compare, DegenerateFacesAndUnusedVerticesCountForNothing) {
  const Scan a = shapes::sphere(3);
  Scan dirty = a;
  dirty.positions.emplace_back(100, 0, 0);  // on no face
  dirty.positions.emplace_back(0, 500, 0);  // only on a needle
  const auto far = static_cast<std::uint32_t>(a.positions.size() + 1);
  dirty.triangles.insert(dirty.triangles.begin() + 7, {far, far, 0});
  dirty.triangles.push_back({3, 3, 3});
  const Scan b = scaled(a, 1.01);
  const Comparison clean = *compare(a, b, kQuick), c = *compare(dirty, b, kQuick);
  EXPECT_EQ(c.bbox_diagonal, clean.bbox_diagonal);
  EXPECT_NEAR(c.a_to_b.rms, clean.a_to_b.rms, 2e-5);
  EXPECT_NEAR(c.a_to_b.maximum, clean.a_to_b.maximum, 1e-5);
  EXPECT_NEAR(c.b_to_a.maximum, clean.b_to_a.maximum, 1e-5);
}

TEST(Compare, OriginsMayDiffer) {
  Scan a = shapes::sphere(4);
  a.origin = {4.5e6, -5.1e6, 300};
  Scan b = moved(scaled(shapes::sphere(4), 1.01), {0.5, 0.25, -2});
  b.origin = a.origin - Vec3(0.5, 0.25, -2);
  Scan a0 = a, b0 = scaled(shapes::sphere(4), 1.01);
  a0.origin = b0.origin = Vec3::Zero();
  const Comparison far = *compare(a, b, kQuick), near = *compare(a0, b0, kQuick);
  EXPECT_NEAR(far.a_to_b.rms, near.a_to_b.rms, 1e-13);
  EXPECT_NEAR(far.b_to_a.rms, near.b_to_a.rms, 1e-7);  // samples of b follow its rounding
  EXPECT_LT(far.b_to_a.maximum_at.norm(), 1.02);       // relative to A's origin
}

TEST(Compare, PsnrIsThePapersFormula) {
  EXPECT_DOUBLE_EQ(psnr_db(1000, 1), 60.0);
  EXPECT_DOUBLE_EQ(psnr_db(2.0, 2.0), 0.0);
  EXPECT_EQ(psnr_db(1, 0), kInf);
  Scan low = shapes::grid(4, 4), high = shapes::grid(4, 4);
  for (std::size_t i = 0; i < high.positions.size(); ++i)
    high.positions[i][2] = 0.001 * static_cast<double>(i % 5);
  const Comparison c = *compare(low, high, kQuick);
  EXPECT_EQ(c.psnr_db, 20 * std::log10(c.bbox_diagonal / std::max(c.a_to_b.rms, c.b_to_a.rms)));
}

TEST(Compare, RefusesWhatHasNoSurface) {
  const Scan good = shapes::tetrahedron();
  Scan flat = good;
  flat.triangles = {{0, 0, 1}, {2, 2, 2}};
  Scan nan = good;
  nan.positions[2][1] = std::nan("");
  Scan out_of_range = good;
  out_of_range.triangles[3][1] = 4;
  Scan huge = good;
  huge.positions[1][0] = 1e300;
  for (const Scan& bad : {Scan{}, flat, nan, out_of_range, huge}) {
    for (const auto& result : {compare(good, bad), compare(bad, good)}) {
      ASSERT_FALSE(result.has_value());
      EXPECT_EQ(result.error().code, ErrorCode::kBadInput);
    }
  }
  EXPECT_EQ(compare(good, nan).error().where, 2u);
  EXPECT_EQ(compare(good, out_of_range).error().where, 3u);
  Options few;
  few.samples = 999;
  EXPECT_EQ(compare(good, good, few).error().code, ErrorCode::kBadInput);
}

TEST(Compare, CanBeCancelledAndReportsProgress) {
  const Scan a = shapes::torus(30, 20);
  std::atomic<bool> cancel = true;
  RunContext context;
  context.cancel = &cancel;
  EXPECT_EQ(compare(a, a, kQuick, context).error().code, ErrorCode::kCancelled);
  cancel = false;
  double last = -1;
  context.progress = [&](std::string_view, double share) {
    EXPECT_GT(share, last);
    last = share;
  };
  EXPECT_TRUE(compare(a, a, kQuick, context).has_value());
  EXPECT_EQ(last, 1.0);
}

}  // namespace
}  // namespace nacre::metric
