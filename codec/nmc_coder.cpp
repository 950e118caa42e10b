// SPDX-License-Identifier: GPL-3.0-or-later
//
// Read me first: the code is embedded, so no step is searched for: planes start above the largest
// coefficient and end where the bytes do. Only the grid of the base is, as it has to fit how far
// the planes get. Details are open loop, in the frames of the decoded mesh; since all bands are cut
// at once, these come from the round before, and settle coarse to fine.
#include "codec/nmc_coder.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "codec/assemble.h"
#include "codec/byte_writer.h"
#include "codec/comparators.h"

namespace nacre::codec {
namespace {

constexpr int kPlanes = 28;
/// Tangential step / step, in quarters above 1. [KhodakovskySchroderSweldens2000] has 4.
constexpr int kRatioQuarters = 12;
/// Rounds of one base grid, and moves of the grid's step that are tried after the first.
constexpr int kFrameRounds = 3;
constexpr std::array<int, 4> kBaseMoves = {24, 12, 6, 3};

using Bands = std::vector<std::vector<Vec3>>;

std::size_t varint_bytes(std::uint64_t value) {
  std::size_t count = 1;
  for (; value >= 0x80; value >>= 7) ++count;
  return count;
}

struct Trial {
  CodedGeometry coded;
  std::vector<std::uint8_t> bytes;
  std::vector<Vec3> positions;
  double mean_plane = kPlanes;  ///< of the normal components found
};

class NmcEncoder {
 public:
  NmcEncoder(const SemiRegularMesh& mesh, const EncodeOptions& options, const RunContext& context,
             const Prepared& prepared);

  Result<Encoded> run();

 private:
  [[nodiscard]] int level_count() const { return prepared_.topology.level_count(); }
  [[nodiscard]] Bands details_in(const std::vector<Vec3>& coarse) const;
  [[nodiscard]] std::vector<std::vector<entropy::ZerotreePoint>> quantize(
      const Bands& details) const;
  [[nodiscard]] std::size_t room_for_code(const CodedGeometry& coded) const;
  Result<Trial> make_trial(int base_step, const Bands& details) const;
  Result<void> code_details(const Bands& details, std::size_t max_bytes, Trial& trial) const;
  /// Rounds at one base grid; `positions` are those whose frames the first one takes.
  Result<Trial> settle(int base_step, std::vector<Vec3> positions, int rounds) const;
  [[nodiscard]] int clamp_base(double step_index) const;
  [[nodiscard]] EncodeReport report(const Trial& trial) const;

