// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

/// Probabilities that DetailModel's counters start from: stretched, in units of 32. Learnt on
/// files of 2.5 to 24 kB of five scans (elephant, rockerarm, maneki_neko, bunny, doll_face).
namespace nacre::entropy {

inline constexpr std::int8_t kNo = 99;  ///< seen too rarely: starts as any other counter
/// How many bits a start is worth.
inline constexpr std::uint32_t kStartCount = 30;

inline constexpr std::size_t kCounterStarts = 14466;
extern const std::array<std::int8_t, kCounterStarts> kStarts;

}  // namespace nacre::entropy
