// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

/// Probabilities of single bits, learnt in several contexts at once and mixed. Integers only.
/// A probability is that of a 1, in 1/65536; a *stretched* one is 256 ln(p / (1 - p)).
namespace nacre::entropy {

inline constexpr std::int32_t kMaxStretched = 2816;  ///< 11 in 1/256: odds of 60,000 to 1
inline constexpr std::uint32_t kLeastProbability = 2;

/// 65536 / (1 + exp(-x / 256)), x clamped to ±kMaxStretched. In 1 .. 65535.
[[nodiscard]] std::uint32_t squash(std::int32_t x);
/// The inverse of squash() in steps of 8 of its argument, 0 .. 65535.
[[nodiscard]] std::int32_t stretch(std::uint32_t probability);
/// -log2 of a probability, in 1/4096 bit, within 1 % of a bit above 1/4096 and 12.9 below it.
[[nodiscard]] std::uint32_t bit_cost(std::uint32_t probability);

/// What one context has seen: the mean of its bits, later with a fixed rate of forgetting.
struct BitCounter {
  std::uint32_t probability = 0x80000000u;  ///< in 1/2^32
  std::uint32_t count = 0;                  ///< bits seen, up to a limit; 0: not a guess yet

  void update(bool bit);
};

/// Weights of the contexts of one kind of bit, in 1/65536.
struct MixerWeights {
  static constexpr std::size_t kMaxInputs = 8;
  std::array<std::int32_t, kMaxInputs> weight{};
  std::uint32_t count = 0;  ///< bits mixed; 0: weights not set yet
};

/// One bit about to be coded: add its contexts, predict(), code it, update().
class MixedBit {
 public:
  MixedBit() = default;
  void add(BitCounter& counter) { counters_[size_++] = &counter; }
  /// A counter that has seen nothing starts from the guess of the first one of this bit.
  void predict(MixerWeights& weights);
  /// Of a bit with one context: that counter's probability as it is.
  void predict_alone();
  void update(bool bit);
  [[nodiscard]] std::uint32_t probability() const { return probability_; }
  [[nodiscard]] std::uint32_t cost(bool bit) const {
    return bit_cost(bit ? probability_ : 65536 - probability_);
  }

 private:
  std::array<BitCounter*, MixerWeights::kMaxInputs> counters_;
  std::array<std::int32_t, MixerWeights::kMaxInputs> inputs_;
  std::size_t size_ = 0;
  MixerWeights* weights_ = nullptr;
  std::uint32_t probability_ = 32768;
};

}  // namespace nacre::entropy