  const SemiRegularMesh& mesh_;
  const EncodeOptions& options_;
  const RunContext& context_;
  const Prepared& prepared_;
  int finest_base_ = 0, coarsest_base_ = 0;
  int step_index_ = 0;  ///< of the finest band, at plane 0
  bool has_details_ = false;
};

NmcEncoder::NmcEncoder(const SemiRegularMesh& mesh, const EncodeOptions& options,
                       const RunContext& context, const Prepared& prepared)
    : mesh_(mesh), options_(options), context_(context), prepared_(prepared) {
  const auto& base = prepared.pyramid.base_positions;
  const int bits = options.base_bits;
  coarsest_base_ = step_index_for_bits(base, bits == 0 ? kMinBaseBits : bits);
  finest_base_ = bits == 0 ? step_index_for_bits(base, kMaxBaseBits) : coarsest_base_;
  double largest = 0;  // in steps of the finest band
  for (int j = 0; j < level_count(); ++j) {
    const double weight =
        std::exp2(zerotree_step_offset(level_count() - 1 - j) / double{kStepsPerOctave});
    for (const Vec3& d : prepared.vectors[static_cast<std::size_t>(j)])
      largest = std::max(largest, norm(d) * weight);
  }
  has_details_ = largest > 0x1p-160;
  if (has_details_) step_index_ = nearest_step_index(largest) + 1 - kPlanes * kStepsPerOctave;
}

int NmcEncoder::clamp_base(double step_index) const {
  return std::clamp(static_cast<int>(std::lround(step_index)), finest_base_, coarsest_base_);
}

/// Details as vectors, written in the frames over given positions.
Bands NmcEncoder::details_in(const std::vector<Vec3>& positions) const {
  Bands out;
  for (int j = 0; j < level_count(); ++j) {
    const auto& vectors = prepared_.vectors[static_cast<std::size_t>(j)];
    const auto coarse = std::span(positions).first(prepared_.topology.level(j).vertex_count);
    const auto frames = wavelet::predict(prepared_.topology, j, coarse).frames;
    std::vector<Vec3> details(vectors.size());
    parallel_for_each_index(details.size(),
                            [&](std::size_t i) { details[i] = to_frame(frames[i], vectors[i]); });
    out.push_back(std::move(details));
  }
  return out;
}

std::vector<std::vector<entropy::ZerotreePoint>> NmcEncoder::quantize(const Bands& details) const {
  constexpr double kLargest = (1 << entropy::kMaxZerotreePlanes) - 1;
  std::vector<std::vector<entropy::ZerotreePoint>> out;
  for (int j = 0; j < level_count(); ++j) {
    const auto& band = details[static_cast<std::size_t>(j)];
    const double step = step_size(step_index_ - zerotree_step_offset(level_count() - 1 - j));
    const double tangential = step * (1 + kRatioQuarters * 0.25);
    std::vector<entropy::ZerotreePoint> points(band.size());
    for (std::size_t i = 0; i < band.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        const double x = std::abs(band[i][c]) / (c == 0 ? step : tangential);
        const auto magnitude = static_cast<std::int32_t>(std::min(x, kLargest));
        points[i][static_cast<std::size_t>(c)] = band[i][c] < 0 ? -magnitude : magnitude;
      }
    }
    out.push_back(std::move(points));
  }
  return out;
}

/// Bytes of a code that fills the file, beside the base and the header.
std::size_t NmcEncoder::room_for_code(const CodedGeometry& coded) const {
  const std::size_t without = assemble(prepared_, coded, Profile::kNmc, mesh_.origin).size();
  if (without >= options_.target_bytes) return 0;
  const std::int64_t delta = step_index_ - coded.steps[0] - kStepsPerOctave;
  const std::size_t all = options_.target_bytes - without, head = varint_bytes(zigzag(delta));
  std::size_t payload = all;
  while (payload > 0 && payload + checksum_bytes(payload) + varint_bytes(payload) + head > all)
    --payload;
  return payload;
}

/// The centres with the least squared error, weighted as the bands are.
std::array<int, 2> best_centres(const std::vector<std::vector<entropy::ZerotreePoint>>& points,
                                const entropy::ZerotreeBands& decoded) {
  std::array<double, 2> sum{}, weight{};
  for (std::size_t j = 0; j < points.size(); ++j) {
    for (std::size_t i = 0; i < points[j].size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        const double known = std::abs(decoded.points[j][i][c]);
        if (known == 0) continue;
        const double unit = std::ldexp(1.0, decoded.planes[j][i][c]);
        const std::size_t k = known == unit ? 0 : 1;
        sum[k] += unit * (std::abs(points[j][i][c]) + 0.5 - known);
        weight[k] += unit * unit;
      }
    }
  }
  std::array<int, 2> centres = {8, 8};
  for (std::size_t k = 0; k < 2; ++k) {
    if (weight[k] > 0)
      centres[k] = std::clamp(static_cast<int>(std::lround(32 * sum[k] / weight[k])) - 8, 0, 15);
  }
  return centres;
}

Result<void> NmcEncoder::code_details(const Bands& details, std::size_t max_bytes,
                                      Trial& trial) const {
  const auto points = quantize(details);
  auto code = entropy::encode_zerotree(prepared_.topology, points, max_bytes);
  auto decoded = entropy::decode_zerotree(code, prepared_.topology, level_count());
  if (!decoded) return decoded.error();
  const ZerotreeInfo info{best_centres(points, *decoded), kRatioQuarters};
  CodedGeometry& coded = trial.coded;
  Bands bands = zerotree_details(*decoded, info, step_index_);
  double planes = 0, found = 0;
  for (std::size_t j = 0; j < bands.size(); ++j) {
    CodedBand& band = coded.bands[j];
    std::size_t normal_only = 0;
    for (std::size_t i = 0; i < bands[j].size(); ++i) {
      const auto& p = decoded->points[j][i];
      if (p[1] == 0 && p[2] == 0) ++normal_only;
      if (p[0] == 0) continue;
      planes += decoded->planes[j][i][0];
      found += 1;
    }
    band.normal_only_fraction =
        static_cast<double>(normal_only) / static_cast<double>(bands[j].size());
    band.decoded = std::move(bands[j]);
    band.distortion = mean_squared_difference(details[j], band.decoded);
  }
  if (found > 0) trial.mean_plane = planes / found;
  if (code.empty()) return {};
  ByteWriter payload;
  payload.byte(static_cast<std::uint8_t>(info.centres[0] | (info.centres[1] << 4)));
  payload.byte(static_cast<std::uint8_t>(info.ratio_quarters));
  payload.append(code);
  coded.bands[0].payload = payload.take();
  return {};
}

