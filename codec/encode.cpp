// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <new>
#include <optional>
#include <string>

#include "codec/assemble.h"
#include "codec/best_encode.h"
#include "codec/codec.h"
#include "codec/eqmc_coder.h"
#include "codec/geometry_coder.h"
#include "codec/nmc_coder.h"
#include "codec/rate_control.h"
#include "codec/stream_format.h"

namespace nacre::codec {
namespace {

/// How often the curves are sampled: first in the frames of the undistorted mesh, then in those of
/// the mesh decoded at the first round's steps.
constexpr int kCurveRounds = 2;
/// How often a file is made whose size is then corrected, and how much room may stay unused.
constexpr int kSizeRounds = 8;
constexpr double kUnusedShare = 1.0 / 400;

Result<void> check(const SemiRegularMesh& mesh, const EncodeOptions& options) {
  const auto bad = [](const std::string& what, std::size_t where = 0) {
    return Error{ErrorCode::kBadInput, what, where};
  };
  if ((options.target_bytes == 0) == !(options.step > 0))
    return bad("a target size or a step is needed, and not both");
  if (options.step != 0 && (options.profile != Profile::kBest || !std::isfinite(options.step)))
    return bad("a step can be given to profile best only");
  if (options.base_bits != 0 &&
      (options.base_bits < kMinBaseBits || options.base_bits > kMaxBaseBits))
    return bad("base bits must lie in 6 .. 20");
  if (!(options.theta_degrees >= 0) || options.theta_degrees > 90)
    return bad("the cone's angle must lie in 0 .. 90 degrees");
  if (is_comparator(options.profile) && options.transform != wavelet::Transform::kButterfly)
    return bad("this profile has no transform but the butterfly");
  if (mesh.base_triangles.empty()) return bad("the mesh has no triangles");
  if (mesh.level_count < 0 || mesh.level_count > kMaxLevels)
    return bad("the mesh has " + std::to_string(mesh.level_count) +
               " levels; 0 .. 15 are possible");
  if (!options.aims.empty() && options.aims.size() != mesh.positions.size())
    return bad("the mesh needs an aim for each of its vertices, or none", options.aims.size());
  for (std::size_t i = 0; i < options.aims.size(); ++i)
    if (!options.aims[i].allFinite())
      return bad("the aim of vertex " + std::to_string(i) + " is not finite", i);
  // Steps of the format end at 2^±200; coordinates keep well clear of both ends.
  constexpr double kLargest = 0x1p150, kSmallest = 0x1p-150;
  double largest = 0;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const double x = std::abs(mesh.positions[i][k]);
      if (!(x <= kLargest))
        return bad("vertex " + std::to_string(i) + " has no usable coordinates", i);
      largest = std::max(largest, x);
    }
  }
  if (largest != 0 && largest < kSmallest) return bad("the mesh is too small to be coded");
  for (int k = 0; k < 3; ++k)
    if (!std::isfinite(mesh.origin[k])) return bad("the origin is not finite");
  return {};
}

std::size_t varint_bytes(std::uint64_t value) {
  std::size_t count = 1;
  for (; value >= 0x80; value >>= 7) ++count;
  return count;
}

/// A payload with its checksum and its length field.
std::size_t section_bytes(std::size_t payload) {
  return payload + checksum_bytes(payload) + varint_bytes(payload);
}

std::size_t base_bytes(const CodedBase& base) {
  std::size_t bytes = section_bytes(base.payload.size());
  for (const std::int64_t corner : base.corner) bytes += varint_bytes(zigzag(corner));
  return bytes;
}

/// One byte for the step, which differs little from the coarser band's.
std::size_t band_bytes(const CodedBand& band) {
  return band.payload.empty() ? 0 : section_bytes(band.payload.size()) + 1;
}

class Encoder {
 public:
  Encoder(const SemiRegularMesh& mesh, const EncodeOptions& options, const RunContext& context,
          const Prepared& prepared);

  Result<Encoded> run();

 private:
  /// A coding and the file it makes.
  struct Outcome {
    CodedGeometry coded;
    std::vector<std::uint8_t> bytes;
    double lambda = 0;
    std::size_t measured_bytes = 0;  ///< of the parts, as the search believed
  };

  [[nodiscard]] Part base_part() const;
  [[nodiscard]] Part band_part(std::size_t band) const;
  [[nodiscard]] std::vector<Part> make_parts() const;
  [[nodiscard]] Steps least_steps() const;
  Result<Outcome> make_outcome(const Steps& steps, double lambda);
  /// Curves from samples in the present frames; then gains and frames from the coding they lead to.
  Result<void> fit_curves(std::size_t budget);
  Result<Outcome> solve(std::size_t budget);
  /// The outcome of the right size, with the budget corrected until it has it.
  Result<Outcome> solve_for_file_size(std::size_t budget);
  void adopt_frames(CodedGeometry& coded);
  [[nodiscard]] double predicted(const CodedGeometry& coded) const;
  [[nodiscard]] EncodeReport report(const Outcome& outcome) const;

