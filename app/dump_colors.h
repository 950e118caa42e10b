// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

/// The colours that dumps use; sRGB.
namespace nacre::app {

using Rgb = std::array<std::uint8_t, 3>;

inline constexpr Rgb kNormalGrey = {206, 204, 198}, kBoundaryBlue = {30, 90, 220},
                     kVectorOrange = {245, 130, 10}, kFoldMagenta = {225, 0, 140},
                     kBorderDark = {35, 35, 45};

/// The fractional parts of multiples of the golden ratio: neighbours in number differ in hue.
inline double hue_of(std::size_t index) {
  const double turns = 0.618033988749895 * static_cast<double>(index);
  return turns - std::floor(turns);
}

/// Hue 0 .. 1 round the wheel; saturation and value 0 .. 1.
inline Rgb from_hsv(double hue, double saturation, double value) {
  Rgb color{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double turn = std::fmod(5.0 - 2.0 * static_cast<double>(k) + 6 * hue, 6.0);
    const double dark = std::clamp(std::min(turn, 4 - turn), 0.0, 1.0);
    color[k] = static_cast<std::uint8_t>(std::lround(255 * value * (1 - saturation * dark)));
  }
  return color;
}

}  // namespace nacre::app
