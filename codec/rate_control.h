// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "alloc/alloc.h"
#include "base/result.h"
#include "base/run_context.h"
#include "codec/band_coder.h"

/// Which step each part of the geometry gets, so that the file has the size asked for.
namespace nacre::codec {

/// What one run of the quantiser and coder said.
struct Measured {
  std::size_t bytes = 0;  ///< the section and its entry in the header; 0 if nothing is coded
  double distortion = 0;  ///< mean squared error per vertex of the part
};

/// The base positions, or one detail band.
struct Part {
  std::size_t vertex_count = 0;
  double gain = 1;              ///< squared error on the finest mesh per squared error in the part
  int coarsest_step = 0;        ///< the largest step worth trying
  int finest_step = 0;          ///< the smallest; == coarsest_step if there is nothing to code
  bool may_be_left_out = true;  ///< false for the base
  bool has_nothing_to_code = false;
  std::function<Measured(int step_index)> measure;
};

/// One step index per part, or kNotCoded.
using Steps = std::vector<int>;

/// Runs parts at steps, in parallel, each at most once.
class Measurements {
 public:
  explicit Measurements(std::vector<Part> parts)
      : parts_(std::move(parts)), known_(parts_.size()) {}

  [[nodiscard]] const std::vector<Part>& parts() const { return parts_; }
  void set_gains(const std::vector<double>& gains);
  /// Forgets what was measured of the detail bands, whose contents have changed.
  void forget_bands();
  void require(const std::vector<std::pair<std::size_t, int>>& wanted);
  [[nodiscard]] const Measured& at(std::size_t part, int step) const {
    return known_[part].at(step);
  }
  [[nodiscard]] const Measured& measure(std::size_t part, int step) {
    require({{part, step}});
    return at(part, step);
  }
  void require_all(const Steps& steps);
  [[nodiscard]] std::size_t bytes(const Steps& steps);  ///< Σ bytes
  /// Σ w_i D_i over the parts, from the measured D_i.
  [[nodiscard]] double weighted_distortion(const Steps& steps);

 private:
  std::vector<Part> parts_;
  std::vector<std::map<int, Measured>> known_;
};

/// (R, D) samples of each part over a geometric range of steps, from nothing coded down to where
/// the part alone would take `budget_bytes`.
[[nodiscard]] std::vector<std::vector<alloc::Sample>> sample_parts(Measurements& measurements,
                                                                   std::size_t budget_bytes,
                                                                   const RunContext& context);

/// What the search needs to know: the bands with their curves, and the room there is.
struct RateProblem {
  std::vector<alloc::Band> bands;
  std::size_t budget_bytes = 0;  ///< for the sum of all parts
};

struct RateSolution {
  Steps steps;
  double lambda = 0;
};

/// Steps of a common slope whose real size is at most the budget, by dichotomy on the slope.
///
/// Errors   kGoalUnreachable if even the coarsest steps are too large.
[[nodiscard]] Result<RateSolution> search_slope(Measurements& measurements,
                                                const RateProblem& problem);

/// Spends what the dichotomy left over: refines one part at a time, the best gain per byte first.
void fill_budget(Measurements& measurements, std::size_t budget_bytes, Steps& steps);

}  // namespace nacre::codec
