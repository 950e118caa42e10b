// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "base/geometry.h"

namespace nacre::data {

/// Random numbers that are functions of where they are used, so that no order of evaluation and no
/// standard library's distribution can change them.
struct Random {
  std::uint64_t seed = 0;

  [[nodiscard]] std::uint64_t bits(std::uint64_t stream, std::uint64_t index) const {
    std::uint64_t z = seed + 0x9E3779B97F4A7C15ULL * (index + 1) + 0xD1B54A32D192ED03ULL * stream;
    for (int round = 0; round < 2; ++round) {
      z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
      z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
      z ^= z >> 31;
    }
    return z;
  }
  /// In [0, 1).
  [[nodiscard]] double uniform(std::uint64_t stream, std::uint64_t index) const {
    return static_cast<double>(bits(stream, index) >> 11) * 0x1p-53;
  }
  /// Mean 0, variance 1, within ±6: the sum of twelve uniforms.
  [[nodiscard]] double gaussian(std::uint64_t stream, std::uint64_t index) const {
    double sum = -6;
    for (std::uint64_t k = 0; k < 12; ++k) sum += uniform(stream, 12 * index + k);
    return sum;
  }
  [[nodiscard]] Vec3 gaussian3(std::uint64_t stream, std::uint64_t index) const {
    return {gaussian(stream, 3 * index), gaussian(stream, 3 * index + 1),
            gaussian(stream, 3 * index + 2)};
  }
  [[nodiscard]] Vec3 direction(std::uint64_t stream, std::uint64_t index) const {
    const Vec3 g = gaussian3(stream, index);
    return g / (norm(g) + 1e-12);
  }
};

}  // namespace nacre::data
