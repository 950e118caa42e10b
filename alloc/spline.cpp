// SPDX-License-Identifier: GPL-3.0-or-later
#include "alloc/spline.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace nacre::alloc {
namespace {

const double kLn2 = std::log(2.0);

/// Index i with x_i <= t < x_{i+1}, clamped to the intervals that exist.
std::size_t interval_of(std::span<const double> x, double t) {
  const auto after = std::upper_bound(x.begin(), x.end(), t) - x.begin();
  return static_cast<std::size_t>(
      std::clamp<std::ptrdiff_t>(after - 1, 0, static_cast<std::ptrdiff_t>(x.size()) - 2));
}

/// Solves a symmetric positive definite system with five diagonals, given as rows
/// (main, first, second superdiagonal), by LDLᵀ. Returns the solution.
std::vector<double> solve_pentadiagonal(std::vector<std::array<double, 3>> a,
                                        std::vector<double> b) {
  const std::size_t n = b.size();
  for (std::size_t i = 0; i < n; ++i) {  // a[i] becomes (d_i, l_{i+1,i}, l_{i+2,i})
    const auto [d, first, second] = a[i];
    const double l1 = first / d, l2 = second / d;
    if (i + 1 < n) {
      a[i + 1][0] -= l1 * first;
      a[i + 1][1] -= l1 * second;
      b[i + 1] -= l1 * b[i];
    }
    if (i + 2 < n) {
      a[i + 2][0] -= l2 * second;
      b[i + 2] -= l2 * b[i];
    }
    a[i] = {d, l1, l2};
  }
  for (std::size_t i = n; i-- > 0;) {
    b[i] /= a[i][0];
    if (i + 1 < n) b[i] -= a[i][1] * b[i + 1];
    if (i + 2 < n) b[i] -= a[i][2] * b[i + 2];
  }
  return b;
}

}  // namespace

CubicSpline::Jet CubicSpline::at(double x) const {
  x = std::clamp(x, knots.front(), knots.back());
  const std::size_t i = interval_of(knots, x);
  const double h = knots[i + 1] - knots[i], p = x - knots[i], q = knots[i + 1] - x;
  const double c0 = curvatures[i], c1 = curvatures[i + 1];
  const double chord = (values[i + 1] - values[i]) / h;
  const double bend = (1 + p / h) * c1 + (1 + q / h) * c0;
  return {(p * values[i + 1] + q * values[i]) / h - p * q * bend / 6,
          chord + ((p - q) * bend + p * q * (c0 - c1) / h) / 6, (p * c1 + q * c0) / h};
}

CubicSpline smoothing_spline(std::span<const double> x, std::span<const double> y,
                             std::span<const double> inverse_weight,
                             std::span<const double> roughness, std::span<const double> target) {
  const std::size_t n = x.size(), m = n - 2;
  assert(n >= 2);
  CubicSpline f{{x.begin(), x.end()}, {y.begin(), y.end()}, std::vector<double>(n, 0.0)};
  if (m == 0) return f;
  std::vector<double> h(n - 1);
  for (std::size_t i = 0; i + 1 < n; ++i) h[i] = x[i + 1] - x[i];

  // Rows i = 0 .. m−1 belong to the inner knots i + 1. Continuity of f' is Qᵀ g = R c with g the
  // values, c the curvatures; the minimum is at c = t + P⁻¹ R μ, g = y − W⁻¹ Q μ, P the roughness,
  // t the target, so (Qᵀ W⁻¹ Q + R P⁻¹ R) μ = Qᵀ y − R t.
  std::vector<std::array<double, 3>> q(m), r(m), system(m);
  std::vector<double> right(m);
  for (std::size_t i = 0; i < m; ++i) {
    q[i] = {1 / h[i], -1 / h[i] - 1 / h[i + 1], 1 / h[i + 1]};
    r[i] = {i > 0 ? h[i] / 6 : 0.0, (h[i] + h[i + 1]) / 3, i + 1 < m ? h[i + 1] / 6 : 0.0};
    right[i] = (y[i + 2] - y[i + 1]) / h[i + 1] - (y[i + 1] - y[i]) / h[i];
  }
  for (std::size_t i = 0; i < m; ++i) {
    for (std::size_t k = 0; k < 3 && i + k < m; ++k) {
      double sum = 0;
      for (std::size_t j = k; j < 3; ++j) {  // column i + j of Qᵀ; column i + j − 1 of R
        sum += q[i][j] * inverse_weight[i + j] * q[i + k][j - k];
        if (i + j >= 1 && i + j - 1 < m) sum += r[i][j] * r[i + k][j - k] / roughness[i + j];
      }
      system[i][k] = sum;
    }
    for (std::size_t j = 0; j < 3; ++j)
      if (i + j >= 1 && i + j - 1 < m) right[i] -= r[i][j] * target[i + j];
  }
  const std::vector<double> mu = solve_pentadiagonal(std::move(system), std::move(right));
  for (std::size_t i = 0; i < m; ++i) {
    f.curvatures[i + 1] = target[i + 1];
    for (std::size_t j = 0; j < 3; ++j) {
      f.values[i + j] -= inverse_weight[i + j] * q[i][j] * mu[i];
      if (i + j >= 1 && i + j - 1 < m)
        f.curvatures[i + 1] += r[i][j] * mu[i + j - 1] / roughness[i + 1];
    }
  }
  return f;
}

