// SPDX-License-Identifier: GPL-3.0-or-later
//
// Read me first: all classes of all bands are quantised at one slope. For a Laplacian of any scale
// the best entropy-coded quantiser of a slope has the same step (to 0.01 % of error + λ · rate; see
// README.md), and only its thresholds depend on the scale. So a band has one step, Δ over the root
// of its gain, and each integer is chosen by error + λ · bits with the bits of its class.
#include "codec/eqmc_coder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "base/parallel.h"
#include "codec/assemble.h"
#include "codec/byte_writer.h"
#include "codec/comparators.h"

namespace nacre::codec {
namespace {

/// λ over the squared step. At high rate a uniform quantiser loses 2 ln 2 / 12 = 0.116 of it per
/// bit; 0.09 measured 0.05 dB better than that on horse and venus at 4 and 16 kB.
constexpr double kLambda = 0.09;
/// Tangential step / step, in quarters above 1.
constexpr int kRatioQuarters = 4;
constexpr int kMaxTrials = 20;
constexpr double kUnusedShare = 1.0 / 400;
constexpr double kCostUnit = 1.0 / 4096;

struct Trial {
  double position = 0;  ///< Δ is 2^(position / 32)
  CodedGeometry coded;
  std::vector<std::uint8_t> bytes;

  [[nodiscard]] double log_size() const { return std::log(static_cast<double>(bytes.size())); }
};

/// Of the nearest integer, the next one toward zero, and zero: the least error + λ · bits.
std::int32_t choose(const entropy::EqModel::Class& statistics, double x, double lambda) {
  const double magnitude = std::min(std::abs(x), double{entropy::kMaxEqMagnitude});
  const auto nearest = static_cast<std::int32_t>(magnitude + 0.5);
  std::int32_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (const std::int32_t q : {nearest, nearest - 1, 0}) {
    if (q < 0) continue;
    const std::int32_t value = x < 0 ? -q : q;
    const double bits =
        kCostUnit * static_cast<double>(entropy::EqEncoder::cost(statistics, value));
    const double loss = (magnitude - q) * (magnitude - q) + lambda * bits;
    if (loss < least) {
      least = loss;
      best = value;
    }
  }
  return best;
}

/// Offsets with the least squared error, as entropy::EqBand has them.
std::array<int, 3> best_shrinks(const std::vector<Vec3>& scaled,
                                const std::vector<entropy::EqPoint>& points) {
  std::array<double, 3> sum{}, count{};
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::int32_t q = points[i][c];
      if (q == 0) continue;
      const auto k = static_cast<std::size_t>(std::min(std::abs(q), 3) - 1);
      const double x = scaled[i][static_cast<int>(c)];
      sum[k] += std::abs(q) - (q < 0 ? -x : x);
      count[k] += 1;
    }
  }
  std::array<int, 3> shrinks{};
  for (std::size_t k = 0; k < 3; ++k) {
    if (count[k] == 0) continue;
    const auto nearest = static_cast<int>(std::lround(32 * sum[k] / count[k]));
    shrinks[k] = std::clamp(nearest, entropy::kLeastEqShrink, entropy::kMostEqShrink);
  }
  return shrinks;
}

/// Codes a band into `model`; leaves it out, and the model without it, if it is not worth its bits.
CodedBand code_band(const std::vector<Vec3>& details, int step_index, double lambda,
                    const entropy::EqPlace& place, entropy::EqModel& model) {
  const double step = step_size(step_index), tangential = step * (1 + kRatioQuarters * 0.25);
  std::vector<Vec3> scaled(details.size());
  for (std::size_t i = 0; i < details.size(); ++i)
    scaled[i] = {details[i][0] / step, details[i][1] / tangential, details[i][2] / tangential};
  const entropy::EqModel before = model;
  entropy::EqEncoder encoder(model, place);
  entropy::EqBand quantised;
  quantised.points.resize(details.size());
  double saved = 0;  // in squared steps, each component's own
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::uint32_t e = 0; e < details.size(); ++e) {
      const double x = scaled[e][static_cast<int>(c)];
      auto& statistics = encoder.look(e, c);
      const std::int32_t q = choose(statistics, x, lambda);
      encoder.put(statistics, e, c, q);
      quantised.points[e][c] = q;
      saved += x * x - (x - q) * (x - q);
    }
  }
  quantised.shrink_32nds = best_shrinks(scaled, quantised.points);
  const std::vector<std::uint8_t> code = encoder.finish(quantised.shrink_32nds);
  CodedBand band;
  if (saved <= lambda * 8 * static_cast<double>(code.size() + 5)) {
    model = before;
    model.begin_band(place);
    band.decoded.assign(details.size(), Vec3::Zero());
  } else {
    ByteWriter payload;
    payload.byte(kRatioQuarters);
    payload.append(code);
    band.payload = payload.take();
    band.decoded = eq_details(quantised, step_index, kRatioQuarters);
    std::size_t normal_only = 0;
    for (const auto& p : quantised.points)
      if (p[1] == 0 && p[2] == 0) ++normal_only;
    band.normal_only_fraction =
        static_cast<double>(normal_only) / static_cast<double>(details.size());
  }
  band.distortion = mean_squared_difference(details, band.decoded);
  return band;
}

