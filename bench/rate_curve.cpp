// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/rate_curve.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "bench/support.h"

namespace nacre::bench {
namespace {

bool is_smaller(const RatePoint& a, const RatePoint& b) {
  return a.bytes != b.bytes ? a.bytes < b.bytes : a.psnr_db > b.psnr_db;
}

/// log(bytes) over dB.
Pchip rate_over_psnr(std::span<const RatePoint> curve) {
  std::vector<double> psnr, rate;
  for (const RatePoint& p : curve) {
    psnr.push_back(p.psnr_db);
    rate.push_back(std::log(p.bytes));
  }
  return {std::move(psnr), std::move(rate)};
}

/// pchip's derivative at the first of three points.
double end_slope(double h0, double h1, double d0, double d1) {
  const double slope = ((2 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
  if (slope * d0 <= 0) return 0;
  if (d0 * d1 < 0 && std::abs(slope) > 3 * std::abs(d0)) return 3 * d0;
  return slope;
}

}  // namespace

RatePoint rate_point(std::size_t bytes, const metric::Comparison& d) {
  return {static_cast<double>(bytes),
          d.psnr_db,
          psnr_of_maximum_db(d),
          d.a_to_b.rms,
          d.b_to_a.rms,
          d.a_to_b.maximum,
          d.b_to_a.maximum};
}

std::vector<RatePoint> rising(std::vector<RatePoint> points) {
  std::sort(points.begin(), points.end(), is_smaller);
  std::vector<RatePoint> out;
  for (const RatePoint& p : points)
    if (out.empty() || (p.bytes > out.back().bytes && p.psnr_db > out.back().psnr_db))
      out.push_back(p);
  return out;
}

std::vector<RatePoint> upper_hull(std::vector<RatePoint> points) {
  std::vector<RatePoint> hull;
  for (const RatePoint& p : rising(std::move(points))) {
    const auto is_below = [&](const RatePoint& a, const RatePoint& b) {
      const double t =
          (std::log(b.bytes) - std::log(a.bytes)) / (std::log(p.bytes) - std::log(a.bytes));
      return b.psnr_db <= a.psnr_db + t * (p.psnr_db - a.psnr_db);
    };
    while (hull.size() >= 2 && is_below(hull[hull.size() - 2], hull.back())) hull.pop_back();
    hull.push_back(p);
  }
  return hull;
}

std::vector<RatePoint> filled(std::span<const RatePoint> curve) {
  std::vector<RatePoint> out;
  for (std::size_t i = 0; i + 1 < curve.size(); ++i) {
    const double ratio = curve[i + 1].bytes / curve[i].bytes;
    const int count = std::max(1, static_cast<int>(std::ceil(std::log(ratio) / std::log(1.1))));
    for (int k = 0; k < count; ++k) {
      RatePoint p = k == 0 ? curve[i] : RatePoint{};
      p.bytes = curve[i].bytes * std::pow(ratio, static_cast<double>(k) / count);
      p.psnr_db = curve[i].psnr_db + (curve[i + 1].psnr_db - curve[i].psnr_db) * k / count;
      out.push_back(p);
    }
  }
  if (!curve.empty()) out.push_back(curve.back());
  return out;
}

std::optional<double> psnr_at(std::span<const RatePoint> curve, double bytes) {
  for (std::size_t i = 0; i + 1 < curve.size(); ++i) {
    const RatePoint &a = curve[i], &b = curve[i + 1];
    if (bytes < a.bytes || bytes > b.bytes) continue;
    const double t = std::log(bytes / a.bytes) / std::log(b.bytes / a.bytes);
    return a.psnr_db + t * (b.psnr_db - a.psnr_db);
  }
  return std::nullopt;
}

Pchip::Pchip(std::vector<double> x, std::vector<double> y)
    : x_(std::move(x)), y_(std::move(y)), slope_(x_.size(), 0) {
  assert(x_.size() >= 2 && x_.size() == y_.size());
  const std::size_t n = x_.size();
  std::vector<double> h, d;
  for (std::size_t i = 0; i + 1 < n; ++i) {
    h.push_back(x_[i + 1] - x_[i]);
    d.push_back((y_[i + 1] - y_[i]) / h[i]);
  }
  if (n == 2) {
    slope_.assign(2, d[0]);
    return;
  }
  for (std::size_t i = 1; i + 1 < n; ++i) {
    if (d[i - 1] * d[i] <= 0) continue;
    const double w1 = 2 * h[i] + h[i - 1], w2 = h[i] + 2 * h[i - 1];
    slope_[i] = (w1 + w2) / (w1 / d[i - 1] + w2 / d[i]);
  }
  slope_.front() = end_slope(h[0], h[1], d[0], d[1]);
  slope_.back() = end_slope(h[n - 2], h[n - 3], d[n - 2], d[n - 3]);
}

std::size_t Pchip::piece(double x) const {
  const auto after = std::upper_bound(x_.begin() + 1, x_.end() - 1, x);
  return static_cast<std::size_t>(after - x_.begin()) - 1;
}

double Pchip::operator()(double x) const {
  if (x < x_.front()) return y_.front() + slope_.front() * (x - x_.front());
  if (x > x_.back()) return y_.back() + slope_.back() * (x - x_.back());
  const std::size_t i = piece(x);
  const double h = x_[i + 1] - x_[i], t = (x - x_[i]) / h;
  const double t2 = t * t, t3 = t2 * t;
  return (2 * t3 - 3 * t2 + 1) * y_[i] + (t3 - 2 * t2 + t) * h * slope_[i] +
         (3 * t2 - 2 * t3) * y_[i + 1] + (t3 - t2) * h * slope_[i + 1];
}

double Pchip::integral(double from, double to) const {
  double sum = 0;
  for (std::size_t i = piece(from); i <= piece(to); ++i) {
    const double a = std::max(from, x_[i]), b = std::min(to, x_[i + 1]);
    // Simpson's rule is exact for a cubic.
    if (b > a) sum += (b - a) / 6 * ((*this)(a) + 4 * (*this)((a + b) / 2) + (*this)(b));
  }
  return sum;
}

std::optional<BdRate> bd_rate(std::span<const RatePoint> reference,
                              std::span<const RatePoint> tested, double bytes_from,
                              double bytes_to) {
  const auto a = rising({reference.begin(), reference.end()});
  const auto b = rising({tested.begin(), tested.end()});
  if (a.size() < 2 || b.size() < 2) return std::nullopt;
  const Pchip rate_a = rate_over_psnr(a), rate_b = rate_over_psnr(b);
  // The dB at a size, by bisection: the curve that is integrated, turned round.
  const auto clamped = [&](double bytes) {
    double low = a.front().psnr_db, high = a.back().psnr_db;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      (rate_a(middle) < std::log(bytes) ? low : high) = middle;
    }
    return 0.5 * (low + high);
  };
  const double from = std::max(clamped(bytes_from), b.front().psnr_db);
  const double to = std::min(clamped(bytes_to), b.back().psnr_db);
  if (to - from < 0.5) return std::nullopt;
  const double difference = (rate_b.integral(from, to) - rate_a.integral(from, to)) / (to - from);
  return BdRate{100 * std::expm1(difference), from, to, std::exp(rate_a(from)),
                std::exp(rate_a(to))};
}

}  // namespace nacre::bench
