// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <numeric>

#include "laplacian_band.h"

namespace nacre::alloc {
namespace {

/// D = variance 2^(−2R), sampled every half bit up to 20 bits.
RateDistortionCurve gaussian(double variance) {
  std::vector<Sample> samples{{kInf, 0, variance}};
  for (double bits = 0.5; bits <= 20; bits += 0.5)
    samples.push_back({std::exp2(-bits), bits, variance * std::exp2(-2 * bits)});
  return *RateDistortionCurve::fit(samples);
}

RateDistortionCurve random_curve(std::mt19937_64& engine, double noise) {
  std::vector<Sample> samples{{kInf, 0, std::exp(10 * uniform(engine))}};
  double bits = 0, distortion = samples[0].distortion;
  const std::uint64_t count = engine() % 25;
  for (std::uint64_t i = 0; i < count; ++i) {
    bits += 2 * uniform(engine);
    distortion *= 0.2 + 0.8 * uniform(engine);
    samples.push_back({std::exp2(-bits), bits, distortion * (1 + noise * uniform(engine))});
  }
  return *RateDistortionCurve::fit(samples);
}

double distortion_of(const std::vector<Band>& bands, const std::vector<double>& bits) {
  double sum = 0, vertices = 0;
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const double n = static_cast<double>(bands[i].vertex_count);
    sum += n * bands[i].gain * bands[i].curve.distortion(bits[i]);
    vertices += n;
  }
  return sum / vertices;
}

double all_bits(const std::vector<Band>& bands) {
  double sum = 0;
  for (const Band& b : bands) sum += static_cast<double>(b.vertex_count) * b.curve.max_bits();
  return sum;
}

// Reverse water-filling: E_i D_i = θ for every band with E_i σ_i² > θ, the others stay at 0 bits.
TEST(Allocate, GaussianBandsAreFilledToOneLevel) {
  const std::vector<double> variance{100, 4, 1, 0.01}, gain{40, 10, 2.6, 1};
  const std::vector<std::size_t> count{16, 48, 192, 768};
  std::vector<Band> bands;
  for (std::size_t i = 0; i < 4; ++i) bands.push_back({count[i], gain[i], gaussian(variance[i])});
  for (const double theta : {500.0, 1.0, 0.02, 0.005, 1e-4}) {
    std::vector<double> expected;
    double budget = 0, distortion = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      expected.push_back(std::max(0.0, 0.5 * std::log2(gain[i] * variance[i] / theta)));
      budget += static_cast<double>(count[i]) * expected[i];
      distortion += static_cast<double>(count[i]) * std::min(theta, gain[i] * variance[i]) / 1024;
    }
    const Allocation found = *allocate(bands, budget);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(found.bits[i], expected[i], 1e-7) << theta;
    EXPECT_NEAR(found.predicted_distortion / distortion, 1, 1e-8);
    EXPECT_NEAR(found.lambda, -2 * std::log(2.0) * theta, 1e-6 * theta);
    EXPECT_LE(found.total_bits, budget);
    for (std::size_t i = 0; i < 4; ++i) {
      if (expected[i] == 0) {
        EXPECT_EQ(found.steps[i], kInf);
      } else if (expected[i] > 0.5) {
        EXPECT_NEAR(found.steps[i], std::exp2(-found.bits[i]), 0.05 * found.steps[i]);
      }
    }
    const Allocation at_slope = allocate_at_slope(bands, found.lambda);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(at_slope.bits[i], expected[i], 1e-6);
  }
}

TEST(Allocate, HighRateStepsGoAsOneOverRootGain) {
  std::mt19937_64 engine(21);
  std::vector<Band> bands;
  for (const double gain : {1.0, 2.640625, 10.077637}) {
    const LaplacianBand band(8000, 1.0, 1.0, engine);
    bands.push_back({8000, gain, *RateDistortionCurve::fit(band.samples())});
  }
  const Allocation a = *allocate(bands, 0.7 * all_bits(bands));
  EXPECT_NEAR(a.steps[1] / a.steps[0], 0.61538, 0.02);
  EXPECT_NEAR(a.steps[2] / a.steps[0], 0.31501, 0.01);
}

TEST(Allocate, NoGridPointIsBetter) {
  std::mt19937_64 engine(22);
  for (int round = 0; round < 6; ++round) {
    std::vector<Band> bands;
    for (const std::size_t n : {100u, 400u, 1600u}) {
      const RateDistortionCurve curve =
          round < 3 ? *RateDistortionCurve::fit(
                          LaplacianBand(n, std::exp(2 * uniform(engine)), 0.1, engine).samples())
                    : random_curve(engine, 0.3);
      bands.push_back({n, 1 + 20 * uniform(engine), curve});
    }
    const double budget = (0.1 + 0.6 * uniform(engine)) * all_bits(bands);
    const Allocation found = *allocate(bands, budget);
    double best = kInf;
    const int n = 400;
    for (int i = 0; i <= n; ++i) {
      for (int k = 0; k <= n; ++k) {
        const double r0 = bands[0].curve.max_bits() * i / n, r1 = bands[1].curve.max_bits() * k / n;
        const double r2 = (budget - 100 * r0 - 400 * r1) / 1600;
        if (r2 < 0) break;
        best = std::min(best, distortion_of(bands, {r0, r1, r2}));
      }
    }
    EXPECT_LT(found.predicted_distortion, 1.0001 * best);
    EXPECT_GT(found.predicted_distortion,
              0.97 * best);  // the grid is fine enough to mean something
    EXPECT_NEAR(found.predicted_distortion / distortion_of(bands, found.bits), 1, 1e-12);
  }
}