bool is_convex_decreasing(const CubicSpline& f, std::vector<std::size_t>* failing) {
  // D = 2^f: D' = ln 2 f' D and D'' = ln 2 (f'' + ln 2 f'²) D. The share of f'² that is asked for
  // beyond zero covers what the bracket can lose between two points of the grid.
  constexpr int kPointsPerInterval = 16;
  constexpr double kMargin = 0.02;
  bool all = true;
  for (std::size_t i = 0; i + 1 < f.knots.size(); ++i) {
    bool good = true;
    for (int k = 0; k <= kPointsPerInterval; ++k) {
      const double t = static_cast<double>(k) / kPointsPerInterval;
      const CubicSpline::Jet jet = f.at(f.knots[i] + t * (f.knots[i + 1] - f.knots[i]));
      good = good && jet.first < 0 && jet.second + (1 - kMargin) * kLn2 * jet.first * jet.first > 0;
    }
    if (!good && failing != nullptr) failing->push_back(i);
    all = all && good;
  }
  return all;
}

std::optional<CubicSpline> convex_log_spline(std::span<const double> x, std::span<const double> y,
                                             double tolerance) {
  // A curvature c at a knot bends the spline by about c h² between neighbours h apart. Weighing c
  // by h² makes smoothing a matter of the points alone, whether they are 0.001 or 2 bits apart.
  constexpr double kLeastRoughness = 1e-4, kGrowth = 2;
  // Nearly collinear hull points need f'' close to −ln 2 f'², where D is a straight line.
  constexpr double kStraightest = 0.9;
  constexpr int kMaxRounds = 80;
  const std::size_t n = x.size();
  std::vector<double> inverse_weight(n, 1.0), roughness(n, 1.0), target(n, 0.0);
  inverse_weight[0] = 0;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double h2 = (x[i] - x[i - 1]) * (x[i + 1] - x[i]);
    roughness[i] = kLeastRoughness * h2 * h2;
  }
  for (int round = 0; round < kMaxRounds; ++round) {
    CubicSpline f = smoothing_spline(x, y, inverse_weight, roughness, target);
    for (std::size_t i = 0; i < n; ++i)
      if (!(std::abs(f.values[i] - y[i]) <= tolerance)) return std::nullopt;
    std::vector<std::size_t> failing;
    if (is_convex_decreasing(f, &failing)) return f;
    for (const std::size_t i : failing) {
      for (const std::size_t knot : {i, i + 1}) {
        const CubicSpline::Jet jet = f.at(x[knot]);
        const double straight = -kStraightest * kLn2 * jet.first * jet.first;
        target[knot] = jet.first < 0 ? std::clamp(jet.second, straight, 0.0) : 0.0;
        roughness[knot] *= kGrowth;
      }
    }
  }
  return std::nullopt;
}

MonotoneCubic MonotoneCubic::through(std::vector<double> x, std::vector<double> y) {
  const std::size_t n = x.size();
  MonotoneCubic f{std::move(x), std::move(y), std::vector<double>(n, 0.0)};
  if (n < 2) return f;
  const auto chord = [&](std::size_t i) { return (f.y[i + 1] - f.y[i]) / (f.x[i + 1] - f.x[i]); };
  // Ends: the parabola through three points, kept between flat and three times the chord.
  const auto end = [](double near, double far, double h_near, double h_far) {
    const double t = ((2 * h_near + h_far) * near - h_near * far) / (h_near + h_far);
    return near > 0 ? std::clamp(t, 0.0, 3 * near) : std::clamp(t, 3 * near, 0.0);
  };
  f.tangents.front() = f.tangents.back() = chord(0);
  if (n > 2) {
    f.tangents.front() = end(chord(0), chord(1), f.x[1] - f.x[0], f.x[2] - f.x[1]);
    f.tangents.back() =
        end(chord(n - 2), chord(n - 3), f.x[n - 1] - f.x[n - 2], f.x[n - 2] - f.x[n - 3]);
  }
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double l = chord(i - 1), r = chord(i);
    if (!(l * r > 0)) continue;  // a flat or turning place stays flat
    const double hl = f.x[i] - f.x[i - 1], hr = f.x[i + 1] - f.x[i];
    const double wl = 2 * hr + hl, wr = hr + 2 * hl;
    f.tangents[i] = (wl + wr) / (wl / l + wr / r);  // weighted harmonic mean
  }
  return f;
}

double MonotoneCubic::at(double t) const {
  if (t <= x.front()) return y.front() + (t - x.front()) * tangents.front();
  if (t >= x.back()) return y.back() + (t - x.back()) * tangents.back();
  const std::size_t i = interval_of(x, t);
  const double h = x[i + 1] - x[i], s = (t - x[i]) / h, u = 1 - s;
  return u * u * ((1 + 2 * s) * y[i] + s * h * tangents[i]) +
         s * s * ((1 + 2 * u) * y[i + 1] - u * h * tangents[i + 1]);
}

}  // namespace nacre::alloc