Result<Trial> NmcEncoder::make_trial(int base_step, const Bands& details) const {
  Trial trial;
  CodedGeometry& coded = trial.coded;
  coded.steps = {base_step};
  coded.base =
      encode_base(prepared_.pyramid.base_positions, prepared_.connectivity.decoded, base_step);
  for (const auto& band : details) {
    const std::vector<Vec3> zeros(band.size(), Vec3::Zero());
    coded.steps.push_back(coded.steps.size() == 1 ? step_index_ : kNotCoded);
    coded.bands.push_back({{}, zeros, mean_squared_difference(band, zeros), 1});
  }
  const std::size_t room = room_for_code(coded);
  if (has_details_ && room > 2) {
    if (const auto ok = code_details(details, room - 2, trial); !ok) return ok.error();
  }
  Pyramid decoded;
  decoded.base_positions = coded.base.decoded;
  for (const CodedBand& band : coded.bands) decoded.bands.push_back(band.decoded);
  auto positions = wavelet::synthesize(prepared_.topology, decoded, prepared_.transform);
  if (!positions) return positions.error();
  trial.positions = std::move(*positions);
  coded.error = mean_squared_difference(trial.positions, prepared_.positions);
  trial.bytes = assemble(prepared_, coded, Profile::kNmc, mesh_.origin);
  return trial;
}

Result<Trial> NmcEncoder::settle(int base_step, std::vector<Vec3> positions, int rounds) const {
  auto best = make_trial(base_step, details_in(positions));
  if (!best) return best;
  positions = best->positions;
  for (int round = 1; round < rounds && has_details_; ++round) {
    if (context_.cancelled()) return encoding_cancelled();
    auto trial = make_trial(base_step, details_in(positions));
    if (!trial) return trial;
    positions = trial->positions;
    if (trial->coded.error < best->coded.error) *best = std::move(*trial);
  }
  return best;
}

EncodeReport NmcEncoder::report(const Trial& trial) const {
  EncodeReport report = describe(prepared_, trial.coded, trial.bytes.size());
  report.predicted_distortion = trial.coded.error;
  const auto gains = wavelet::regular_gains(level_count(), prepared_.transform);
  for (int j = 0; j < level_count(); ++j) {
    BandReport& band = report.bands[static_cast<std::size_t>(j)];
    band.gain = gains.energy[static_cast<std::size_t>(j) + 1];
    if (!trial.coded.bands[0].payload.empty())
      band.step = step_size(step_index_ - zerotree_step_offset(level_count() - 1 - j)) *
                  std::exp2(trial.mean_plane);
  }
  return report;
}

Result<Encoded> NmcEncoder::run() {
  auto smallest = make_trial(coarsest_base_, prepared_.pyramid.bands);
  if (!smallest) return smallest.error();
  if (smallest->bytes.size() > options_.target_bytes)
    return base_too_large(smallest->bytes.size(), options_.target_bytes);
  // The grid that errs as much as the planes do; then steps away from it, shorter and shorter.
  Trial best = std::move(*smallest);
  const auto keep_better = [&](Result<Trial> trial) -> Result<bool> {
    if (!trial) return trial.error();
    const bool better =
        trial->bytes.size() <= options_.target_bytes && trial->coded.error < best.coded.error;
    if (better) best = std::move(*trial);
    return better;
  };
  for (int round = 0; round < 2; ++round) {
    const double matched =
        step_index_ + kStepsPerOctave * best.mean_plane - zerotree_step_offset(level_count());
    const auto ok = keep_better(settle(clamp_base(matched), best.positions, kFrameRounds));
    if (!ok) return ok.error();
  }
  for (std::size_t i = 0; i < kBaseMoves.size() && finest_base_ < coarsest_base_; ++i) {
    context_.report("choosing the base's grid",
                    static_cast<double>(i + 1) / static_cast<double>(kBaseMoves.size() + 1));
    const int here = best.coded.steps[0];
    for (const int move : {kBaseMoves[i], -kBaseMoves[i]}) {
      const auto better = keep_better(settle(clamp_base(here + move), best.positions, 2));
      if (!better) return better.error();
      if (*better) break;
    }
  }
  EncodeReport best_report = report(best);
  return verified(prepared_, std::move(best_report), std::move(best.bytes));
}

}  // namespace

Result<Encoded> encode_nmc(const SemiRegularMesh& mesh, const EncodeOptions& options,
                           const RunContext& context, const Prepared& prepared) {
  return NmcEncoder(mesh, options, context, prepared).run();
}

}  // namespace nacre::codec
