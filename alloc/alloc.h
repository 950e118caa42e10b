// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "base/result.h"

/// Measured (rate, distortion) samples per band → convex curves → one step per band. Knows no
/// coder: the caller measures the samples. See README.md.
namespace nacre::alloc {

/// One run of the real quantiser and coder on one band.
struct Sample {
  double step = 0;        ///< quantisation step, model units; infinity: the band is not coded
  double bits = 0;        ///< bits per vertex of the band (3 components)
  double distortion = 0;  ///< mean squared error per vertex of the band, model units²
};

/// Distortion of one band as a function of its rate: the lower convex hull of the samples, and a
/// smoothing spline through log2 D where that is convex and decreasing; else the hull itself.
///
/// Callers add the sample {infinity, 0, energy of the band}, so that "not coded" is one of the
/// choices. A band of zero energy becomes a curve of the one point 0 bits, D = 0.
class RateDistortionCurve {
 public:
  /// Ensures  (1) distortion() is convex and not increasing over [min_bits, max_bits], decreasing
  ///              where there is more than one hull point, and constant outside
  ///          (2) it equals the sample's distortion at min_bits, so the energy at 0 bits
  ///          (3) it is within kSplineTolerance of every hull sample
  /// Errors   kBadInput if no sample is given, one is negative or not finite (but for an infinite
  ///          step), or a step is zero; `where` is the sample.
  /// Source   [LVQ] section 4.2; [Reinsch1967], [deBoor1978] ch. XIV.
  static Result<RateDistortionCurve> fit(std::span<const Sample> samples);

  [[nodiscard]] double distortion(double bits) const;
  /// dD/dR <= 0; at a corner of a hull, of the segment with more bits; at max_bits, from below.
  [[nodiscard]] double slope(double bits) const;
  /// The R with dD/dR = slope, clamped to [min_bits, max_bits]; the smallest one if a segment of a
  /// hull has that slope.
  [[nodiscard]] double bits_at_slope(double slope) const;
  /// The step that spends `bits`: monotone cubic interpolation of log step over the samples against
  /// ln(e^R − 1), in which it is smooth at both ends. Below the smallest coded rate it continues as
  /// a power of R, up to 16 times the largest step; beyond max_bits it stays. Infinity at min_bits
  /// if that is "not coded", and at 0 bits.
  [[nodiscard]] double step(double bits) const;
  [[nodiscard]] double min_bits() const;
  [[nodiscard]] double max_bits() const;
  /// By increasing bits and decreasing distortion.
  [[nodiscard]] std::span<const Sample> hull() const;
  [[nodiscard]] bool is_spline() const;  ///< false where the hull had to stand in

 private:
  struct Model;
  std::shared_ptr<const Model> model_;
};

/// Largest relative distance in D between a spline and a hull sample; a spline that would need more
/// to be convex gives way to the hull. Half the 5 % within which Σ w_i D_i must predict the error.
inline constexpr double kSplineTolerance = 0.025;

struct Band {
  std::size_t vertex_count = 0;
  double gain = 1;  ///< E_i > 0: squared error on the finest mesh per squared error in the band
  RateDistortionCurve curve;
};

struct Allocation {
  double lambda = 0;                ///< common weighted slope, < 0
  std::vector<double> bits;         ///< per band, bits per vertex of the band
  std::vector<double> steps;        ///< per band; infinity where the band is not coded
  double total_bits = 0;            ///< Σ vertex_count · bits
  double predicted_distortion = 0;  ///< Σ w_i D_i: mean squared error per finest vertex
  int iterations = 0;
};

/// [LVQ] eq. (6) at a given λ < 0: (w_i / a_i) D_i'(R_i) = λ with w_i = a_i E_i, so E_i D_i' = λ.
///
/// a_i = vertex_count / Σ vertex_count over the given bands: give all of them, the base mesh as one
/// more band (gain E_J), for predicted_distortion to be per vertex of the finest mesh.
[[nodiscard]] Allocation allocate_at_slope(std::span<const Band> bands, double lambda);

/// Dichotomy on λ so that total_bits <= budget_bits, as close as the curves allow: where hulls
/// stand in, the last segment is filled partly.
///
/// Ensures  (1) total_bits <= budget_bits
///          (2) total_bits is within 1e-9 of the budget or every band is at max_bits
///          (3) no other rates within the budget predict less distortion
/// Errors   kGoalUnreachable if even the smallest rates exceed the budget.
///          kBadInput if the budget is not a number or a gain is not positive; `where` is the band.
/// Source   [LVQ] section 4.1; [ShohamGersho1988].
[[nodiscard]] Result<Allocation> allocate(std::span<const Band> bands, double budget_bits);

}  // namespace nacre::alloc
