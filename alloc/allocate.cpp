// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "alloc/alloc.h"

namespace nacre::alloc {
namespace {

constexpr double kSmallestSlope = std::numeric_limits<double>::min();

double count(const Band& band) { return static_cast<double>(band.vertex_count); }

double total_bits(std::span<const Band> bands, std::span<const double> bits) {
  double total = 0;
  for (std::size_t i = 0; i < bands.size(); ++i) total += count(bands[i]) * bits[i];
  return total;
}

std::vector<double> bits_at(std::span<const Band> bands, double lambda) {
  std::vector<double> bits;
  bits.reserve(bands.size());
  for (const Band& b : bands) bits.push_back(b.curve.bits_at_slope(lambda / b.gain));
  return bits;
}

/// Steps and sums that follow from the bits.
Allocation complete(std::span<const Band> bands, double lambda, std::vector<double> bits) {
  Allocation result;
  result.lambda = lambda;
  result.bits = std::move(bits);
  result.total_bits = total_bits(bands, result.bits);
  double vertices = 0;
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const Band& b = bands[i];
    result.steps.push_back(b.curve.step(result.bits[i]));
    result.predicted_distortion += count(b) * b.gain * b.curve.distortion(result.bits[i]);
    vertices += count(b);
  }
  if (vertices > 0) result.predicted_distortion /= vertices;
  return result;
}

/// Moves from `within` towards `beyond` as far as the budget lets. The two belong to neighbouring
/// λ, so they differ by a segment of a hull, along which the weighted slope is λ everywhere.
std::vector<double> fill(std::span<const Band> bands, const std::vector<double>& within,
                         const std::vector<double>& beyond, double budget) {
  const double total = total_bits(bands, within), more = total_bits(bands, beyond) - total;
  double share = std::clamp((budget - total) / more, 0.0, 1.0);
  for (double back_off = 1e-15;; back_off *= 4) {
    std::vector<double> bits = within;
    if (!(share > 0)) return bits;
    for (std::size_t i = 0; i < bits.size(); ++i)
      bits[i] = std::min(beyond[i], within[i] + share * (beyond[i] - within[i]));
    if (total_bits(bands, bits) <= budget) return bits;
    share -= back_off;  // the sum was rounded up
  }
}

}  // namespace

Allocation allocate_at_slope(std::span<const Band> bands, double lambda) {
  return complete(bands, lambda, bits_at(bands, lambda));
}

Result<Allocation> allocate(std::span<const Band> bands, double budget_bits) {
  if (std::isnan(budget_bits)) return Error{ErrorCode::kBadInput, "the bit budget is not a number"};
  double steepest = kSmallestSlope, flattest = std::numeric_limits<double>::infinity();
  std::vector<double> within, beyond;
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const auto& [vertex_count, gain, curve] = bands[i];
    if (!(gain > 0 && gain < std::numeric_limits<double>::infinity()))
      return Error{ErrorCode::kBadInput, "the gain of a band is not a positive number", i};
    within.push_back(curve.min_bits());
    beyond.push_back(curve.max_bits());
    steepest = std::max(steepest, -gain * curve.slope(curve.min_bits()));
    flattest = std::min(flattest, -gain * curve.slope(curve.max_bits()));
  }
  const double least = total_bits(bands, within);
  if (!(least <= budget_bits))
    return Error{ErrorCode::kGoalUnreachable, "the smallest rates already need " +
                                                  std::to_string(least) + " bits of a budget of " +
                                                  std::to_string(budget_bits)};
  flattest = std::clamp(flattest / 2, kSmallestSlope, steepest);
  if (total_bits(bands, beyond) <= budget_bits) return complete(bands, -flattest, beyond);

  double log_within = std::log(steepest) + 1, log_beyond = std::log(flattest);
  int iterations = 0;
  for (; iterations < 200; ++iterations) {
    const double middle = (log_within + log_beyond) / 2;
    if (!(middle < log_within && middle > log_beyond)) break;
    std::vector<double> bits = bits_at(bands, -std::exp(middle));
    if (total_bits(bands, bits) <= budget_bits) {
      log_within = middle;
      within = std::move(bits);
    } else {
      log_beyond = middle;
      beyond = std::move(bits);
    }
  }
  Allocation result =
      complete(bands, -std::exp(log_within), fill(bands, within, beyond, budget_bits));
  result.iterations = iterations;
  return result;
}

}  // namespace nacre::alloc
