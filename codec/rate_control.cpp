// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/rate_control.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "base/parallel.h"

namespace nacre::codec {
namespace {

/// Samples lie half an octave apart: 3 dB in distortion, close enough for the spline to be within
/// 1 % between them.
constexpr int kSampleSpacing = kStepsPerOctave / 2;
/// Steps run at once while a part's range is explored.
constexpr int kSampleBatch = 6;

double total_vertices(const std::vector<Part>& parts) {
  double total = 0;
  for (const Part& part : parts) total += static_cast<double>(part.vertex_count);
  return total;
}

double bits_per_vertex(const Part& part, std::size_t bytes) {
  return 8.0 * static_cast<double>(bytes) / static_cast<double>(part.vertex_count);
}

Steps coarsest_steps(const std::vector<Part>& parts) {
  Steps steps;
  for (const Part& part : parts)
    steps.push_back(part.may_be_left_out ? kNotCoded : part.coarsest_step);
  return steps;
}

/// The allocation's continuous steps as indices within each part's range.
Steps to_indices(const std::vector<Part>& parts, const alloc::Allocation& allocation) {
  Steps steps;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const double step = allocation.steps[i];
    const Part& part = parts[i];
    if (part.has_nothing_to_code || !(step > 0) || !std::isfinite(step)) {
      steps.push_back(part.may_be_left_out ? kNotCoded : part.coarsest_step);
    } else {
      steps.push_back(std::clamp(nearest_step_index(step), part.finest_step, part.coarsest_step));
    }
  }
  return steps;
}

/// log2(-λ) of the model's answer, or of the steepest slope where the model has none.
double guess_log_slope(const RateProblem& problem) {
  const auto start =
      alloc::allocate(problem.bands, 8.0 * static_cast<double>(problem.budget_bytes));
  if (start && start->lambda < 0 && std::isfinite(start->lambda)) return std::log2(-start->lambda);
  double steepest = 0;
  for (const alloc::Band& band : problem.bands)
    steepest = std::max(steepest, -band.gain * band.curve.slope(band.curve.min_bits()));
  return steepest > 0 ? std::log2(steepest) : 0;
}

}  // namespace

void Measurements::set_gains(const std::vector<double>& gains) {
  for (std::size_t i = 0; i < parts_.size(); ++i) parts_[i].gain = gains[i];
}

void Measurements::forget_bands() {
  for (std::size_t i = 1; i < known_.size(); ++i) known_[i].clear();
}

void Measurements::require(const std::vector<std::pair<std::size_t, int>>& wanted) {
  std::vector<std::pair<std::size_t, int>> missing;
  for (const auto& key : wanted)
    if (!known_[key.first].contains(key.second)) missing.push_back(key);
  std::sort(missing.begin(), missing.end());
  missing.erase(std::unique(missing.begin(), missing.end()), missing.end());
  std::vector<Measured> results(missing.size());
  parallel_for_each_index(
      missing.size(),
      [&](std::size_t i) { results[i] = parts_[missing[i].first].measure(missing[i].second); }, 1);
  for (std::size_t i = 0; i < missing.size(); ++i)
    known_[missing[i].first].emplace(missing[i].second, results[i]);
}

void Measurements::require_all(const Steps& steps) {
  std::vector<std::pair<std::size_t, int>> wanted;
  for (std::size_t i = 0; i < steps.size(); ++i) wanted.emplace_back(i, steps[i]);
  require(wanted);
}

std::size_t Measurements::bytes(const Steps& steps) {
  require_all(steps);
  std::size_t total = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) total += at(i, steps[i]).bytes;
  return total;
}

double Measurements::weighted_distortion(const Steps& steps) {
  require_all(steps);
  double sum = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    sum +=
        static_cast<double>(parts_[i].vertex_count) * parts_[i].gain * at(i, steps[i]).distortion;
  }
  return sum / total_vertices(parts_);
}