class EqmcEncoder {
 public:
  EqmcEncoder(const SemiRegularMesh& mesh, const EncodeOptions& options, const RunContext& context,
              const Prepared& prepared);

  Result<Encoded> run();

 private:
  /// `lambda` as kLambda.
  Result<Trial> make_trial(double position, double lambda = kLambda) const;
  /// Where sizes jump past the target from one step to the next: λ is moved, at `position`, between
  /// kLambda * `large`, where the file is too large, and kLambda * `small`, where it is not.
  Result<Trial> move_lambda(Trial best, double position, double large, double small) const;
  [[nodiscard]] bool is_close(const Trial& trial) const {
    return static_cast<double>(trial.bytes.size()) >=
           static_cast<double>(options_.target_bytes) * (1 - kUnusedShare);
  }
  /// The largest trial that fits, by dichotomy; `small` fits.
  Result<Trial> search(Trial small) const;

  const SemiRegularMesh& mesh_;
  const EncodeOptions& options_;
  const RunContext& context_;
  const Prepared& prepared_;
  std::vector<double> gains_;  ///< of the base, then the bands
  int finest_base_ = 0, coarsest_base_ = 0;
  double coarsest_ = 0;  ///< a position where nothing but the base is coded
};

EqmcEncoder::EqmcEncoder(const SemiRegularMesh& mesh, const EncodeOptions& options,
                         const RunContext& context, const Prepared& prepared)
    : mesh_(mesh),
      options_(options),
      context_(context),
      prepared_(prepared),
      gains_(wavelet::regular_gains(prepared.topology.level_count(), prepared.transform).energy) {
  const auto& base = prepared.pyramid.base_positions;
  const int bits = options.base_bits;
  coarsest_base_ = step_index_for_bits(base, bits == 0 ? kMinBaseBits : bits);
  finest_base_ = bits == 0 ? step_index_for_bits(base, kMaxBaseBits) : coarsest_base_;
  coarsest_ = coarsest_base_ + 0.5 * kStepsPerOctave * std::log2(gains_[0]);
  for (std::size_t j = 0; j < prepared.vectors.size(); ++j) {
    double largest = 0;
    for (const Vec3& d : prepared.vectors[j]) largest = std::max(largest, norm(d));
    if (largest > 0x1p-190)
      coarsest_ = std::max(
          coarsest_, kStepsPerOctave * (std::log2(largest) + 2 + 0.5 * std::log2(gains_[j + 1])));
  }
}

