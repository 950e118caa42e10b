// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/best_coder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "base/parallel.h"
#include "codec/choose_positions.h"

namespace nacre::codec {
namespace {

using entropy::DetailPoint;

/// Whether a detail of the mesh itself is more than rounding away from its normal.
bool is_vector(const Vec3& detail) {
  constexpr double kRounding = 1e-6;
  return std::max(std::abs(detail[1]), std::abs(detail[2])) > kRounding * norm(detail);
}

constexpr double kCostUnit = 1.0 / 4096;  // of DetailEncoder's costs, in bits

/// A detail's normal may be this far from the surface's for its length to be taken from where it
/// meets the surface's tangent plane; the cosine.
constexpr double kLeastSlope = 0.75;

/// What choosing one band's integers needs.
struct BandJob {
  std::span<const Vec3> details;
  double step = 1, tangential_step = 1;
  double lambda = 0;                ///< squared error of the band that one bit is worth
  std::span<const double> weights;  ///< of each detail's squared error; empty: all 1
  bool has_tangential = false;

  [[nodiscard]] double lambda_of(std::size_t e) const {
    return weights.empty() ? lambda : lambda / weights[e];
  }
};

/// Among the nearest integer, the one below it, and zero: the least error + lambda * bits.
std::int32_t choose_normal(entropy::DetailEncoder& encoder, const entropy::DetailContext& context,
                           double detail, double step, double lambda) {
  const double x = std::min(std::abs(detail) / step, double{entropy::kMaxDetail});
  const auto nearest = static_cast<std::int32_t>(x + 0.5);
  if (nearest == 0) return 0;
  std::int32_t best = 0;
  double least = 0;
  for (const std::int32_t q : {nearest, nearest - 1, 0}) {
    const std::int32_t value = detail < 0 ? -q : q;
    const double bits = kCostUnit * static_cast<double>(encoder.normal_cost(context, value));
    const double loss = (x - q) * (x - q) * step * step + lambda * bits;
    if (q == nearest || loss < least) {
      least = loss;
      best = value;
    }
    if (q == 0) break;
  }
  return best;
}

/// Each tangential component at its nearest integer or zero.
DetailPoint choose_tangential(entropy::DetailEncoder& encoder,
                              const entropy::DetailContext& context, const Vec3& detail,
                              std::int32_t normal, const BandJob& job) {
  std::array<std::int32_t, 2> nearest{};
  std::array<double, 2> x{};
  for (std::size_t i = 0; i < 2; ++i) {
    x[i] = std::clamp(detail[static_cast<int>(i) + 1] / job.tangential_step,
                      -double{entropy::kMaxDetail}, double{entropy::kMaxDetail});
    nearest[i] = static_cast<std::int32_t>(std::lround(x[i]));
  }
  DetailPoint best = {normal, 0, 0};
  if (nearest[0] == 0 && nearest[1] == 0) return best;
  double least = 0;
  for (unsigned choice = 0; choice < 4; ++choice) {
    DetailPoint point = {normal, 0, 0};
    double loss = 0;
    bool is_new = true;
    for (std::size_t i = 0; i < 2; ++i) {
      if ((choice >> i & 1u) != 0) {
        point[1 + i] = nearest[i];
        is_new &= nearest[i] != 0;
      }
      const double error = (x[i] - point[1 + i]) * job.tangential_step;
      loss += error * error;
    }
    if (!is_new) continue;
    loss += job.lambda_of(context.detail) * kCostUnit *
            static_cast<double>(encoder.tangential_cost(context, point));
    if (choice == 0 || loss < least) {
      least = loss;
      best = point;
    }
  }
  return best;
}

std::size_t shrink_class(std::int32_t magnitude) {
  return static_cast<std::size_t>(std::min(magnitude, 3) - 1);
}

/// The reconstruction offsets with the least squared error, as entropy::DetailBand has them.
std::array<int, 3> best_shrinks(const BandJob& job, std::span<const DetailPoint> points) {
  std::array<double, 3> sum{}, count{};
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t magnitude = std::abs(points[i][k]);
      if (magnitude == 0 || magnitude >= entropy::kMaxDetail) continue;
      const double step = k == 0 ? job.step : job.tangential_step;
      const double weight = step * step / (job.step * job.step);
      const double x = job.details[i][static_cast<int>(k)] / step;
      sum[shrink_class(magnitude)] += weight * (magnitude - (points[i][k] < 0 ? -x : x));
      count[shrink_class(magnitude)] += weight;
    }
  }
  std::array<int, 3> shrinks{};
  for (std::size_t i = 0; i < 3; ++i) {
    if (count[i] == 0) continue;
    const auto nearest = static_cast<int>(std::lround(32 * sum[i] / count[i]));
    shrinks[i] = std::clamp(nearest, entropy::kLeastShrink, entropy::kMostShrink);
  }
  return shrinks;
}

