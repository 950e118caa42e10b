// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/band_coder.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/parallel.h"
#include "codec/byte_writer.h"
#include "entropy/stack_run.h"

namespace nacre::codec {
namespace {

struct Integers {
  std::int64_t low[3], high[3];
};

Integers integer_box(std::span<const Vec3> positions, double step) {
  Integers box{};
  for (int k = 0; k < 3; ++k) {
    double low = positions[0][k], high = positions[0][k];
    for (const Vec3& p : positions) {
      low = std::min(low, p[k]);
      high = std::max(high, p[k]);
    }
    box.low[k] = std::llround(low / step);
    box.high[k] = std::llround(high / step);
  }
  return box;
}

/// The reconstruction offset with the least squared error: the mean of |q| - |x| / step over the
/// non-zero components, rounded to what the stream can say.
int best_shrink(std::span<const Vec3> details, std::span<const quant::LatticePoint> points,
                double step, double ratio) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (points[i][k] == 0) continue;
      const double x = std::abs(details[i][static_cast<int>(k)]) / (k == 0 ? step : step * ratio);
      // A clamped component says nothing about its cell.
      if (std::abs(points[i][k]) == quant::kMaxComponent) continue;
      sum += std::abs(points[i][k]) - x;
      count += 1;
    }
  }
  return count == 0 ? 0 : std::clamp(static_cast<int>(std::lround(32 * sum / count)), 0, 15);
}

}  // namespace

double mean_squared_difference(std::span<const Vec3> a, std::span<const Vec3> b) {
  if (a.empty()) return 0;
  const double sum = deterministic_sum<double>(a.size(), [&](std::size_t i) {
    const Vec3 d = a[i] - b[i];
    return dot(d, d);
  });
  return sum / static_cast<double>(a.size());
}

int nearest_step_index(double step) {
  const double index = std::round(kStepsPerOctave * std::log2(step));
  return static_cast<int>(std::clamp<double>(index, -kMaxStepIndex, kMaxStepIndex));
}

CodedBand encode_band(std::span<const Vec3> details, int step_index,
                      const BandCoderOptions& options) {
  CodedBand band;
  const auto leave_out = [&] {
    band.decoded.assign(details.size(), Vec3::Zero());
    band.distortion = mean_squared_difference(details, band.decoded);
    return band;
  };
  if (step_index == kNotCoded) return leave_out();

  const double step = step_size(step_index);
  BandInfo info{0, options.ratio_quarters};
  const auto points = quant::quantize(
      details, {step, info.tangential_ratio(), options.dead_zone, options.theta_rad});
  std::size_t normal_only = 0;
  bool any = false;
  for (const quant::LatticePoint& p : points) {
    if (p[1] == 0 && p[2] == 0) ++normal_only;
    if (p != quant::LatticePoint{0, 0, 0}) any = true;
  }
  if (!any) return leave_out();
  band.normal_only_fraction = static_cast<double>(normal_only) / static_cast<double>(points.size());

  info.shrink_32nds = best_shrink(details, points, step, info.tangential_ratio());
  band.decoded = quant::dequantize(points, step, info.tangential_ratio(), info.shrink());
  band.distortion = mean_squared_difference(details, band.decoded);

  const quant::ProductCode code = quant::to_product_code(points);
  const auto prefix = entropy::encode_stack_run(code.prefix);
  ByteWriter writer;
  writer.byte(static_cast<std::uint8_t>(info.shrink_32nds | (info.ratio_quarters << 4)));
  writer.varint(prefix.size());
  writer.append(prefix);
  writer.append(entropy::encode_stack_run(code.suffix));
  band.payload = writer.take();
  return band;
}

int grid_bits_at(std::span<const Vec3> positions, int step_index) {
  const Integers box = integer_box(positions, step_size(step_index));
  std::int64_t widest = 1;
  for (int k = 0; k < 3; ++k) widest = std::max(widest, box.high[k] - box.low[k]);
  return static_cast<int>(std::bit_width(static_cast<std::uint64_t>(widest)));
}

int step_index_for_bits(std::span<const Vec3> positions, int bits) {
  double extent = 0;
  for (int k = 0; k < 3; ++k) {
    const auto [low, high] =
        std::minmax_element(positions.begin(), positions.end(),
                            [k](const Vec3& a, const Vec3& b) { return a[k] < b[k]; });
    extent = std::max(extent, (*high)[k] - (*low)[k]);
  }
  if (extent == 0) return 0;
  // Rounding moves each end of the range by up to half a step, so start below and step up.
  int index = nearest_step_index(std::ldexp(extent, -bits)) - 2;
  index = std::max(index, -kMaxStepIndex);
  while (index < kMaxStepIndex && grid_bits_at(positions, index) > bits) ++index;
  return index;
}

CodedBase encode_base(std::span<const Vec3> positions, const entropy::Connectivity& connectivity,
                      int step_index) {
  const double step = step_size(step_index);
  const Integers box = integer_box(positions, step);
  CodedBase base;
  base.grid_bits = grid_bits_at(positions, step_index);
  for (std::size_t k = 0; k < 3; ++k) base.corner[k] = box.low[k];
  std::vector<entropy::GridPoint> grid;
  grid.reserve(positions.size());
  base.decoded.reserve(positions.size());
  for (const Vec3& p : positions) {
    entropy::GridPoint g;
    Vec3 decoded;
    for (int k = 0; k < 3; ++k) {
      const std::int64_t q = std::llround(p[k] / step);
      g[static_cast<std::size_t>(k)] = static_cast<std::int32_t>(q - box.low[k]);
      decoded[k] = static_cast<double>(q) * step;
    }
    grid.push_back(g);
    base.decoded.push_back(decoded);
  }
  base.distortion = mean_squared_difference(positions, base.decoded);
  base.payload = entropy::encode_base_positions(grid, connectivity, base.grid_bits);
  return base;
}

}  // namespace nacre::codec
