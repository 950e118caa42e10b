// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "base/result.h"

/// Measured (rate, distortion) samples per band → convex curves → one step per band. Knows no coder:
/// the caller measures the samples. See README.md.
namespace nacre::alloc {

/// One run of the real quantiser and coder on one band.
struct Sample {
  double step = 0;        ///< quantisation step, model units
  double bits = 0;        ///< bits per vertex of the band (3 components)
  double distortion = 0;  ///< mean squared error per vertex of the band, model units²
};

/// Distortion of one band as a function of its rate: the lower convex hull of the samples, and a
/// smoothing B-spline through log2 D where that is convex and decreasing; else the hull itself.
class RateDistortionCurve {
 public:
  /// Errors   kBadInput if no sample is given or one is negative or not finite.
  /// Source   [LVQ] section 4.2; de Boor's smoothing spline (CODING 4.9).
  static Result<RateDistortionCurve> fit(std::span<const Sample> samples);

  [[nodiscard]] double distortion(double bits) const;
  [[nodiscard]] double slope(double bits) const;          ///< dD/dR <= 0
  [[nodiscard]] double bits_at_slope(double slope) const;  ///< the R with dD/dR = slope, clamped
  [[nodiscard]] double step(double bits) const;            ///< log-interpolated along the hull
  [[nodiscard]] double min_bits() const;
  [[nodiscard]] double max_bits() const;
  [[nodiscard]] std::span<const Sample> hull() const;
  [[nodiscard]] bool is_spline() const;  ///< false where the hull had to stand in

 private:
  struct Model;
  std::shared_ptr<const Model> model_;
};

struct Band {
  std::size_t vertex_count = 0;
  double gain = 1;  ///< E_i: squared error on the finest mesh per squared error in the band
  RateDistortionCurve curve;
};

struct Allocation {
  double lambda = 0;                 ///< common weighted slope, < 0
  std::vector<double> bits;          ///< per band, bits per vertex of the band
  std::vector<double> steps;         ///< per band; infinity where the band is not coded
  double total_bits = 0;             ///< Σ vertex_count · bits
  double predicted_distortion = 0;   ///< Σ w_i D_i: mean squared error per finest vertex
  int iterations = 0;
};

/// [LVQ] eq. (6) at a given λ < 0: (w_i / a_i) D_i'(R_i) = λ with w_i = a_i E_i.
[[nodiscard]] Allocation allocate_at_slope(std::span<const Band> bands, double lambda);

/// Dichotomy on λ so that total_bits <= budget_bits, as close as the curves allow.
///
/// Errors   kGoalUnreachable if even the smallest rates exceed the budget.
[[nodiscard]] Result<Allocation> allocate(std::span<const Band> bands, double budget_bits);

}  // namespace nacre::alloc
