// SPDX-License-Identifier: GPL-3.0-or-later
//
// Read me first: one number decides the size, the step Δ that an error on the finest mesh would be
// quantised with. A part whose errors are multiplied by its gain E on their way there gets the step
// Δ / sqrt(E), and a bit is worth λ = kLambda Δ² of squared error everywhere; then all parts are at
// the same slope, and the search is along a line.
#include "codec/best_encode.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "codec/assemble.h"
#include "codec/best_coder.h"
#include "codec/snap_base.h"
#include "codec/stream_format.h"

namespace nacre::codec {
namespace {

/// λ / Δ². A uniform quantiser at high rate loses 2 ln 2 / 12 = 0.116 of its squared step per bit.
constexpr double kLambda = 0.1;
/// The same without levels, where fewer vertices are the better way to spend less.
constexpr double kLambdaWithoutLevels = 0.03;
/// Steps go as E^-(kGainPower / 2): what coarse parts lose, finer ones that are coded win back.
constexpr double kGainPower = 0.6;
constexpr int kMaxTrials = 24;
/// Without levels: trials of λ at one step, by bisection; and positions past the finest step, where
/// vertices that slid for bits go back to the nearest grid points.
constexpr int kPriceTrials = 7;
constexpr double kPriceOnly = 6.0 * kStepsPerOctave;
/// How much coarser the base's grid is where its points are chosen near the surface; of
/// kStepsPerOctave.
constexpr int kCoarserBase = 70;
/// Where sizes jump past the target, and more than this share is left, a grid finer by so much.
constexpr double kJump = 0.01;
constexpr int kFinerBase = 20;

/// Targets let vertices drift along the surface, past the triangles that surface_error() looks at:
/// it is too large then, and only clearly larger where details along the normal are not enough.
constexpr double kDriftAllowance = 1.4;

struct Effort {
  /// Room in the file that may stay unused; and before the targets are known.
  double unused_share, first_unused_share;
  int shrinking_rounds;  ///< of sparse_targets()
  bool is_quick;         ///< see BestEncoder::quickly()
};
constexpr Effort kNormalEffort = {1.0 / 400, 1.0 / 16, 40, false},
                 kFastEffort = {1.0 / 200, 1.0 / 6, 12, true};

/// A quick search begins at the step that is usual for the size: log2(bytes) at a step of 2^-8 of
/// the diagonal, and what each halving of it adds.
constexpr double kUsualLog2Bytes = 10.8, kUsualPerOctave = 0.875;
/// How sizes go with positions near there: ln(bytes) falls so much with each.
constexpr double kLogSizePerPosition = 0.015;
/// So near its size, in ln(bytes), a file without targets says where targets should be; it is
/// looked for so often, and with targets.
constexpr double kNearEnough = 0.35;
constexpr int kQuickLooks = 3, kQuickTrials = 6;
/// What targets save, in positions.
constexpr double kSavedByTargets = 8;
/// Error goes with this power of the size.
constexpr double kErrorPerSize = -1.5;

class BestEncoder {
 public:
  BestEncoder(const SemiRegularMesh& mesh, const EncodeOptions& options, const RunContext& context,
              const Prepared& prepared);

  Result<Encoded> run();

 private:
  /// A file, at a Δ of 2^(position / 32).
  struct Trial {
    double position = 0, lambda = 0;
    CodedGeometry coded;
    std::vector<std::uint8_t> bytes;
    bool has_targets = false;     ///< it aimed at targets_, else at the mesh
    std::optional<double> error;  ///< see error_of()

    [[nodiscard]] double log_size() const { return std::log(static_cast<double>(bytes.size())); }
  };

  /// The range of steps of one part, as indices.
  struct StepRange {
    int finest = 0, coarsest = 0;
    bool is_empty = false;
  };

