// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace nacre::alloc {

/// Natural cubic spline: values and second derivatives at increasing knots.
struct CubicSpline {
  std::vector<double> knots, values, curvatures;

  struct Jet {
    double value, first, second;
  };
  /// Value and derivatives at x, which is clamped to the knots' range.
  [[nodiscard]] Jet at(double x) const;
};

/// Minimises Σ (y_i − f(x_i))² / inverse_weight_i + Σ roughness_i (f''(x_i) − target_i)² over
/// natural cubic splines.
///
/// Reinsch's spline has ∫ f''² instead of the last sum. With the integral taken knot by knot each
/// knot can have a roughness and a target of its own, and the system keeps its five diagonals.
///
/// Shapes   x strictly increasing, at least 2; inverse_weight >= 0 (0: interpolated) one per point;
///          roughness > 0 and target one per point, those of the ends without effect.
/// Source   [Reinsch1967] eqs. (10)-(13); [deBoor1978] ch. XIV.
CubicSpline smoothing_spline(std::span<const double> x, std::span<const double> y,
                             std::span<const double> inverse_weight,
                             std::span<const double> roughness, std::span<const double> target);

/// The least smoothed spline f through log2 D whose 2^f is convex and decreasing and passes through
/// the first point; nothing if it would have to leave some point by more than `tolerance` in y.
///
/// Smoothing starts near interpolation and is raised only at the knots beside an interval that
/// fails, because noise at one end of a curve is no reason to smooth the other.
std::optional<CubicSpline> convex_log_spline(std::span<const double> x, std::span<const double> y,
                                             double tolerance);

/// True if 2^f is decreasing and convex on each of the intervals; `failing` lists those where not.
bool is_convex_decreasing(const CubicSpline& f, std::vector<std::size_t>* failing = nullptr);

/// Monotone piecewise cubic interpolation; data must be strictly increasing in x and monotone in y.
/// Continues linearly on both sides. Source: [FritschButland1984].
struct MonotoneCubic {
  std::vector<double> x, y, tangents;

  static MonotoneCubic through(std::vector<double> x, std::vector<double> y);
  [[nodiscard]] double at(double t) const;
};

}  // namespace nacre::alloc