std::vector<std::vector<alloc::Sample>> sample_parts(Measurements& measurements,
                                                     std::size_t budget_bytes,
                                                     const RunContext& context) {
  const auto& parts = measurements.parts();
  std::vector<std::vector<alloc::Sample>> samples(parts.size());
  std::vector<int> next(parts.size());
  std::vector<bool> done(parts.size(), false);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    next[i] = parts[i].coarsest_step;
    if (!parts[i].may_be_left_out) continue;
    const Measured& nothing = measurements.measure(i, kNotCoded);
    samples[i].push_back({std::numeric_limits<double>::infinity(), 0, nothing.distortion});
    done[i] = parts[i].has_nothing_to_code;
  }
  for (int round = 0; std::count(done.begin(), done.end(), false) > 0; ++round) {
    if (context.cancelled()) return samples;
    std::vector<std::pair<std::size_t, int>> wanted;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (done[i]) continue;
      for (int k = 0; k < kSampleBatch && next[i] >= parts[i].finest_step; ++k) {
        wanted.emplace_back(i, next[i]);
        next[i] -= kSampleSpacing;
      }
      done[i] = next[i] < parts[i].finest_step;
    }
    measurements.require(wanted);
    for (const auto& [i, step] : wanted) {
      const Measured& m = measurements.at(i, step);
      samples[i].push_back({step_size(step), bits_per_vertex(parts[i], m.bytes), m.distortion});
      if (m.bytes > budget_bytes) done[i] = true;
    }
    context.report("measuring bands", std::min(0.9, 0.25 * (round + 1)));
  }
  return samples;
}

Result<RateSolution> search_slope(Measurements& measurements, const RateProblem& problem) {
  const auto& parts = measurements.parts();
  const std::size_t budget = problem.budget_bytes;
  RateSolution best{coarsest_steps(parts), 0};
  if (const std::size_t least = measurements.bytes(best.steps); least > budget) {
    return Error{ErrorCode::kGoalUnreachable,
                 "the base positions take at least " + std::to_string(least) + " bytes, " +
                     std::to_string(budget) + " are left for them",
                 least};
  }
  // Slopes are searched as log2(-λ): a larger one means a smaller file. The model's own answer is
  // the first guess; the bracket grows around it until it holds the real one.
  const auto fits = [&](double log_slope) {
    const double lambda = -std::exp2(log_slope);
    const Steps steps = to_indices(parts, alloc::allocate_at_slope(problem.bands, lambda));
    if (measurements.bytes(steps) > budget) return false;
    best = {steps, lambda};
    return true;
  };
  const double guess = guess_log_slope(problem);
  double low = guess, high = guess, width = 0.05;
  constexpr double kWidest = 200;  // more octaves than any two slopes of one mesh are apart
  if (fits(guess)) {
    for (; width < kWidest && fits(low = guess - width); width *= 2) high = low;
  } else {
    for (; width < kWidest && !fits(high = guess + width); width *= 2) low = high;
  }
  if (width >= kWidest) return best;
  constexpr double kSlopeTolerance = 1e-4;  // of an octave: far below one step index
  while (high - low > kSlopeTolerance) {
    const double middle = 0.5 * (low + high);
    (fits(middle) ? high : low) = middle;
  }
  return best;
}

void fill_budget(Measurements& measurements, std::size_t budget_bytes, Steps& steps) {
  const auto& parts = measurements.parts();
  // A thousandth of the budget is not worth another round.
  const std::size_t negligible = budget_bytes / 1000;
  constexpr std::array<int, 6> kMoves = {1, 2, 4, 8, 16, 32};
  constexpr int kMaxRounds = 400;
  std::size_t used = measurements.bytes(steps);
  for (int round = 0; round < kMaxRounds && used + negligible < budget_bytes; ++round) {
    std::vector<std::pair<std::size_t, int>> moves;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (parts[i].has_nothing_to_code) continue;
      const int from = steps[i] == kNotCoded ? parts[i].coarsest_step + 1 : steps[i];
      for (const int d : kMoves)
        if (from - d >= parts[i].finest_step) moves.emplace_back(i, from - d);
    }
    measurements.require(moves);
    double best_ratio = 0;
    std::size_t best_move = moves.size();
    for (std::size_t m = 0; m < moves.size(); ++m) {
      const auto [i, step] = moves[m];
      const Measured &before = measurements.at(i, steps[i]), &after = measurements.at(i, step);
      const std::size_t total = used - before.bytes + after.bytes;
      const double less = static_cast<double>(parts[i].vertex_count) * parts[i].gain *
                          (before.distortion - after.distortion);
      if (total > budget_bytes || less <= 0) continue;
      // A move that costs nothing beats all that do.
      const double cost =
          after.bytes > before.bytes ? static_cast<double>(after.bytes - before.bytes) : 1e-6;
      if (less / cost > best_ratio) {
        best_ratio = less / cost;
        best_move = m;
      }
    }
    if (best_move == moves.size()) return;
    const auto [i, step] = moves[best_move];
    used = used - measurements.at(i, steps[i]).bytes + measurements.at(i, step).bytes;
    steps[i] = step;
  }
}

}  // namespace nacre::codec
