// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/geometry.h"

namespace nacre {

/// SplitMix64: the same numbers on every machine.
class TestRandom {
 public:
  explicit TestRandom(std::uint64_t seed) : state_(seed) {}
  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }
  /// 0 .. bound - 1
  std::uint32_t below(std::size_t bound) {
    return static_cast<std::uint32_t>(bits() % static_cast<std::uint64_t>(bound));
  }
  /// [0, 1)
  double unit() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  double signed_unit() { return 2 * unit() - 1; }
  Vec3 point() {
    const double x = signed_unit(), y = signed_unit();
    return {x, y, signed_unit()};
  }
  Vec3 direction() {
    while (true) {
      const Vec3 p = point();
      const double length = p.norm();
      if (length > 0.1 && length < 1) return p / length;
    }
  }
  std::vector<std::uint32_t> permutation(std::size_t count) {
    std::vector<std::uint32_t> out(count);
    for (std::uint32_t i = 0; i < count; ++i) {
      out[i] = i;
      std::swap(out[i], out[below(i + 1)]);
    }
    return out;
  }

 private:
  std::uint64_t state_;
};

}  // namespace nacre