  const SemiRegularMesh& mesh_;
  const EncodeOptions& options_;
  const RunContext& context_;
  const Prepared& prepared_;
  BandCoderOptions coder_;
  std::vector<std::vector<Vec3>> details_;  ///< what bands are measured on, in the latest frames
  Measurements measurements_;
  std::vector<std::vector<alloc::Sample>> samples_;
  std::vector<alloc::Band> bands_;
};

Encoder::Encoder(const SemiRegularMesh& mesh, const EncodeOptions& options,
                 const RunContext& context, const Prepared& prepared)
    : mesh_(mesh),
      options_(options),
      context_(context),
      prepared_(prepared),
      details_(prepared.pyramid.bands),
      measurements_({}) {
  coder_.theta_rad = options.theta_degrees * (M_PI / 180);
  measurements_ = Measurements(make_parts());
}

Part Encoder::base_part() const {
  Part part;
  const auto& positions = prepared_.pyramid.base_positions;
  const int bits = options_.base_bits;
  part.vertex_count = positions.size();
  part.may_be_left_out = false;
  part.coarsest_step = step_index_for_bits(positions, bits == 0 ? kMinBaseBits : bits);
  part.finest_step = bits == 0 ? step_index_for_bits(positions, kMaxBaseBits) : part.coarsest_step;
  part.has_nothing_to_code = part.finest_step == part.coarsest_step;
  part.measure = [this](int step) {
    const CodedBase base =
        encode_base(prepared_.pyramid.base_positions, prepared_.connectivity.decoded, step);
    return Measured{base_bytes(base), base.distortion};
  };
  return part;
}

Part Encoder::band_part(std::size_t band) const {
  Part part;
  part.vertex_count = details_[band].size();
  double largest = 0;  // of the vectors, so that it bounds a component in any frame
  for (const Vec3& d : details_[band]) largest = std::max(largest, norm(d));
  // Rounding noise of a flat mesh is not worth a band, and may lie below the smallest step.
  part.has_nothing_to_code = !(largest > 0x1p-190);
  if (!part.has_nothing_to_code) {
    part.coarsest_step = nearest_step_index(largest / coder_.dead_zone) - 1;
    // 22 bits per component: beyond that the lattice's range ends.
    part.finest_step = std::max(part.coarsest_step - 22 * kStepsPerOctave, -kMaxStepIndex);
  }
  part.measure = [this, band](int step) {
    const CodedBand coded = encode_band(details_[band], step, coder_);
    return Measured{band_bytes(coded), coded.distortion};
  };
  return part;
}

std::vector<Part> Encoder::make_parts() const {
  std::vector<Part> parts = {base_part()};
  for (std::size_t j = 0; j < details_.size(); ++j) parts.push_back(band_part(j));
  const auto gains = wavelet::regular_gains(prepared_.topology.level_count(), options_.transform);
  for (std::size_t i = 0; i < parts.size(); ++i) parts[i].gain = gains.energy[i];
  return parts;
}

Steps Encoder::least_steps() const {
  Steps steps;
  for (const Part& part : measurements_.parts())
    steps.push_back(part.may_be_left_out ? kNotCoded : part.coarsest_step);
  return steps;
}

Result<Encoder::Outcome> Encoder::make_outcome(const Steps& steps, double lambda) {
  auto coded = code_geometry(prepared_, steps, coder_);
  if (!coded) return coded.error();
  Outcome outcome{std::move(*coded), {}, lambda, measurements_.bytes(steps)};
  outcome.bytes = assemble(prepared_, outcome.coded, Profile::kPaper, mesh_.origin);
  return outcome;
}

void Encoder::adopt_frames(CodedGeometry& coded) {
  if (coded.frames.empty()) return;
  details_ = std::move(coded.details);
  measurements_.forget_bands();
}

Result<Encoder::Outcome> Encoder::solve(std::size_t budget) {
  auto solution = search_slope(measurements_, {bands_, budget});
  if (!solution) return solution.error();
  fill_budget(measurements_, budget, solution->steps);
  return make_outcome(solution->steps, solution->lambda);
}

