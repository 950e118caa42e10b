// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

/// Probabilities of single bits, learnt in several contexts at once and mixed. Integers only.
/// A probability is that of a 1, in 1/65536; a *stretched* one is 256 ln(p / (1 - p)).
/// All is inline: a decoder spends half of its time here.
namespace nacre::entropy {

inline constexpr std::int32_t kMaxStretched = 2816;  ///< 11 in 1/256: odds of 60,000 to 1
inline constexpr std::uint32_t kLeastProbability = 2;

namespace tables {
extern const std::array<std::uint16_t, 2 * kMaxStretched + 1> kSquash;  ///< by x + kMaxStretched
extern const std::array<std::int16_t, 4096> kStretch;                   ///< by probability / 16
/// 65536 / (n + 3/2), rounded down, by the count n; the last one for good.
inline constexpr std::uint32_t kCountLimit = 200;
extern const std::array<std::uint32_t, kCountLimit + 1> kRate;
}  // namespace tables

/// 65536 / (1 + exp(-x / 256)), x in ±kMaxStretched. In 1 .. 65535.
[[nodiscard]] inline std::uint32_t squash(std::int32_t x) {
  return tables::kSquash[static_cast<std::size_t>(x + kMaxStretched)];
}
/// The inverse of squash() in steps of 16 of its argument, 0 .. 65535.
[[nodiscard]] inline std::int32_t stretch(std::uint32_t probability) {
  return tables::kStretch[probability >> 4];
}
/// -log2 of a probability, in 1/4096 bit, within 1 % of a bit above 1/4096 and 12.9 below it.
[[nodiscard]] std::uint32_t bit_cost(std::uint32_t probability);

/// What one context has seen: the mean of its bits, later with a fixed rate of forgetting.
class BitCounter {
 public:
  BitCounter() = default;
  BitCounter(std::uint32_t probability, std::uint32_t count) : state_(probability << 16 | count) {}

  [[nodiscard]] std::uint32_t probability() const { return state_ >> 16; }
  /// Bits seen, up to tables::kCountLimit; 0: not a guess yet.
  [[nodiscard]] std::uint32_t count() const { return state_ & 1023u; }
  void update(bool bit) {
    const std::uint32_t n = count();
    const std::int64_t p = state_ >> 10;
    const std::int64_t target = bit ? (std::int64_t{1} << 22) - 1 : 0;
    const std::int64_t moved = p + (((target - p) * tables::kRate[n]) >> 16);
    state_ = static_cast<std::uint32_t>(moved) << 10 | (n + (n < tables::kCountLimit ? 1u : 0u));
  }

 private:
  std::uint32_t state_ = 0x80000000u;  // probability in 1/2^22; below it, 10 bits, the count
};

/// Weights of the contexts of one kind of bit, in 1/65536.
struct MixerWeights {
  static constexpr std::size_t kMaxInputs = 8;
  std::array<std::int32_t, kMaxInputs> weight{};
  std::uint32_t count = 0;  ///< bits mixed; 0: weights not set yet
};

/// One bit about to be coded with one context: its counter's probability as it is.
class SingleBit {
 public:
  explicit SingleBit(BitCounter& counter)
      : counter_(counter), probability_(limited(counter.probability())) {}

  void update(bool bit) { counter_.update(bit); }
  [[nodiscard]] std::uint32_t probability() const { return probability_; }
  [[nodiscard]] std::uint32_t cost(bool bit) const {
    return bit_cost(bit ? probability_ : 65536 - probability_);
  }

  static std::uint32_t limited(std::uint32_t probability) {
    return std::clamp(probability, kLeastProbability, 65536 - kLeastProbability);
  }

 private:
  BitCounter& counter_;
  std::uint32_t probability_;
};

/// One bit about to be coded with N contexts; the guess is there at once.
template <std::size_t N>
class MixedBit {
 public:
  /// A counter that has seen nothing starts from the guess of the first one of this bit.
  MixedBit(MixerWeights& weights, const std::array<BitCounter*, N>& counters)
      : weights_(weights), counters_(counters) {
    static_assert(N <= MixerWeights::kMaxInputs);
    if (weights.count == 0) weights.weight.fill(65536 / static_cast<std::int32_t>(N));
    std::int64_t sum = 0;
    for (std::size_t i = 0; i < N; ++i) {
      BitCounter& counter = *counters[i];
      if (i > 0 && counter.count() == 0) counter = BitCounter(squash(inputs_[0]), 0);
      inputs_[i] = stretch(counter.probability());
      sum += std::int64_t{weights.weight[i]} * inputs_[i];
    }
    const std::int64_t mixed = std::clamp<std::int64_t>(sum >> 16, -kMaxStretched, kMaxStretched);
    probability_ = SingleBit::limited(squash(static_cast<std::int32_t>(mixed)));
  }

  void update(bool bit) {
    const std::int64_t error = (bit ? 65536 : 0) - static_cast<std::int64_t>(probability_);
    const std::int64_t scaled = error * rate(weights_.count);
    for (std::size_t i = 0; i < N; ++i) {
      std::int32_t& weight = weights_.weight[i];
      weight += static_cast<std::int32_t>((inputs_[i] * scaled) >> kRateShift);
      if (std::abs(weight) > kLargest) weight = weight < 0 ? -kLargest : kLargest;  // hardly ever
    }
    for (std::size_t i = 0; i < N; ++i) counters_[i]->update(bit);
    if (weights_.count < 0xFFFF) ++weights_.count;
  }

  [[nodiscard]] std::uint32_t probability() const { return probability_; }
  [[nodiscard]] std::uint32_t cost(bool bit) const {
    return bit_cost(bit ? probability_ : 65536 - probability_);
  }

 private:
  static constexpr int kRateShift = 18;
  static constexpr std::int32_t kLargest = 1 << 20;

  /// The mixer's rate falls by 1 every 16 bits.
  static std::int64_t rate(std::uint32_t count) {
    constexpr std::uint32_t kFirst = 14, kLast = 8;
    return kFirst - std::min(count / 16, kFirst - kLast);
  }

  MixerWeights& weights_;
  std::array<BitCounter*, N> counters_;
  std::array<std::int32_t, N> inputs_;
  std::uint32_t probability_;
};

}  // namespace nacre::entropy
