// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/result.h"
#include "base/topology.h"

/// All details of a mesh ↔ one embedded code: bit planes over trees of edges. The comparator of
/// profile nmc; see README.md.
namespace nacre::entropy {

/// (normal, across, along), quantised: sign and magnitude, magnitudes cut off below their unit.
using ZerotreePoint = std::array<std::int32_t, 3>;

inline constexpr int kMaxZerotreePlanes = 30;  ///< magnitudes are below 2^30

/// Per band, one entry per edge of the band's level.
struct ZerotreeBands {
  std::vector<std::vector<ZerotreePoint>> points;
  /// Bits of a magnitude below this one are not known (they are 0 in `points`). 0 where the
  /// component is 0.
  std::vector<std::vector<std::array<std::uint8_t, 3>>> planes;
};

/// The code of bands 0 .. points.size() - 1 of `topology`, cut where it would pass `max_bytes`:
/// what is coded first says most. Empty if all is zero or fewer than 16 bytes are allowed.
[[nodiscard]] std::vector<std::uint8_t> encode_zerotree(
    const Topology& topology, std::span<const std::vector<ZerotreePoint>> points,
    std::size_t max_bytes);

/// What a code says of `band_count` >= 1 bands; an empty one says that all is zero.
///
/// Errors   kCorruptStream if the payload is not a whole code of encode_zerotree().
[[nodiscard]] Result<ZerotreeBands> decode_zerotree(std::span<const std::uint8_t> payload,
                                                    const Topology& topology, int band_count);

}  // namespace nacre::entropy
