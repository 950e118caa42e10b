// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "codec/stream_format.h"
#include "entropy/connectivity.h"
#include "entropy/detail_symbols.h"

/// A stream of profile best or paper ↔ the integers that its entropy coder was given.
namespace nacre::codec {

struct StreamSymbols {
  Header header;                           ///< lengths are those of the stream it was read from
  std::vector<std::uint8_t> connectivity;  ///< payload of the section: the base's triangles
  std::vector<entropy::GridPoint> grid;    ///< base positions: step (header.grid_corner + grid)
  /// One per band of the header. Of profile paper: points, the first shrink, and the ratio.
  std::vector<entropy::BandSymbols> bands;
};

/// Errors   kUnsupportedVersion for other profiles; else as decode().
[[nodiscard]] Result<StreamSymbols> read_symbols(std::span<const std::uint8_t> stream);

/// Ensures  write_symbols(*read_symbols(s)) == s.
/// Errors   kBadInput: counts that do not fit together or values out of range.
[[nodiscard]] Result<std::vector<std::uint8_t>> write_symbols(const StreamSymbols& symbols);

}  // namespace nacre::codec
