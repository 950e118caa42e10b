// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "alloc/alloc.h"
#include "alloc/hull.h"
#include "alloc/spline.h"

namespace nacre::alloc {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
const double kLn2 = std::log(2.0);

/// Knots closer than this share of the rate range say nothing that one of them does not, and would
/// leave the spline's equations without digits.
constexpr double kLeastKnotSpacing = 1e-6;
constexpr double kLargestStepFactor = 16;  // beyond the largest step that was measured

std::optional<CubicSpline> spline_through(std::span<const Sample> hull) {
  std::vector<double> bits, log2_distortion;
  const double least = kLeastKnotSpacing * (hull.back().bits - hull.front().bits);
  for (const Sample& s : hull) {
    if (!(s.distortion > 0)) return std::nullopt;  // no logarithm: the hull itself will do
    if (!bits.empty() && s.bits - bits.back() < least) continue;
    bits.push_back(s.bits);
    log2_distortion.push_back(std::log2(s.distortion));
  }
  if (bits.size() < 3) return std::nullopt;
  return convex_log_spline(bits, log2_distortion, std::log2(1 + kSplineTolerance));
}

/// ln(e^R − 1): about R at high rate, where log step falls linearly with R, and ln R at low rate,
/// where few coefficients are left and log step is nearly linear in the logarithm of their number.
double stretched(double bits) { return bits > 30 ? bits : std::log(std::expm1(bits)); }

/// Log step against stretched rate, over hull samples and those others that keep it decreasing: a
/// sample above the hull still tells truly what its step costs.
MonotoneCubic step_curve(std::span<const Sample> samples, std::span<const Sample> hull) {
  std::vector<Sample> sorted(samples.begin(), samples.end());
  std::sort(sorted.begin(), sorted.end(), [](const Sample& a, const Sample& b) {
    return std::pair(a.bits, -a.step) < std::pair(b.bits, -b.step);
  });
  std::vector<double> x, y;
  const auto add = [&](const Sample& s) {
    const double rate = stretched(s.bits), log_step = std::log(s.step);
    if (!x.empty() && !(rate > x.back() + kLeastKnotSpacing && log_step < y.back())) return;
    x.push_back(rate);
    y.push_back(log_step);
  };
  std::size_t next = 0;
  for (const Sample& corner : hull) {
    for (; next < sorted.size() && sorted[next].bits < corner.bits; ++next) {
      const Sample& s = sorted[next];
      if (!x.empty() && s.step > corner.step && s.distortion > corner.distortion) add(s);
    }
    if (corner.bits > 0 && corner.step < kInf) add(corner);
  }
  return MonotoneCubic::through(std::move(x), std::move(y));
}

}  // namespace

struct RateDistortionCurve::Model {
  std::vector<Sample> hull;
  std::optional<CubicSpline> spline;
  MonotoneCubic log_step;  // may be empty: then there is nothing but "not coded"

  /// Index of the hull segment that holds `bits`, or the one to its right at a corner.
  [[nodiscard]] std::size_t segment(double bits) const {
    std::size_t i = 0;
    while (i + 2 < hull.size() && hull[i + 1].bits <= bits) ++i;
    return i;
  }
  [[nodiscard]] double segment_slope(std::size_t i) const {
    return (hull[i + 1].distortion - hull[i].distortion) / (hull[i + 1].bits - hull[i].bits);
  }
};

Result<RateDistortionCurve> RateDistortionCurve::fit(std::span<const Sample> samples) {
  if (samples.empty())
    return Error{ErrorCode::kBadInput, "a rate-distortion curve needs at least one sample"};
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto& [step, bits, distortion] = samples[i];
    if (!(step > 0) || !(bits >= 0 && bits < kInf) || !(distortion >= 0 && distortion < kInf))
      return Error{ErrorCode::kBadInput,
                   "a rate-distortion sample is negative or not finite, or its step is zero", i};
  }
  auto model = std::make_shared<Model>();
  model->hull = lower_hull(samples);
  model->spline = spline_through(model->hull);
  model->log_step = step_curve(samples, model->hull);
  RateDistortionCurve curve;
  curve.model_ = std::move(model);
  return curve;
}

double RateDistortionCurve::distortion(double bits) const {
  const std::vector<Sample>& hull = model_->hull;
  if (!(bits > min_bits())) return hull.front().distortion;
  if (model_->spline) return std::exp2(model_->spline->at(bits).value);
  if (bits >= max_bits()) return hull.back().distortion;
  const std::size_t i = model_->segment(bits);
  const double t = (bits - hull[i].bits) / (hull[i + 1].bits - hull[i].bits);
  return (1 - t) * hull[i].distortion + t * hull[i + 1].distortion;
}

double RateDistortionCurve::slope(double bits) const {
  if (model_->hull.size() < 2) return 0;
  if (!model_->spline) return model_->segment_slope(model_->segment(bits));
  const CubicSpline::Jet jet = model_->spline->at(bits);
  return kLn2 * jet.first * std::exp2(jet.value);
}

double RateDistortionCurve::bits_at_slope(double wanted) const {
  if (model_->hull.size() < 2 || !(wanted > slope(min_bits()))) return min_bits();
  if (!model_->spline) {
    std::size_t i = 0;
    while (i + 1 < model_->hull.size() && model_->segment_slope(i) < wanted) ++i;
    return model_->hull[i].bits;
  }
  double low = min_bits(), high = max_bits();
  if (wanted >= slope(high)) return high;
  for (;;) {  // the slope increases with the bits
    const double middle = low + (high - low) / 2;
    if (middle <= low || middle >= high) return low;
    (slope(middle) < wanted ? low : high) = middle;
  }
}

double RateDistortionCurve::step(double bits) const {
  const Sample& first = model_->hull.front();
  if (model_->hull.size() == 1) return first.step;
  if (!(bits > 0) || (bits <= first.bits && first.step == kInf)) return kInf;
  const MonotoneCubic& log_step = model_->log_step;
  if (log_step.x.empty()) return kInf;
  const double within = std::min(stretched(bits), log_step.x.back());
  return std::exp(std::min(log_step.at(within), log_step.y.front() + std::log(kLargestStepFactor)));
}

double RateDistortionCurve::min_bits() const { return model_->hull.front().bits; }
double RateDistortionCurve::max_bits() const { return model_->hull.back().bits; }
std::span<const Sample> RateDistortionCurve::hull() const { return model_->hull; }
bool RateDistortionCurve::is_spline() const { return model_->spline.has_value(); }

}  // namespace nacre::alloc