Result<Trial> EqmcEncoder::make_trial(double position, double lambda) const {
  if (context_.cancelled()) return encoding_cancelled();
  const auto step_of = [&](std::size_t part) {
    const double index = position - 0.5 * kStepsPerOctave * std::log2(gains_[part]);
    return static_cast<int>(std::lround(std::clamp<double>(index, -kMaxStepIndex, kMaxStepIndex)));
  };
  Trial trial;
  trial.position = position;
  CodedGeometry& coded = trial.coded;
  coded.steps = {std::clamp(step_of(0), finest_base_, coarsest_base_)};
  coded.base =
      encode_base(prepared_.pyramid.base_positions, prepared_.connectivity.decoded, coded.steps[0]);
  const Topology& topology = prepared_.topology;
  entropy::EqModel model;
  Pyramid decoded;
  decoded.base_positions = coded.base.decoded;
  std::vector<Vec3> coarse = coded.base.decoded;
  for (int j = 0; j < topology.level_count(); ++j) {
    const auto& vectors = prepared_.vectors[static_cast<std::size_t>(j)];
    const auto frames = wavelet::predict(topology, j, coarse).frames;
    std::vector<Vec3> details(vectors.size());
    parallel_for_each_index(details.size(),
                            [&](std::size_t i) { details[i] = to_frame(frames[i], vectors[i]); });
    const entropy::EqPlace place{&topology.level(j), j > 0 ? &topology.level(j - 1) : nullptr, j};
    coded.steps.push_back(step_of(static_cast<std::size_t>(j) + 1));
    coded.bands.push_back(code_band(details, coded.steps.back(), lambda, place, model));
    decoded.bands.push_back(coded.bands.back().decoded);
    auto finer = wavelet::synthesize(topology, decoded, prepared_.transform, j + 1);
    if (!finer) return finer.error();
    coarse = std::move(*finer);
  }
  coded.error = mean_squared_difference(coarse, prepared_.positions);
  trial.bytes = assemble(prepared_, coded, Profile::kEqmc, mesh_.origin);
  return trial;
}

Result<Trial> EqmcEncoder::search(Trial small) const {
  const auto target = static_cast<double>(options_.target_bytes);
  // 22 bits below the coarsest everything is coded to its last bit.
  const double finest = coarsest_ - 22.0 * kStepsPerOctave;
  std::optional<Trial> large;
  double stride = 2.0 * kStepsPerOctave;
  for (int i = 0; i < kMaxTrials; ++i) {
    if (is_close(small)) break;
    double position = 0;
    if (!large) {
      if (small.position <= finest) break;
      position = std::max(small.position - stride, finest);
    } else {
      const double gap = large->position - small.position;
      if (std::abs(gap) < 0.05) break;
      const double share = (std::log(target) - small.log_size()) /
                           std::max(large->log_size() - small.log_size(), 1e-9);
      position = small.position + gap * std::clamp(share, 0.1, 0.9);
    }
    auto trial = make_trial(position);
    if (!trial) return trial;
    if (trial->bytes.size() <= options_.target_bytes)
      small = std::move(*trial);
    else
      large = std::move(*trial);
    context_.report("choosing the step", (i + 1.0) / kMaxTrials);
  }
  if (!large) return small;
  const double finer = large->position, coarser = small.position;
  auto best = move_lambda(std::move(small), finer, 1, 1.5);
  return best ? move_lambda(std::move(*best), coarser, 0.6, 1) : best;
}

Result<Trial> EqmcEncoder::move_lambda(Trial best, double position, double large,
                                       double small) const {
  for (int i = 0; i < 6 && !is_close(best); ++i) {
    const double factor = 0.5 * (large + small);
    auto trial = make_trial(position, kLambda * factor);
    if (!trial) return trial;
    if (trial->bytes.size() > options_.target_bytes) {
      large = factor;
    } else {
      small = factor;
      if (trial->coded.error < best.coded.error) best = std::move(*trial);
    }
  }
  return best;
}

Result<Encoded> EqmcEncoder::run() {
  auto smallest = make_trial(coarsest_);
  if (!smallest) return smallest.error();
  if (smallest->bytes.size() > options_.target_bytes)
    return base_too_large(smallest->bytes.size(), options_.target_bytes);
  auto trial = search(std::move(*smallest));
  if (!trial) return trial.error();
  EncodeReport report = describe(prepared_, trial->coded, trial->bytes.size());
  report.lambda = -kLambda * std::exp2(2 * trial->position / kStepsPerOctave);
  report.predicted_distortion = trial->coded.error;
  for (std::size_t j = 0; j < report.bands.size(); ++j) report.bands[j].gain = gains_[j + 1];
  return verified(prepared_, std::move(report), std::move(trial->bytes));
}

}  // namespace

Result<Encoded> encode_eqmc(const SemiRegularMesh& mesh, const EncodeOptions& options,
                            const RunContext& context, const Prepared& prepared) {
  return EqmcEncoder(mesh, options, context, prepared).run();
}

}  // namespace nacre::codec