Result<void> Encoder::fit_curves(std::size_t budget) {
  for (int round = 0; round < kCurveRounds; ++round) {
    samples_ = sample_parts(measurements_, budget, context_);
    if (context_.cancelled()) return encoding_cancelled();
    bands_.clear();
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      const Part& part = measurements_.parts()[i];
      auto curve = alloc::RateDistortionCurve::fit(samples_[i]);
      if (!curve) return curve.error();
      bands_.push_back({part.vertex_count, part.gain, std::move(*curve)});
    }
    auto outcome = solve(budget);
    if (!outcome) return outcome.error();
    std::vector<double> gains;
    for (const Part& part : measurements_.parts()) gains.push_back(part.gain);
    gains = gains_of_errors(prepared_, outcome->coded, std::move(gains));
    measurements_.set_gains(gains);
    for (std::size_t i = 0; i < bands_.size(); ++i) bands_[i].gain = gains[i];
    adopt_frames(outcome->coded);
    context_.report("allocating", static_cast<double>(round + 1) / (kCurveRounds + 1));
  }
  return {};
}

Result<Encoder::Outcome> Encoder::solve_for_file_size(std::size_t budget) {
  // The real file differs a little from what was measured: the frames follow the steps of all
  // coarser parts, and the header its contents. So each round starts from the last one's frames and
  // moves the budget by what was missing or too much.
  const std::size_t target = options_.target_bytes;
  const auto unused = static_cast<std::size_t>(kUnusedShare * static_cast<double>(target));
  std::optional<Outcome> best;
  for (int round = 0; round < 3 * kSizeRounds && (round < kSizeRounds || !best); ++round) {
    if (context_.cancelled()) return encoding_cancelled();
    auto outcome = solve(budget);
    if (!outcome) break;  // the budget was corrected below the least there is
    const std::size_t size = outcome->bytes.size();
    // Where even the finest steps leave room, more budget changes nothing.
    const bool is_all = outcome->measured_bytes + budget / 50 < budget;
    const bool fits = size <= target;
    if (fits) {
      budget += target - size;
    } else {
      // A second excess in a row is met with more than itself.
      const std::size_t cut =
          (size - target) * static_cast<std::size_t>(1 + round / kSizeRounds) + 1;
      budget -= std::min(budget, cut);
    }
    const bool done = fits && (is_all || size + unused >= target);
    if (!fits || (best && best->coded.error <= outcome->coded.error && !done)) {
      adopt_frames(outcome->coded);
      continue;
    }
    if (done) return outcome;
    CodedGeometry latest = outcome->coded;
    best = std::move(*outcome);
    adopt_frames(latest);
  }
  if (best) return std::move(*best);
  return make_outcome(least_steps(), 0);
}

double Encoder::predicted(const CodedGeometry& coded) const {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < bands_.size(); ++i) {
    const auto vertices = static_cast<double>(bands_[i].vertex_count);
    // The base has no smooth curve where its coordinates are round numbers.
    double distortion = coded.base.distortion;
    if (i > 0) {
      const double bits = 8.0 * static_cast<double>(band_bytes(coded.bands[i - 1])) / vertices;
      distortion = bands_[i].curve.distortion(bits);
    }
    sum += vertices * bands_[i].gain * distortion;
    count += vertices;
  }
  return sum / count;
}

EncodeReport Encoder::report(const Outcome& outcome) const {
  EncodeReport report = describe(prepared_, outcome.coded, outcome.bytes.size());
  report.lambda = outcome.lambda;
  report.predicted_distortion = predicted(outcome.coded);
  for (std::size_t j = 0; j < report.bands.size(); ++j) {
    report.bands[j].gain = bands_[j + 1].gain;
    report.bands[j].samples = samples_[j + 1];
  }
  return report;
}

Result<Encoded> Encoder::run() {
  const Steps least = least_steps();
  const auto smallest = make_outcome(least, 0);
  if (!smallest) return smallest.error();
  const std::size_t size = smallest->bytes.size();
  if (size > options_.target_bytes) return base_too_large(size, options_.target_bytes);
  const std::size_t budget = options_.target_bytes - (size - smallest->measured_bytes);
  if (const auto ok = fit_curves(budget); !ok) return ok.error();
  auto outcome = solve_for_file_size(budget);
  if (!outcome) return outcome.error();
  EncodeReport outcome_report = report(*outcome);
  return verified(prepared_, std::move(outcome_report), std::move(outcome->bytes));
}

}  // namespace

Result<Encoded> encode(const SemiRegularMesh& mesh, const EncodeOptions& options,
                       const RunContext& context) {
  if (const auto ok = check(mesh, options); !ok) return ok.error();
  try {
    const auto prepared = prepare(mesh, options.transform, options.aims);
    if (!prepared) return prepared.error();
    if (context.cancelled()) return encoding_cancelled();
    if (options.profile == Profile::kBest) return encode_best(mesh, options, context, *prepared);
    if (options.profile == Profile::kNmc) return encode_nmc(mesh, options, context, *prepared);
    if (options.profile == Profile::kEqmc) return encode_eqmc(mesh, options, context, *prepared);
    return Encoder(mesh, options, context, *prepared).run();
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kLimitExceeded, "not enough memory to encode the mesh", 0};
  }
}

}  // namespace nacre::codec