std::array<double, 3> as_steps(const std::array<int, 3>& shrinks) {
  return {shrinks[0] / 32.0, shrinks[1] / 32.0, shrinks[2] / 32.0};
}

/// A quiet zone is opened where a detail promises to be worth this many bits.
constexpr double kRiseBits = 14;

/// Whether any of a block's details that are quiet, or may have tangential parts, is worth it.
std::pair<bool, bool> opens(const BandJob& job, std::uint32_t first, std::uint64_t active) {
  const auto gain = [&](double x, double step) {
    const double size = std::abs(x) / step, rest = size - std::floor(size + 0.5);
    return (size * size - rest * rest) * step * step;
  };
  std::pair<bool, bool> open = {false, false};
  const auto end = std::min<std::size_t>(first + entropy::kBlockDetails, job.details.size());
  for (std::size_t e = first; e < end; ++e) {
    const Vec3& d = job.details[e];
    const double least = job.lambda_of(e) * kRiseBits;
    if ((active >> (e - first) & 1) == 0 && std::abs(d[0]) >= 0.5 * job.step)
      open.first |= gain(d[0], job.step) > least;
    if (!job.has_tangential) continue;
    open.second |= gain(d[1], job.tangential_step) + gain(d[2], job.tangential_step) > least;
  }
  return open;
}

/// Codes a band into `model`; an empty payload, and a model without it, if leaving it out is
/// better.
CodedBand code_band(const BandJob& job, const entropy::BandPlace& place, int ratio_quarters,
                    entropy::DetailModel& model) {
  entropy::DetailModel before = model;
  entropy::DetailEncoder encoder(model, place, job.has_tangential, ratio_quarters);
  std::vector<DetailPoint> points(job.details.size(), DetailPoint{0, 0, 0});
  std::size_t tangential = 0;
  bool moves = false;
  for (std::uint32_t e = 0; e < points.size(); ++e) {
    if (e % entropy::kBlockDetails == 0) {
      const std::uint32_t block = e / entropy::kBlockDetails;
      const auto open = opens(job, e, encoder.active(block));
      moves = open.second;
      encoder.begin_block(block, open.first, moves);
    }
    const Vec3& detail = job.details[e];
    const auto context = encoder.look(e);
    if (!encoder.is_open(context)) continue;
    DetailPoint& point = points[e];
    if (encoder.normal_is_open(context))
      point[0] = choose_normal(encoder, context, detail[0], job.step, job.lambda_of(e));
    if (moves) point = choose_tangential(encoder, context, detail, point[0], job);
    if (point[1] != 0 || point[2] != 0) ++tangential;
    encoder.put(context, point);
  }
  CodedBand band;
  const auto shrinks = best_shrinks(job, points);
  const double ratio = job.tangential_step / job.step;
  band.payload = encoder.finish(shrinks);
  band.decoded = quant::dequantize(points, job.step, ratio, as_steps(shrinks));
  band.distortion = mean_squared_difference(job.details, band.decoded);
  band.normal_only_fraction =
      1 - static_cast<double>(tangential) / static_cast<double>(points.size());

  const std::vector<Vec3> zeros(points.size(), Vec3::Zero());
  const double nothing = mean_squared_difference(job.details, zeros);
  const double saved = (nothing - band.distortion) * static_cast<double>(points.size());
  const double bits = 8.0 * static_cast<double>(band.payload.size() + 4);
  if (saved > job.lambda * bits) return band;
  model = std::move(before);
  model.skip_band(place);
  return {{}, zeros, nothing, 1};
}

}  // namespace