TEST(Allocate, NeverExceedsTheBudgetAndUsesIt) {
  std::mt19937_64 engine(23);
  for (int round = 0; round < 300; ++round) {
    std::vector<Band> bands;
    const std::uint64_t count = 1 + engine() % 8;
    for (std::uint64_t i = 0; i < count; ++i)
      bands.push_back({engine() % 5000, std::exp(8 * uniform(engine) - 2),
                       random_curve(engine, round % 2 == 0 ? 0.0 : 0.5)});
    const double all = all_bits(bands);
    Allocation last;
    for (int k = 0; k <= 12; ++k) {
      const double budget = all * k / 10;
      const Result<Allocation> result = allocate(bands, budget);
      ASSERT_TRUE(result.has_value());
      ASSERT_LE(result->total_bits, budget);
      ASSERT_GE(result->total_bits, std::min(budget, all) * (1 - 1e-9));
      ASSERT_LT(result->lambda, 0);
      ASSERT_EQ(result->bits.size(), bands.size());
      ASSERT_EQ(result->steps.size(), bands.size());
      for (std::size_t i = 0; i < bands.size(); ++i) {
        ASSERT_GE(result->bits[i], bands[i].curve.min_bits());
        ASSERT_LE(result->bits[i], bands[i].curve.max_bits());
        ASSERT_GT(result->steps[i], 0);
        if (k == 0) continue;
        ASSERT_GE(result->bits[i], last.bits[i] * (1 - 1e-9));
      }
      if (k > 0) {
        ASSERT_LE(result->predicted_distortion, last.predicted_distortion * (1 + 1e-9));
      }
      last = *result;
    }
  }
}

TEST(Allocate, PiecewiseLinearCurvesFillTheLastSegment) {
  const RateDistortionCurve curve =
      *RateDistortionCurve::fit(std::vector<Sample>{{kInf, 0, 1}, {0.5, 2, 0.25}});
  const std::vector<Band> bands{{100, 1, curve}, {100, 3, curve}};
  const Allocation a = *allocate(bands, 250);  // 200 for the second band, the rest for the first
  EXPECT_DOUBLE_EQ(a.bits[1], 2);
  EXPECT_NEAR(a.bits[0], 0.5, 1e-12);
  EXPECT_LE(a.total_bits, 250);
  EXPECT_NEAR(a.lambda, -0.375, 1e-9);
}

// Σ w_i D_i from the curves against the squared error of really coding with the chosen steps, and
// their rates against the rates really spent, on a pyramid of bands like that of a normal mesh.
TEST(Allocate, PredictionIsWhatCodingMeasures) {
  std::mt19937_64 engine(24);
  const std::vector<double> gain{642.451004, 160.615435, 40.164011, 10.077637, 2.640625, 1};
  std::vector<LaplacianBand> sources;
  std::vector<Band> bands;
  for (std::size_t j = 0; j < 6; ++j) {
    const std::size_t n = 300u << (2 * j);
    sources.emplace_back(j < 5 ? n : 30000, std::pow(3.5, -static_cast<double>(j)), 0.03, engine);
    bands.push_back({static_cast<std::size_t>(sources[j].count()), gain[j],
                     *RateDistortionCurve::fit(sources[j].samples())});
  }
  double vertices = 0;
  for (const Band& b : bands) vertices += static_cast<double>(b.vertex_count);
  for (const double bits_per_vertex : {0.05, 0.2, 0.5, 1.0, 2.0, 4.0, 8.0}) {
    const Allocation a = *allocate(bands, bits_per_vertex * vertices);
    double error = 0, bits = 0;
    for (std::size_t j = 0; j < 6; ++j) {
      const Sample real = sources[j].code(a.steps[j]);
      error += sources[j].count() * gain[j] * real.distortion / vertices;
      bits += sources[j].count() * real.bits;
    }
    EXPECT_NEAR(a.predicted_distortion / error, 1, 0.03) << bits_per_vertex;
    EXPECT_NEAR(a.total_bits / bits, 1, 0.02) << bits_per_vertex;
  }
}

TEST(Allocate, RefusesTheImpossible) {
  const RateDistortionCurve coded =
      *RateDistortionCurve::fit(std::vector<Sample>{{1, 2, 1}, {0.5, 4, 0.25}});
  const std::vector<Band> bands{{10, 1, coded}};
  EXPECT_EQ(allocate(bands, 19.9).error().code, ErrorCode::kGoalUnreachable);
  EXPECT_EQ(allocate(bands, -1).error().code, ErrorCode::kGoalUnreachable);
  EXPECT_TRUE(allocate(bands, 20).has_value());
  EXPECT_EQ(allocate(bands, std::nan("")).error().code, ErrorCode::kBadInput);
  EXPECT_DOUBLE_EQ(allocate(bands, kInf)->total_bits, 40);
  for (const double gain : {0.0, -1.0, std::nan(""), kInf}) {
    const auto result = allocate(std::vector<Band>{{10, 1, coded}, {10, gain, coded}}, 100);
    ASSERT_FALSE(result.has_value());
    EXPECT_EQ(result.error().code, ErrorCode::kBadInput);
    EXPECT_EQ(result.error().where, 1u);
  }
  EXPECT_EQ(allocate({}, 0)->total_bits, 0);
  EXPECT_EQ(allocate({}, -1).error().code, ErrorCode::kGoalUnreachable);
}

}  // namespace
}  // namespace nacre::alloc
