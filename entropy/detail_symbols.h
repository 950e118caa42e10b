// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "entropy/detail_coder.h"

/// A band's payload as the decisions it was made of, for who wants to see or change them.
namespace nacre::entropy {

struct BandSymbols {
  std::vector<DetailPoint> points;  ///< one per detail; empty: the band has no payload
  /// Per block of kBlockDetails: bit 0, quiet details may rise; bit 1, there may be tangential
  /// parts. Set where points need it, whatever is said here.
  std::vector<std::uint8_t> heads;
  std::array<int, 3> shrink_32nds{};  ///< as in DetailBand
  int ratio_quarters = 0;
  bool has_tangential = false;
};

/// Errors   kCorruptStream: any bytes that DetailEncoder does not write.
[[nodiscard]] Result<BandSymbols> read_band_symbols(std::span<const std::uint8_t> payload,
                                                    const BandPlace& place, DetailModel& model);

/// Ensures  the bytes are those that the symbols were read from, if nothing was changed; a band of
///          zeros has no payload.
/// Errors   kBadInput: not one point per detail, or one out of range.
[[nodiscard]] Result<std::vector<std::uint8_t>> write_band_symbols(const BandSymbols& band,
                                                                   const BandPlace& place,
                                                                   DetailModel& model);

}  // namespace nacre::entropy
