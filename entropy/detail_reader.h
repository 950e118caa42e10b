// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "entropy/arithmetic.h"
#include "entropy/detail_syntax.h"

/// The decoder's side of detail_syntax.h, for the two that read a band: details alone, or every
/// decision.
namespace nacre::entropy {

/// A Coder of detail_syntax.h.
struct DetailReader {
  ArithmeticDecoder decoder;

  template <class Bit>
  bool bit(Bit mixed, bool) {
    const bool value = decoder.decode_bit(mixed.probability());
    mixed.update(value);
    return value;
  }
  std::uint32_t raw(int count, std::uint32_t) { return decoder.decode_bits(count); }
};

/// What stands before the first block.
struct BandHead {
  bool has_tangential = false;
  int ratio_quarters = 0;
};
inline BandHead read_band_head(DetailReader& reader) {
  BandHead head;
  head.has_tangential = reader.raw(1, 0) != 0;
  if (head.has_tangential) head.ratio_quarters = static_cast<int>(reader.raw(kRatioBits, 0));
  return head;
}

/// What stands behind the last block.
inline std::array<int, 3> read_shrinks(DetailReader& reader) {
  std::array<int, 3> shrinks{};
  for (int& shrink : shrinks) shrink = static_cast<int>(reader.raw(kShrinkBits, 0)) - kShrinkZero;
  return shrinks;
}

}  // namespace nacre::entropy
