// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/rate_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

namespace nacre::bench {
namespace {

RatePoint at(double bytes, double psnr) {
  RatePoint p;
  p.bytes = bytes;
  p.psnr_db = psnr;
  return p;
}

TEST(Rising, KeepsWhatPays) {
  const auto curve = rising({at(400, 50), at(100, 40), at(200, 39), at(200, 45), at(300, 45)});
  ASSERT_EQ(curve.size(), 3u);
  EXPECT_EQ(curve[0].bytes, 100);
  EXPECT_EQ(curve[1].bytes, 200);
  EXPECT_EQ(curve[1].psnr_db, 45);
  EXPECT_EQ(curve[2].bytes, 400);
}

TEST(UpperHull, IsConcaveInTheLogarithmAndAboveAllPoints) {
  std::vector<RatePoint> points;
  std::uint64_t state = 5;
  for (int i = 0; i < 200; ++i) {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    const double x = static_cast<double>(state >> 40) * 0x1p-24;
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    const double below = static_cast<double>(state >> 40) * 0x1p-24;
    points.push_back(at(1000 * std::exp2(6 * x), 50 + 30 * std::sqrt(x) - 8 * below));
  }
  const auto hull = upper_hull(points);
  ASSERT_GE(hull.size(), 3u);
  for (std::size_t i = 1; i + 1 < hull.size(); ++i) {
    const auto slope = [&](std::size_t k) {
      return (hull[k + 1].psnr_db - hull[k].psnr_db) / std::log(hull[k + 1].bytes / hull[k].bytes);
    };
    EXPECT_LT(slope(i), slope(i - 1));
  }
  for (const RatePoint& p : points)
    EXPECT_GE(psnr_at(hull, p.bytes).value_or(1000), p.psnr_db - 1e-9);
}

TEST(Filled, AddsPointsOnTheChords) {
  const std::vector<RatePoint> curve = {at(1000, 60), at(4000, 70), at(4100, 71)};
  const auto dense = filled(curve);
  for (std::size_t i = 0; i + 1 < dense.size(); ++i) {
    EXPECT_LE(dense[i + 1].bytes, 1.1001 * dense[i].bytes);
    EXPECT_NEAR(dense[i].psnr_db, *psnr_at(curve, dense[i].bytes), 1e-9);
  }
  EXPECT_EQ(dense.front().bytes, 1000);
  EXPECT_EQ(dense.back().psnr_db, 71);
}

TEST(PsnrAt, IsStraightInTheLogarithm) {
  const std::vector<RatePoint> curve = {at(1000, 60), at(4000, 70)};
  EXPECT_NEAR(*psnr_at(curve, 2000), 65, 1e-12);
  EXPECT_FALSE(psnr_at(curve, 999).has_value());
  EXPECT_FALSE(psnr_at(curve, 4001).has_value());
}

TEST(Pchip, PassesThroughItsPointsWithTheStatedSlopes) {
  const Pchip p({0, 1, 3, 4, 6}, {0, 1, 2, 5, 6});
  for (const double x : {0.0, 1.0, 3.0, 4.0, 6.0})
    EXPECT_NEAR(p(x), (x == 0 ? 0 : x == 1 ? 1 : x == 3 ? 2 : x == 4 ? 5 : 6), 1e-12);
  // Interior slopes by the weighted harmonic mean, written out.
  const double d1 = (2 * 2.0 + 1 + 2 + 2 * 1.0) / ((2 * 2.0 + 1) / 1.0 + (2 + 2 * 1.0) / 0.5);
  const double h = 1e-6;
  EXPECT_NEAR((p(1 + h) - p(1 - h)) / (2 * h), d1, 1e-5);
}

TEST(Pchip, IsMonotoneWhereTheDataAreAndIntegratesItself) {
  const std::vector<double> x = {0, 1, 1.5, 4, 4.1, 9}, y = {0, 0.1, 5, 5.2, 9, 9.5};
  const Pchip p(x, y);
  double previous = -1, sum = 0;
  constexpr int kSteps = 90000;
  for (int i = 0; i <= kSteps; ++i) {
    const double value = p(9.0 * i / kSteps);
    ASSERT_GE(value, previous);
    previous = value;
    sum += value * (i == 0 || i == kSteps ? 0.5 : 1) * 9.0 / kSteps;
  }
  EXPECT_NEAR(p.integral(0, 9), sum, 1e-6);
  EXPECT_NEAR(p.integral(0.3, 4.05) + p.integral(4.05, 8), p.integral(0.3, 8), 1e-12);
}

TEST(BdRate, OfAConstantFactorIsThatFactor) {
  std::vector<RatePoint> reference, tested;
  for (double bytes = 1000; bytes < 70000; bytes *= 2) {
    const double psnr =
        60 + 4 * std::log2(bytes / 1000) - 0.1 * std::log2(bytes) * std::log2(bytes);
    reference.push_back(at(bytes, psnr));
    tested.push_back(at(0.4 * bytes, psnr));
  }
  const auto rate = bd_rate(reference, tested, 2000, 32000);
  ASSERT_TRUE(rate.has_value());
  EXPECT_NEAR(rate->percent, -60, 1e-9);
  EXPECT_NEAR(rate->bytes_from, 2000, 1e-6);
  EXPECT_NEAR(rate->bytes_to, 32000, 1e-5);
  const auto back = bd_rate(tested, reference, 1000, 20000);
  EXPECT_NEAR(back->percent, 150, 1e-9);
}

TEST(BdRate, StaysWhereBothCurvesAre) {
  const std::vector<RatePoint> reference = {at(1000, 50), at(8000, 65), at(64000, 80)};
  const std::vector<RatePoint> tested = {at(1000, 60), at(8000, 75), at(64000, 90)};
  const auto rate = bd_rate(reference, tested, 2000, 32000);
  ASSERT_TRUE(rate.has_value());
  EXPECT_NEAR(rate->psnr_from, 60, 1e-9);  // the tested curve's first, not the reference's 55
  EXPECT_NEAR(rate->psnr_to, 75, 1e-9);
  EXPECT_NEAR(rate->percent, 100 * (std::exp2(-2) - 1), 1e-6);  // 10 dB are two doublings
  EXPECT_FALSE(bd_rate(reference, std::vector<RatePoint>{at(1, 90), at(2, 95)}, 2000, 32000));
}

}  // namespace
}  // namespace nacre::bench
