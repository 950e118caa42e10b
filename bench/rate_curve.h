// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "metric/metric.h"

/// Rate-distortion curves: points as measured, hulls, and the Bjontegaard difference of two.
namespace nacre::bench {

/// One file: its size, and its distance from the raw scan.
struct RatePoint {
  double bytes = 0;
  double psnr_db = 0;
  double psnr_of_maximum_db = 0;
  double rms_a_to_b = 0, rms_b_to_a = 0, maximum_a_to_b = 0, maximum_b_to_a = 0;
};

[[nodiscard]] RatePoint rate_point(std::size_t bytes, const metric::Comparison& distance);

/// The points by size, without those that have no more dB than a smaller one.
[[nodiscard]] std::vector<RatePoint> rising(std::vector<RatePoint> points);

/// The upper hull of the points over the logarithm of their size: what a user gets who picks the
/// best setting for each size.
[[nodiscard]] std::vector<RatePoint> upper_hull(std::vector<RatePoint> points);

/// Points of straight lines in log(bytes) between the points by size, at most a tenth apart.
[[nodiscard]] std::vector<RatePoint> filled(std::span<const RatePoint> curve);

/// dB at a size on the straight lines in log(bytes) between points by size; nothing outside.
[[nodiscard]] std::optional<double> psnr_at(std::span<const RatePoint> curve, double bytes);

/// Monotone piecewise cubic through (x, y), x rising: Fritsch and Carlson's derivatives as pchip in
/// MATLAB has them.
class Pchip {
 public:
  /// At least two points.
  Pchip(std::vector<double> x, std::vector<double> y);
  [[nodiscard]] double operator()(double x) const;              ///< x inside; straight on outside
  [[nodiscard]] double integral(double from, double to) const;  ///< inside

 private:
  [[nodiscard]] std::size_t piece(double x) const;
  std::vector<double> x_, y_, slope_;
};

struct BdRate {
  double percent = 0;                   ///< bytes more (> 0) or less than the reference at equal dB
  double psnr_from = 0, psnr_to = 0;    ///< over which dB
  double bytes_from = 0, bytes_to = 0;  ///< of the reference at these
};

/// Mean over dB of the difference in log(bytes), each curve by pchip of log(bytes) over dB; over
/// the dB that the reference has between two sizes, as far as both curves go. Nothing if they share
/// less than half a dB. Source [Bjontegaard2001], with pchip for its cubic.
[[nodiscard]] std::optional<BdRate> bd_rate(std::span<const RatePoint> reference,
                                            std::span<const RatePoint> tested, double bytes_from,
                                            double bytes_to);

}  // namespace nacre::bench