  [[nodiscard]] StepRange base_range() const;
  [[nodiscard]] StepRange band_range(std::size_t band) const;
  [[nodiscard]] double position_of(std::size_t part, int step_index) const;
  /// Steps and λ at a position; the steps then moved by `offsets` indices, λ by `dearer` octaves.
  Result<Trial> make_trial(double position, const std::vector<int>& offsets = {},
                           double dearer = 0) const;
  /// Where sizes jump past the target: steps of single parts, as far as they fit.
  Result<Trial> spend(Trial best, double unused_share) const;
  /// The same without levels: this step or the next, and bits that are worth less or more.
  Result<Trial> spend_on_base(Trial best, double unused_share) const;
  [[nodiscard]] bool is_close(const Trial& trial, double unused_share) const {
    return static_cast<double>(trial.bytes.size()) >=
           static_cast<double>(options_.target_bytes) * (1 - unused_share);
  }
  /// The file whose Δ is the step that is asked for.
  Result<Trial> at_step();
  /// The best file of at most the target.
  Result<Trial> within_target();
  /// The same in a few trials, about as good; none where the usual search has to do it.
  Result<std::optional<Trial>> quickly();
  /// A file without targets of about the size, and where it would have it.
  Result<std::optional<std::pair<Trial, double>>> look_quickly() const;
  /// The largest file found that fits, by few trials from `position` on; none: none did.
  Result<std::optional<Trial>> close_in(double position) const;
  [[nodiscard]] bool is_base_alone() const { return prepared_.topology.level_count() == 0; }
  /// Whether levels can aim at anything else than the mesh as it is.
  [[nodiscard]] bool has_aims() const { return weights_ && !is_base_alone(); }
  /// What levels should aim at, now that the steps are about known.
  void aim(double position, int coarser_base = kCoarserBase);
  /// The best file of at most the target whose levels aim at targets, near `position`.
  Result<Trial> aimed(double position, int coarser_base);
  /// The best file of at most the target, from one that is, near `guess` if given.
  Result<Trial> search(Trial smallest, double unused_share,
                       std::optional<double> guess = std::nullopt) const;
  [[nodiscard]] bool fits(const Trial& trial) const {
    return trial.bytes.size() <= options_.target_bytes;
  }
  /// Of the surface where there are weights, else of the vertices. It takes about as long as the
  /// coding, so only those that are compared have theirs.
  double error_of(Trial& trial) const {
    if (!trial.error)
      trial.error =
          weights_ ? surface_error(prepared_, *weights_, trial.coded.decoded) : trial.coded.error;
    return *trial.error;
  }

  /// Without levels vertices slide, which surface_error() takes for errors; there the larger file
  /// of two that fit is the better one.
  bool is_better(Trial& trial, Trial& than) const {
    if (is_base_alone()) return trial.bytes.size() > than.bytes.size();
    return error_of(trial) < error_of(than);
  }

