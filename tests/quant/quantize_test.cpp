// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "quant/quant.h"

namespace nacre::quant {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

LatticePoint quantize_one(const Vec3& detail, const QuantizerOptions& options) {
  return quantize(std::vector<Vec3>{detail}, options).front();
}

double symmetric_unit(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-52 - 1;
}

TEST(Quantize, CellsEndWhereTheOptionsSay) {
  constexpr double kStep = 0.25;
  for (const double dead_zone : {0.5, 0.6, 0.75, 0.999}) {
    const QuantizerOptions options{.step = kStep, .dead_zone = dead_zone, .theta_rad = 0};
    // Lower ends of the cells of 1, 2, 3, ...; steps are powers of two, so all of this is exact.
    for (int n = 1; n < 50; ++n) {
      const double lower = n == 1 ? dead_zone : n - 0.5;
      const double at = lower * kStep;
      const double below = std::nextafter(lower, 0.0) * kStep;
      EXPECT_EQ(quantize_one({at, -at, at}, options), (LatticePoint{n, -n, n}));
      EXPECT_EQ(quantize_one({-below, below, below}, options), (LatticePoint{1 - n, n - 1, n - 1}));
    }
  }
}

TEST(Quantize, ConeRemovesTheTangentialPartInsideOnly) {
  // Large enough that rounding alone would keep the tangential part.
  constexpr double kNormal = 10000;
  for (const double degrees : {0.1, 1.0, 10.0, 45.0, 80.0}) {
    const QuantizerOptions options{.theta_rad = degrees * kDegree};
    for (int i = 0; i < 36; ++i) {
      const double azimuth = 10 * i * kDegree;
      for (const double sign : {-1.0, 1.0}) {
        const auto tilted = [&](double angle) {
          const double radius = kNormal * std::tan(angle);
          return quantize_one(
              {sign * kNormal, radius * std::cos(azimuth), radius * std::sin(azimuth)}, options);
        };
        const LatticePoint inside = tilted(options.theta_rad * (1 - 1e-9));
        EXPECT_EQ(inside, (LatticePoint{static_cast<int>(sign * kNormal), 0, 0}));
        const LatticePoint outside = tilted(options.theta_rad * (1 + 1e-9));
        EXPECT_TRUE(outside[1] != 0 || outside[2] != 0);
      }
    }
  }
}

TEST(Quantize, ConeIsTestedOnTheInput) {
  // 1° is inside for z = 100 steps but the same tangential part at z = 20 steps is not; there the
  // dead zone decides.
  const QuantizerOptions options{.theta_rad = kDegree};
  EXPECT_EQ(quantize_one({100, 1.7, 0}, options), (LatticePoint{100, 0, 0}));
  EXPECT_EQ(quantize_one({20, 1.7, 0}, options), (LatticePoint{20, 2, 0}));
  EXPECT_EQ(quantize_one({20, 0.59, 0.1}, options), (LatticePoint{20, 0, 0}));
}

TEST(Quantize, NoConeAndFullCone) {
  EXPECT_EQ(quantize_one({1e6, 1, 0}, {.theta_rad = 0}), (LatticePoint{1000000, 1, 0}));
  EXPECT_EQ(quantize_one({1, 1e6, 5}, {.theta_rad = std::numbers::pi / 2}),
            (LatticePoint{1, 0, 0}));
}

TEST(Quantize, ZeroTangentialPartStaysZero) {
  std::mt19937_64 random(41);
  for (int i = 0; i < 1000; ++i) {
    const double z = 1000 * symmetric_unit(random);
    for (const double theta : {0.0, kDegree}) {
      const LatticePoint point = quantize_one({z, 0.0, -0.0}, {.step = 0.01, .theta_rad = theta});
      ASSERT_EQ(point[1], 0);
      ASSERT_EQ(point[2], 0);
    }
  }
}

TEST(Quantize, TangentialStepIsItsOwn) {
  const QuantizerOptions options{.step = 0.5, .tangential_ratio = 4, .theta_rad = 0};
  EXPECT_EQ(quantize_one({3.0, 3.1, -8.9}, options), (LatticePoint{6, 2, -4}));
}

TEST(Quantize, ClampsWhatDoesNotFit) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const QuantizerOptions options{.step = 1e-3, .theta_rad = 0};
  EXPECT_EQ(quantize_one({1e9, -1e300, kInfinity}, options),
            (LatticePoint{kMaxComponent, -kMaxComponent, kMaxComponent}));
  EXPECT_EQ(quantize_one({-kInfinity, kMaxComponent * 1e-3, std::nan("")}, options),
            (LatticePoint{-kMaxComponent, kMaxComponent, 0}));
  EXPECT_EQ(quantize_one({1, 1, 1}, {.step = 1e-320}),
            (LatticePoint{kMaxComponent, kMaxComponent, kMaxComponent}));
}

TEST(Dequantize, ErrorIsBoundedByTheCell) {
  std::mt19937_64 random(42);
  for (const double dead_zone : {0.5, 0.6, 0.9}) {
    for (const double shrink : {0.0, 0.05, 0.25}) {
      const QuantizerOptions options{
          .step = 0.3, .tangential_ratio = 3, .dead_zone = dead_zone, .theta_rad = 0};
      std::vector<Vec3> details(2000);
      for (Vec3& d : details) {
        for (int k = 0; k < 3; ++k) d[k] = 4 * symmetric_unit(random);
      }
      const std::vector<LatticePoint> points = quantize(details, options);
      const std::vector<Vec3> decoded = dequantize(points, 0.3, 3, shrink);
      const double limit = std::max(dead_zone, 0.5 + shrink) + 1e-9;
      for (std::size_t i = 0; i < details.size(); ++i) {
        for (int k = 0; k < 3; ++k) {
          ASSERT_LE(std::abs(decoded[i][k] - details[i][k]), limit * (k == 0 ? 0.3 : 0.9));
        }
      }
    }
  }
}

TEST(Dequantize, IsTheStatedArithmetic) {
  const std::vector<LatticePoint> points = {{0, 0, 0}, {5, -3, 1}, {-kMaxComponent, 0, 2}};
  const double step = 0.1;
  const double ratio = 1.7;
  const double shrink = 0.05;
  const std::vector<Vec3> decoded = dequantize(points, step, ratio, shrink);
  EXPECT_EQ(decoded[0], Vec3::Zero());
  EXPECT_FALSE(std::signbit(decoded[0][0]));
  EXPECT_EQ(decoded[1], Vec3((5 - shrink) * step, -((3 - shrink) * (step * ratio)),
                             (1 - shrink) * (step * ratio)));
  EXPECT_EQ(decoded[2], Vec3(-((kMaxComponent - shrink) * step), 0, (2 - shrink) * (step * ratio)));
}

TEST(Dequantize, LatticePointsAreFixedPoints) {
  std::mt19937_64 random(43);
  std::vector<LatticePoint> points(5000);
  for (LatticePoint& p : points) {
    for (std::int32_t& c : p) c = static_cast<std::int32_t>(random() % 2001) - 1000;
  }
  const QuantizerOptions options{.step = 0.37, .tangential_ratio = 2, .theta_rad = 0};
  EXPECT_EQ(quantize(dequantize(points, 0.37, 2), options), points);
  EXPECT_EQ(quantize(dequantize(points, 0.37, 2, 0.3), options), points);
}

}  // namespace
}  // namespace nacre::quant
