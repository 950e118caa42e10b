// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

namespace nacre::entropy {

/// Probability of a single bit, learnt as its bits are seen: their mean, later with forgetting.
class AdaptiveBit {
 public:
  /// Of a 1, in 1/65536; 16 .. 65520.
  [[nodiscard]] std::uint32_t probability() const {
    return std::clamp(probability_ >> 16, kLeast, 65536 - kLeast);
  }
  /// Of `bit` being what it is, in 1/65536.
  [[nodiscard]] std::uint32_t probability_of(bool bit) const {
    return bit ? probability() : 65536 - probability();
  }
  void update(bool bit) {
    const std::int64_t target = bit ? 0xFFFFFFFF : 0;
    const std::int64_t change = (target - std::int64_t{probability_}) * 2 / (2 * count_ + 3);
    probability_ = static_cast<std::uint32_t>(std::int64_t{probability_} + change);
    count_ = std::min(count_ + 1, kLimit);
  }

 private:
  static constexpr std::uint32_t kLeast = 16;
  static constexpr std::int32_t kLimit = 160;

  std::uint32_t probability_ = 0x80000000u;  // in 1/2^32
  std::int32_t count_ = 0;
};

}  // namespace nacre::entropy