  const SemiRegularMesh& mesh_;
  const EncodeOptions& options_;
  const RunContext& context_;
  const Prepared& prepared_;
  const Effort& effort_;
  std::optional<SurfaceWeights> weights_;  ///< of transforms whose frames the encoder can follow
  std::optional<Targets> targets_;         ///< none: the mesh as it is, vertex by vertex
  std::vector<double> gains_;              ///< of the base, then the bands
  std::vector<StepRange> ranges_;
  int base_step_ = 0;                 ///< with targets
  double finest_ = 0, coarsest_ = 0;  ///< positions between which anything changes
  double extent_ = 0;                 ///< the diagonal of the mesh's box
};

BestEncoder::BestEncoder(const SemiRegularMesh& mesh, const EncodeOptions& options,
                         const RunContext& context, const Prepared& prepared)
    : mesh_(mesh),
      options_(options),
      context_(context),
      prepared_(prepared),
      effort_(options.effort == codec::Effort::kFast ? kFastEffort : kNormalEffort) {
  if (prepared.transform == wavelet::Transform::kButterfly) {
    weights_ = surface_weights(prepared);
  }
  Vec3 low = prepared.positions.front(), high = low;
  for (const Vec3& p : prepared.positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  extent_ = norm(high - low);
  gains_ = best_gains(prepared);
  ranges_.push_back(base_range());
  for (std::size_t j = 0; j < prepared.pyramid.bands.size(); ++j) ranges_.push_back(band_range(j));
  finest_ = position_of(0, ranges_[0].finest);
  coarsest_ = position_of(0, ranges_[0].coarsest);
  for (std::size_t i = 1; i < ranges_.size(); ++i) {
    if (ranges_[i].is_empty) continue;
    finest_ = std::min(finest_, position_of(i, ranges_[i].finest));
    coarsest_ = std::max(coarsest_, position_of(i, ranges_[i].coarsest));
  }
  if (is_base_alone()) finest_ -= kPriceOnly;
}

BestEncoder::StepRange BestEncoder::base_range() const {
  const auto& positions = prepared_.pyramid.base_positions;
  const int bits = options_.base_bits;
  StepRange range;
  range.coarsest = step_index_for_bits(positions, bits == 0 ? kMinBaseBits : bits);
  range.finest = bits == 0 ? step_index_for_bits(positions, kMaxBaseBits) : range.coarsest;
  return range;
}

BestEncoder::StepRange BestEncoder::band_range(std::size_t band) const {
  double largest = 0;
  for (const Vec3& d : prepared_.pyramid.bands[band]) largest = std::max(largest, norm(d));
  // Rounding noise of a flat mesh is not worth a band, and may lie below the smallest step.
  if (!(largest > 0x1p-190)) return {0, 0, true};
  // Twice the largest detail rounds everything to zero; 22 bits below it integers end.
  StepRange range;
  range.coarsest = nearest_step_index(4 * largest);
  range.finest = std::max(range.coarsest - 22 * kStepsPerOctave, -kMaxStepIndex);
  return range;
}

double BestEncoder::position_of(std::size_t part, int step_index) const {
  return step_index + 0.5 * kStepsPerOctave * std::log2(gains_[part]);
}

Result<BestEncoder::Trial> BestEncoder::make_trial(double position, const std::vector<int>& offsets,
                                                   double dearer) const {
  BestSettings settings;
  if (weights_) {
    settings.weights = &*weights_;
    if (targets_) settings.targets = &*targets_;
  }
  const double lambda = is_base_alone() ? kLambdaWithoutLevels : kLambda;
  settings.lambda = lambda * std::exp2(2 * position / kStepsPerOctave + dearer);
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    if (i == 0 && targets_) {  // which start from a base that lies on its grid
      settings.steps.push_back(base_step_);
      continue;
    }
    const double index = position - position_of(i, 0) + (offsets.empty() ? 0 : offsets[i]);
    const StepRange& range = ranges_[i];
    const bool is_left_out = range.is_empty || (i > 0 && index > range.coarsest);
    settings.steps.push_back(is_left_out ? kNotCoded
                                         : std::clamp(static_cast<int>(std::lround(index)),
                                                      range.finest, range.coarsest));
  }
  auto coded = code_best(prepared_, settings, gains_);
  if (!coded) return coded.error();
  Trial trial;
  trial.position = position;
  trial.lambda = settings.lambda;
  trial.bytes = assemble(prepared_, *coded, Profile::kBest, mesh_.origin);
  trial.coded = std::move(*coded);
  trial.has_targets = settings.targets != nullptr;
  return trial;
}

Result<BestEncoder::Trial> BestEncoder::search(Trial best, double unused_share,
                                               std::optional<double> guess) const {
  const double target = static_cast<double>(options_.target_bytes);
  // [large, small] brackets the target once `large` is there.
  std::optional<Trial> large;
  Trial small = best;
  double stride = 4.0 * kStepsPerOctave;
  for (int i = 0; i < kMaxTrials && !is_close(best, unused_share); ++i) {
    if (context_.cancelled()) return encoding_cancelled();
    const double gap = large ? small.position - large->position : 0;
    double position = 0;
    if (guess && i == 0) {
      position = std::clamp(*guess, finest_, small.position);
      stride = kStepsPerOctave / 4.0;
    } else if (!large) {
      if (small.position <= finest_) return best;
      position = std::max(small.position - stride, finest_);
    } else if (guess && gap > 2 * stride) {
      position = large->position + stride;
    } else {
      if (gap < 1e-3) break;
      // Sizes are close to exponential in the position, but jump where a step index changes.
      const double share = (std::log(target) - small.log_size()) /
                           std::max(large->log_size() - small.log_size(), 1e-9);
      position = small.position - gap * std::clamp(share, 0.1, 0.9);
    }
    auto trial = make_trial(position);
    if (!trial) return trial.error();
    if (fits(*trial)) {
      if (is_better(*trial, best)) best = *trial;
      small = std::move(*trial);
    } else {
      large = std::move(*trial);
    }
    context_.report("choosing steps", std::min(0.95, (i + 1.0) / 14));
  }
  return is_base_alone() ? spend_on_base(std::move(best), unused_share)
                         : spend(std::move(best), unused_share);
}

Result<BestEncoder::Trial> BestEncoder::spend_on_base(Trial best, double unused_share) const {
  const double position = best.position;
  for (const int finer : {0, 1}) {
    double fitting = finer, most = fitting - 1;  // by how much dearer
    for (int i = 0; i < kPriceTrials && !is_close(best, unused_share); ++i) {
      if (context_.cancelled()) return encoding_cancelled();
      const double dearer = (fitting + most) / 2;
      auto trial = make_trial(position, {-finer}, dearer);
      if (!trial) return trial.error();
      (fits(*trial) ? fitting : most) = dearer;
      if (fits(*trial) && is_better(*trial, best)) best = std::move(*trial);
    }
  }
  return best;
}

Result<BestEncoder::Trial> BestEncoder::spend(Trial best, double unused_share) const {
  std::vector<int> offsets(ranges_.size(), 0);
  for (std::size_t part = 0; part < ranges_.size() && !is_close(best, unused_share); ++part) {
    if (ranges_[part].is_empty) continue;
    for (int move = kStepsPerOctave / 2; move > 0 && !is_close(best, unused_share); move /= 2) {
      if (context_.cancelled()) return encoding_cancelled();
      offsets[part] -= move;
      auto trial = make_trial(best.position, offsets);
      if (!trial) return trial.error();
      if (fits(*trial) && is_better(*trial, best)) {
        best = std::move(*trial);
      } else {
        offsets[part] += move;
      }
    }
  }
  return best;
}

void BestEncoder::aim(double position, int coarser_base) {
  const auto gains = wavelet::regular_gains(prepared_.topology.level_count(), prepared_.transform);
  const auto index = static_cast<int>(std::lround(position - position_of(0, 0)));
  base_step_ = std::clamp(index + coarser_base, ranges_[0].finest, ranges_[0].coarsest);
  const Prepared snapped = snap_base(prepared_, *weights_, step_size(base_step_));
  targets_ =
      sparse_targets(snapped, surface_weights(snapped), std::exp2(position / kStepsPerOctave),
                     gains.energy, effort_.shrinking_rounds);
  weights_->normals = target_normals(prepared_.topology, *targets_);
}

Result<BestEncoder::Trial> BestEncoder::at_step() {
  const double position = std::clamp(kStepsPerOctave * std::log2(options_.step), finest_,
                                     std::max(finest_, coarsest_ + kStepsPerOctave));
  auto trial = make_trial(position);
  if (!trial || !has_aims() || position <= finest_) return trial;
  if (context_.cancelled()) return encoding_cancelled();
  context_.report("choosing targets", 0.3);
  aim(position);
  auto again = make_trial(position);
  if (again && error_of(*again) < kDriftAllowance * error_of(*trial)) return again;
  return trial;
}

Result<std::optional<std::pair<BestEncoder::Trial, double>>> BestEncoder::look_quickly() const {
  const double log_target = std::log(static_cast<double>(options_.target_bytes));
  const double fineness = 8 + (log_target / std::log(2.0) - kUsualLog2Bytes) / kUsualPerOctave;
  double position = kStepsPerOctave * (std::log2(extent_) - fineness);
  for (int i = 0; i < kQuickLooks; ++i) {
    if (context_.cancelled()) return encoding_cancelled();
    if (!(position > finest_ && position < coarsest_)) break;
    auto trial = make_trial(position);
    if (!trial) return trial.error();
    const double excess = trial->log_size() - log_target;
    position += excess / kLogSizePerPosition;
    if (std::abs(excess) < kNearEnough)
      return std::optional(std::pair(std::move(*trial), position));
  }
  return std::optional<std::pair<Trial, double>>();
}

Result<std::optional<BestEncoder::Trial>> BestEncoder::close_in(double position) const {
  // A little below the target, for sizes are not smooth.
  const double aim = std::log(static_cast<double>(options_.target_bytes)) +
                     std::log1p(-0.5 * effort_.unused_share);
  std::optional<Trial> best;
  std::optional<std::pair<double, double>> fine, coarse;  // position and ln(bytes) of the nearest
  for (int i = 0; i < kQuickTrials && !(best && is_close(*best, effort_.unused_share)); ++i) {
    if (context_.cancelled()) return encoding_cancelled();
    position = std::clamp(position, finest_, coarsest_);
    if ((fine && fine->first == position) || (coarse && coarse->first == position)) break;
    auto trial = make_trial(position);
    if (!trial) return trial.error();
    const std::pair now(trial->position, trial->log_size());
    (fits(*trial) ? coarse : fine) = now;
    if (fits(*trial) && (!best || trial->bytes.size() > best->bytes.size()))
      best = std::move(*trial);
    double slope = -kLogSizePerPosition;
    if (fine && coarse) {
      if (coarse->first - fine->first < 1e-3) break;
      slope = (coarse->second - fine->second) / (coarse->first - fine->first);
    }
    position = now.first + (aim - now.second) / std::min(slope, -1e-6);
    if (fine && coarse) {
      const double gap = coarse->first - fine->first;
      position = std::clamp(position, fine->first + 0.1 * gap, coarse->first - 0.1 * gap);
    }
    context_.report("choosing steps", std::min(0.95, (i + 3.0) / 9));
  }
  return best;
}

Result<std::optional<BestEncoder::Trial>> BestEncoder::quickly() {
  auto look = look_quickly();
  if (!look) return look.error();
  if (!*look) return std::optional<Trial>();
  auto& [trial, position] = **look;
  aim(position);
  auto again = close_in(position - kSavedByTargets);
  if (!again || !*again) {
    targets_.reset();
    return again;
  }
  if (!is_close(**again, effort_.unused_share)) {  // sizes jump here
    const double guess = (*again)->position - kStepsPerOctave / 8.0;
    auto rest = search(std::move(**again), effort_.unused_share, guess);
    if (!rest) return rest.error();
    *again = std::move(*rest);
  }
  // As in within_target(), but of files whose sizes differ.
  const double longer = std::log(static_cast<double>(options_.target_bytes)) - trial.log_size();
  if (error_of(**again) < kDriftAllowance * error_of(trial) * std::exp(kErrorPerSize * longer))
    return again;
  targets_.reset();
  return std::optional<Trial>();
}

Result<BestEncoder::Trial> BestEncoder::aimed(double position, int coarser_base) {
  aim(position, coarser_base);
  if (context_.cancelled()) return encoding_cancelled();
  auto smallest = make_trial(coarsest_ + kStepsPerOctave);
  if (!smallest) return smallest.error();
  return search(std::move(*smallest), effort_.unused_share, position);
}

Result<BestEncoder::Trial> BestEncoder::within_target() {
  if (effort_.is_quick && has_aims()) {
    auto quick = quickly();
    if (!quick) return quick.error();
    if (*quick) return std::move(**quick);
  }
  auto smallest = make_trial(coarsest_ + kStepsPerOctave);
  if (!smallest) return smallest.error();
  if (!fits(*smallest)) return base_too_large(smallest->bytes.size(), options_.target_bytes);
  auto trial = search(*smallest, has_aims() ? effort_.first_unused_share : effort_.unused_share);
  if (!trial || !has_aims() || trial->position <= finest_) return trial;
  auto again = aimed(trial->position, kCoarserBase);
  if (again && !is_close(*again, kJump)) {
    auto targets = targets_;
    auto normals = weights_->normals;
    auto finer = aimed(trial->position, kCoarserBase - kFinerBase);
    if (!finer) return finer.error();
    if (fits(*finer) && is_better(*finer, *again)) {
      again = std::move(finer);
    } else {
      targets_ = std::move(targets);
      weights_->normals = std::move(normals);
    }
  }
  if (!again) return again.error();
  // A base that lies on its grid may take more than one that is only rounded to it.
  if (fits(*again) && error_of(*again) < kDriftAllowance * error_of(*trial)) return again;
  targets_.reset();
  const double guess = trial->position;
  return search(std::move(*trial), effort_.unused_share, guess);
}

Result<Encoded> BestEncoder::run() {
  auto trial = options_.step > 0 ? at_step() : within_target();
  if (!trial) return trial.error();
  EncodeReport report = describe(prepared_, trial->coded, trial->bytes.size());
  report.lambda = -trial->lambda;
  report.predicted_distortion = trial->coded.error;
  for (std::size_t j = 0; j < report.bands.size(); ++j) report.bands[j].gain = gains_[j + 1];
  auto encoded = verified(prepared_, std::move(report), std::move(trial->bytes));
  if (encoded && trial->has_targets) encoded->targets = std::move(*targets_);
  return encoded;
}

}  // namespace

std::vector<double> best_gains(const Prepared& prepared) {
  auto gains = wavelet::regular_gains(prepared.topology.level_count(), prepared.transform).energy;
  for (double& energy : gains) energy = std::pow(energy, kGainPower);
  return gains;
}

Result<Encoded> encode_best(const SemiRegularMesh& mesh, const EncodeOptions& options,
                            const RunContext& context, const Prepared& prepared) {
  return BestEncoder(mesh, options, context, prepared).run();
}

}  // namespace nacre::codec
