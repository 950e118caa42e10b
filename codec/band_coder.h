// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/geometry.h"
#include "codec/stream_format.h"
#include "entropy/connectivity.h"
#include "quant/quant.h"

/// One part of the geometry at one step: what it costs and what it loses.
namespace nacre::codec {

/// Step index of a band that is not coded: all its details decode to zero.
inline constexpr int kNotCoded = 1 << 20;

struct BandCoderOptions {
  double dead_zone = 0.6;
  double theta_rad = 0.0174532925199432957692;
  int ratio_quarters = 0;  ///< see BandInfo
};

struct CodedBand {
  std::vector<std::uint8_t> payload;  ///< empty if every detail is quantised to zero
  std::vector<Vec3> decoded;          ///< the details as the decoder will have them
  double distortion = 0;              ///< mean squared error per vertex
  double normal_only_fraction = 1;    ///< quantised details without tangential part
};

[[nodiscard]] CodedBand encode_band(std::span<const Vec3> details, int step_index,
                                    const BandCoderOptions& options);

struct CodedBase {
  std::vector<std::uint8_t> payload;
  std::vector<Vec3> decoded;
  double distortion = 0;  ///< mean squared error per vertex
  int grid_bits = 0;
  std::array<std::int64_t, 3> corner = {0, 0, 0};
};

/// Base positions rounded to multiples of a step, as grid coordinates from their lowest corner.
[[nodiscard]] CodedBase encode_base(std::span<const Vec3> positions,
                                    const entropy::Connectivity& connectivity, int step_index);

/// The bits encode_base() would need per coordinate at this step; may exceed kMaxGridBits.
[[nodiscard]] int grid_bits_at(std::span<const Vec3> positions, int step_index);

/// The finest step at which encode_base() needs at most `bits` per coordinate.
[[nodiscard]] int step_index_for_bits(std::span<const Vec3> positions, int bits);

/// Index of the step nearest to `step` > 0, clamped to the range of the format.
[[nodiscard]] int nearest_step_index(double step);

/// Mean over i of |a[i] - b[i]|², summed in a fixed order.
[[nodiscard]] double mean_squared_difference(std::span<const Vec3> a, std::span<const Vec3> b);

}  // namespace nacre::codec
