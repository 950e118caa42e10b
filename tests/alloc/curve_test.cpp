// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "alloc/hull.h"
#include "alloc/spline.h"
#include "laplacian_band.h"

namespace nacre::alloc {
namespace {

bool on_lower_hull(const std::vector<Sample>& all, std::size_t i) {
  const Sample& p = all[i];
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Sample& a = all[k];
    if (a.bits <= p.bits && a.distortion <= p.distortion &&
        (a.bits < p.bits || a.distortion < p.distortion || k < i))
      return false;  // as good for less, or the same point again
    for (const Sample& b : all) {
      if (!(a.bits < p.bits && p.bits < b.bits)) continue;
      // On or above the chord from a to b. The test's coordinates are small integers: exact.
      if ((p.distortion - a.distortion) * (b.bits - a.bits) >=
          (b.distortion - a.distortion) * (p.bits - a.bits))
        return false;
    }
  }
  return true;
}

TEST(LowerHull, AgreesWithEveryPairOfPoints) {
  std::mt19937_64 engine(11);
  for (int round = 0; round < 400; ++round) {
    const double range = round % 2 == 0 ? 6 : 40;  // small: many ties and collinear points
    std::vector<Sample> samples(1 + engine() % 20);
    for (Sample& s : samples) {
      s = {1, std::floor(range * uniform(engine)), std::floor(range * uniform(engine))};
    }
    std::vector<std::pair<double, double>> expected, found;
    for (std::size_t i = 0; i < samples.size(); ++i)
      if (on_lower_hull(samples, i)) expected.emplace_back(samples[i].bits, samples[i].distortion);
    std::sort(expected.begin(), expected.end());
    for (const Sample& s : lower_hull(samples)) found.emplace_back(s.bits, s.distortion);
    EXPECT_EQ(found, expected);
  }
}

TEST(LowerHull, KeepsTheLargerStepOfEqualPoints) {
  const std::vector<Sample> samples{{3, 0, 1}, {kInf, 0, 1}, {7, 0, 1}, {2, 1, 0.5}};
  EXPECT_EQ(lower_hull(samples).front().step, kInf);
}

void expect_convex_decreasing(const RateDistortionCurve& curve) {
  const int n = 5000;
  const double low = curve.min_bits(), width = curve.max_bits() - low;
  double last_slope = -kInf, last = kInf;
  for (int i = 0; i <= n; ++i) {
    const double bits = low + width * i / n;
    const double d = curve.distortion(bits), slope = curve.slope(bits);
    ASSERT_LT(d, last) << bits;
    ASSERT_LE(slope, 0);
    ASSERT_GE(slope, last_slope * (1 + 1e-12)) << bits << " of " << curve.max_bits();
    last = d;
    last_slope = slope;
  }
}

TEST(Curve, FitsLaplacianBandsClosely) {
  std::mt19937_64 engine(12);
  double sum = 0, worst = 0;
  int count = 0;
  for (const std::size_t n : {2000u, 20000u}) {
    for (const double tangential : {1.0, 0.1, 0.02}) {
      const LaplacianBand band(n, 0.01, tangential, engine);
      const RateDistortionCurve curve = *RateDistortionCurve::fit(band.samples());
      EXPECT_TRUE(curve.is_spline());
      EXPECT_GE(curve.hull().size(), 20u);
      EXPECT_DOUBLE_EQ(curve.distortion(0), band.energy());
      expect_convex_decreasing(curve);
      for (const Sample& s : curve.hull()) {
        const double residual = std::abs(curve.distortion(s.bits) / s.distortion - 1);
        worst = std::max(worst, residual);
        sum += residual;
        ++count;
      }
    }
  }
  EXPECT_LT(worst, 0.02);
  EXPECT_LT(sum / count, 0.001);
}

// What the allocator relies on: asked for a rate between the samples, the step spends about that
// rate, and the distortion is about the curve's.
TEST(Curve, PredictsStepsThatWereNotMeasured) {
  std::mt19937_64 engine(13);
  for (const double tangential : {1.0, 0.02}) {
    const LaplacianBand band(20000, 3.0, tangential, engine);
    const RateDistortionCurve curve = *RateDistortionCurve::fit(band.samples());
    double rate_error = 0, distortion_error = 0;
    const int n = 200;
    for (int i = 0; i < n; ++i) {
      const double bits = 0.2 + (curve.max_bits() - 0.3) * i / n;
      const Sample real = band.code(curve.step(bits));
      rate_error += std::abs(real.bits / bits - 1) / n;
      distortion_error += std::abs(real.distortion / curve.distortion(bits) - 1) / n;
    }
    EXPECT_LT(rate_error, 0.003);
    EXPECT_LT(distortion_error, 0.008);
  }
}

TEST(Curve, IsConvexAndDecreasingWhateverTheNoise) {
  std::mt19937_64 engine(14);
  int splines = 0, rounds = 300;
  for (int round = 0; round < rounds; ++round) {
    const double noise = 0.3 * round / rounds, energy = std::exp(20 * uniform(engine) - 10);
    const double steepness = 0.3 + 2 * uniform(engine);
    std::vector<Sample> samples{{kInf, 0, energy}};
    double bits = 0.5 * uniform(engine);
    for (int i = 0; i < 24; ++i) {
      bits += 0.01 + 2 * uniform(engine) * uniform(engine);
      const double d = energy * std::exp2(-steepness * bits - std::min(bits, 0.4)) *
                       (1 + noise * (2 * uniform(engine) - 1));
      samples.push_back({std::exp2(-bits), bits, d});
    }
    const RateDistortionCurve curve = *RateDistortionCurve::fit(samples);
    splines += curve.is_spline();
    EXPECT_DOUBLE_EQ(curve.distortion(0), energy);
    expect_convex_decreasing(curve);
    for (const Sample& s : curve.hull())
      EXPECT_NEAR(curve.distortion(s.bits) / s.distortion, 1, kSplineTolerance + 1e-12);
    const auto [slope_low, slope_high] = std::pair(curve.slope(0), curve.slope(curve.max_bits()));
    for (int i = 1; i < 20; ++i) {  // the inverse of the slope
      const double slope = slope_low * std::pow(slope_high / slope_low, i / 20.0);
      const double r = curve.bits_at_slope(slope);
      const double lagrangian = curve.distortion(r) - slope * r;
      for (int k = 0; k <= 50; ++k) {
        const double other = curve.max_bits() * k / 50;
        EXPECT_LE(lagrangian, (curve.distortion(other) - slope * other) * (1 + 1e-9) + 1e-300);
      }
    }
  }
  EXPECT_GT(splines, rounds / 3);
  EXPECT_LT(splines, rounds);  // both kinds were tried
}

TEST(Curve, SlopeIsTheDerivative) {
  std::mt19937_64 engine(15);
  const LaplacianBand band(5000, 1, 0.3, engine);
  const RateDistortionCurve curve = *RateDistortionCurve::fit(band.samples());
  ASSERT_TRUE(curve.is_spline());
  for (double bits = 0.1; bits < curve.max_bits() - 0.1; bits += 0.37) {
    const double h = 1e-5;
    const double difference = (curve.distortion(bits + h) - curve.distortion(bits - h)) / (2 * h);
    EXPECT_NEAR(curve.slope(bits) / difference, 1, 1e-5);
  }
  EXPECT_EQ(curve.bits_at_slope(-kInf), curve.min_bits());
  EXPECT_EQ(curve.bits_at_slope(0), curve.max_bits());
}

TEST(Curve, StepsFollowTheSamples) {
  std::mt19937_64 engine(16);
  const LaplacianBand band(3000, 0.5, 0.2, engine);
  const std::vector<Sample> samples = band.samples();
  const RateDistortionCurve curve = *RateDistortionCurve::fit(samples);
  double largest = 0;
  for (const Sample& s : curve.hull()) {
    if (s.step < kInf) {
      EXPECT_NEAR(curve.step(s.bits) / s.step, 1, 1e-9);
      largest = std::max(largest, s.step);
    }
  }
  EXPECT_EQ(curve.step(0), kInf);
  EXPECT_EQ(curve.step(curve.max_bits() + 5), curve.step(curve.max_bits()));
  double last = kInf;
  for (double bits = 1e-9; bits < curve.max_bits(); bits *= 1.05) {
    const double step = curve.step(bits);
    ASSERT_GT(step, 0);
    ASSERT_LE(step, last * (1 + 1e-12));
    ASSERT_LE(step, 16.0001 * largest);
    last = step;
  }
}

TEST(Curve, OneOrTwoSamples) {
  const RateDistortionCurve one = *RateDistortionCurve::fit(std::vector<Sample>{{0.5, 3, 0.1}});
  EXPECT_EQ(one.min_bits(), 3);
  EXPECT_EQ(one.max_bits(), 3);
  EXPECT_EQ(one.distortion(0), 0.1);
  EXPECT_EQ(one.distortion(9), 0.1);
  EXPECT_EQ(one.slope(3), 0);
  EXPECT_EQ(one.bits_at_slope(-1), 3);
  EXPECT_EQ(one.step(3), 0.5);

  const RateDistortionCurve two =
      *RateDistortionCurve::fit(std::vector<Sample>{{kInf, 0, 1}, {0.5, 2, 0.25}});
  EXPECT_FALSE(two.is_spline());
  EXPECT_DOUBLE_EQ(two.distortion(1), 0.625);
  EXPECT_DOUBLE_EQ(two.slope(1), -0.375);
  EXPECT_EQ(two.bits_at_slope(-0.376), 0);
  EXPECT_EQ(two.bits_at_slope(-0.374), 2);
  EXPECT_EQ(two.step(0), kInf);
  EXPECT_DOUBLE_EQ(two.step(2), 0.5);
  EXPECT_GE(two.step(1), 0.5);
}

TEST(Curve, BandWithoutEnergy) {
  const std::vector<Sample> samples{{kInf, 0, 0}, {0.1, 0.02, 0}, {0.01, 0.02, 0}};
  const RateDistortionCurve curve = *RateDistortionCurve::fit(samples);
  EXPECT_EQ(curve.max_bits(), 0);
  EXPECT_EQ(curve.distortion(0), 0);
  EXPECT_EQ(curve.slope(0), 0);
  EXPECT_EQ(curve.step(0), kInf);
}

TEST(Curve, LosslessSampleIsReached) {
  const std::vector<Sample> samples{{kInf, 0, 1}, {0.5, 1, 0.3}, {0.2, 2, 0.1}, {0.1, 4, 0}};
  const RateDistortionCurve curve = *RateDistortionCurve::fit(samples);
  EXPECT_FALSE(curve.is_spline());
  EXPECT_EQ(curve.distortion(4), 0);
  EXPECT_DOUBLE_EQ(curve.distortion(3), 0.05);
  expect_convex_decreasing(curve);
}

TEST(Curve, RefusesHostileSamples) {
  const double nan = std::nan("");
  EXPECT_EQ(RateDistortionCurve::fit({}).error().code, ErrorCode::kBadInput);
  for (const Sample& bad : std::vector<Sample>{{nan, 1, 1},
                                               {1, nan, 1},
                                               {1, 1, nan},
                                               {0, 1, 1},
                                               {-1, 1, 1},
                                               {1, -1, 1},
                                               {1, 1, -1},
                                               {1, kInf, 1},
                                               {1, 1, kInf}}) {
    const auto result = RateDistortionCurve::fit(std::vector<Sample>{{kInf, 0, 1}, bad});
    ASSERT_FALSE(result.has_value());
    EXPECT_EQ(result.error().code, ErrorCode::kBadInput);
    EXPECT_EQ(result.error().where, 1u);
  }
}

TEST(Curve, ExtremeScalesStayFinite) {
  for (const double scale : {1e-150, 1e-30, 1e30, 1e150}) {
    std::vector<Sample> samples{{kInf, 0, scale}};
    for (int i = 1; i < 30; ++i) samples.push_back({1.0 / i, i * 1.0, scale * std::exp2(-2.0 * i)});
    samples.push_back({0.01, 29 + 1e-13, scale * std::exp2(-58.5)});  // knots that nearly coincide
    const RateDistortionCurve curve = *RateDistortionCurve::fit(samples);
    for (double bits = 0; bits < 31; bits += 0.1) {
      ASSERT_TRUE(std::isfinite(curve.distortion(bits)));
      ASSERT_TRUE(std::isfinite(curve.slope(bits)));
    }
  }
}

TEST(SmoothingSpline, InterpolatesAsSmoothingVanishesAndIsALineAsItGrows) {
  const std::vector<double> x{0, 1, 1.5, 4, 5}, y{1, 3, 2, 2, 7}, one(5, 1.0), none(5, 0.0);
  const CubicSpline exact = smoothing_spline(x, y, one, std::vector<double>(5, 1e-12), none);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(exact.at(x[i]).value, y[i], 1e-9);
  for (std::size_t i = 1; i < 4; ++i) {  // twice continuously differentiable
    const CubicSpline::Jet l = exact.at(x[i] - 1e-9), r = exact.at(x[i] + 1e-9);
    EXPECT_NEAR(l.first, r.first, 1e-6);
    EXPECT_NEAR(l.second, r.second, 1e-6);
  }
  const CubicSpline line = smoothing_spline(x, y, one, std::vector<double>(5, 1e12), none);
  // Least squares: mean x = 2.3, mean y = 3; Sxy = 14.5, Sxx = 17.8.
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_NEAR(line.at(x[i]).value, 3 + 14.5 / 17.8 * (x[i] - 2.3), 1e-6);
}

TEST(SmoothingSpline, IsTheMinimum) {
  std::mt19937_64 engine(17);
  const std::size_t n = 8;
  std::vector<double> x{0}, y{0}, inverse_weight{0}, roughness{1}, target{0};
  for (std::size_t i = 1; i < n; ++i) {
    x.push_back(x.back() + 0.1 + uniform(engine));
    y.push_back(uniform(engine));
    inverse_weight.push_back(0.5 + uniform(engine));
    roughness.push_back(0.01 * (0.5 + uniform(engine)));
    target.push_back(uniform(engine) - 0.5);
  }
  const std::vector<double> small(n, 1e-13);
  const auto cost = [&](const CubicSpline& f) {
    double sum = 0;
    for (std::size_t i = 1; i < n; ++i) {
      sum += (y[i] - f.values[i]) * (y[i] - f.values[i]) / inverse_weight[i];
      if (i + 1 < n) sum += roughness[i] * std::pow(f.curvatures[i] - target[i], 2);
    }
    return sum;
  };
  const CubicSpline best = smoothing_spline(x, y, inverse_weight, roughness, target);
  EXPECT_NEAR(best.values[0], y[0], 1e-12);
  for (int i = 0; i < 200; ++i) {  // against interpolating splines through values nearby
    std::vector<double> values = best.values;
    for (std::size_t k = 1; k < n; ++k) values[k] += 0.02 * (uniform(engine) - 0.5);
    const CubicSpline other =
        smoothing_spline(x, values, std::vector<double>(n, 0.0), small, small);
    EXPECT_GT(cost(other), cost(best));
  }
}

TEST(MonotoneCubic, KeepsOrderAndPassesThroughItsPoints) {
  const MonotoneCubic f = MonotoneCubic::through({0, 1, 1.1, 3, 10}, {5, 4.9, 1, 0.9, -7});
  for (std::size_t i = 0; i < f.x.size(); ++i) EXPECT_DOUBLE_EQ(f.at(f.x[i]), f.y[i]);
  for (double t = -2; t < 12; t += 0.01) EXPECT_LE(f.at(t + 0.01), f.at(t) + 1e-12);
}

}  // namespace
}  // namespace nacre::alloc