Result<CodedGeometry> code_best(const Prepared& prepared, const BestSettings& settings,
                                const std::vector<double>& gains) {
  CodedGeometry coded;
  coded.steps = settings.steps;
  const auto& base = settings.targets ? settings.targets->front() : prepared.pyramid.base_positions;
  const entropy::Connectivity& connectivity = prepared.connectivity.decoded;
  const double step = step_size(settings.steps[0]);
  coded.base = prepared.topology.level_count() == 0
                   ? encode_base_by_planes(base, connectivity, settings.steps[0],
                                           settings.lambda / (step * step))
                   : encode_base(base, connectivity, settings.steps[0]);
  const bool follows = prepared.transform == wavelet::Transform::kButterfly;
  const Topology& topology = prepared.topology;
  entropy::DetailModel model;
  wavelet::Synthesizer synthesizer(topology, prepared.transform);
  std::vector<Vec3> coarse = coded.base.decoded;
  int last_step = kNotCoded;
  for (int j = 0; j < topology.level_count(); ++j) {
    const auto band = static_cast<std::size_t>(j);
    std::vector<Vec3> details;
    PredictedLevel prediction;
    if (follows) {
      prediction = wavelet::predict_level(topology, j, coarse);
      details.resize(prediction.size());
      parallel_for_each_index(details.size(), [&](std::size_t i) {
        const std::size_t v = coarse.size() + i;
        const Vec3& target =
            settings.targets ? (*settings.targets)[band + 1][i] : prepared.positions[v];
        const Vec3 vector = target - prediction.point(i);
        const Frame f = prediction.frame(i);
        details[i] = to_frame(f, vector);
        if (!settings.targets || topology.level(j).edges[i].is_boundary()) return;
        // Without its tangential part, all that hangs on such a vertex would drift.
        if (is_vector(prepared.pyramid.bands[band][i])) return;
        const Vec3& n = settings.weights->normals[v];
        const double slope = dot(n, f.normal);
        if (slope < kLeastSlope) return;
        details[i] = {dot(n, vector) / slope, 0, 0};
      });
    } else {
      details = prepared.pyramid.bands[band];
    }
    const int step_index = settings.steps[band + 1];
    const entropy::BandPlace place{
        &topology.level(j), j > 0 ? &topology.level(j - 1) : nullptr, j,
        last_step == kNotCoded || step_index == kNotCoded ? 0 : last_step - step_index};
    if (step_index == kNotCoded) {
      model.skip_band(place);
      coded.bands.push_back(encode_band(details, kNotCoded, {}));
    } else {
      BandJob job;
      job.details = details;
      job.step = step_size(step_index);
      job.tangential_step = job.step * BandInfo{0, settings.ratio_quarters}.tangential_ratio();
      job.lambda = settings.lambda / gains[band + 1];
      if (settings.targets) job.weights = settings.weights->level_areas[band + 1];
      for (const Vec3& d : details)
        job.has_tangential |= std::max(std::abs(d[1]), std::abs(d[2])) >= 0.5 * job.tangential_step;
      coded.bands.push_back(code_band(job, place, settings.ratio_quarters, model));
    }
    last_step = coded.bands.back().payload.empty() ? kNotCoded : step_index;
    wavelet::SparseBand sparse;
    for (std::uint32_t e = 0; e < coded.bands.back().decoded.size(); ++e) {
      const Vec3& d = coded.bands.back().decoded[e];
      if (d[0] == 0 && d[1] == 0 && d[2] == 0) continue;
      sparse.edges.push_back(e);
      sparse.details.push_back(d);
    }
    if (follows)
      coarse = wavelet::with_details(std::move(prediction), sparse);
    else
      synthesizer.next_level(j, sparse, coarse);
  }
  coded.error = mean_squared_difference(coarse, prepared.positions);
  coded.decoded = std::move(coarse);
  return coded;
}

}  // namespace nacre::codec
