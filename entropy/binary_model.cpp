// SPDX-License-Identifier: Apache-2.0
#include "entropy/binary_model.h"

#include <algorithm>

namespace nacre::entropy {
namespace {

constexpr std::size_t kTableSize = static_cast<std::size_t>(kMaxStretched) + 1;
/// A counter's rate falls to 1 / (kCountLimit + 1.5).
constexpr std::uint32_t kCountLimit = 200;
/// The mixer's rate falls from kFirstRate to kLastRate by 1 every 16 bits.
constexpr std::uint32_t kFirstRate = 14, kLastRate = 3;
constexpr int kRateShift = 18;

/// squash(0 .. kMaxStretched), by repeated multiplication with exp(-1/256) = kDecay / 2^32.
constexpr std::array<std::uint16_t, kTableSize> make_squash_table() {
  constexpr std::uint64_t kDecay = 4278222805u, kOne = std::uint64_t{1} << 32;
  std::array<std::uint16_t, kTableSize> table{};
  std::uint64_t e = kOne;  // exp(-x / 256) in 1/2^32
  for (std::uint16_t& entry : table) {
    entry = static_cast<std::uint16_t>(
        std::min<std::uint64_t>((std::uint64_t{1} << 48) / (kOne + e), 65535));
    e = (e * kDecay + kOne / 2) >> 32;
  }
  return table;
}

constexpr auto kSquash = make_squash_table();

constexpr std::uint32_t look_up_squash(std::int32_t x) {
  if (x >= 0) return kSquash[static_cast<std::size_t>(std::min(x, kMaxStretched))];
  return 65536u - kSquash[static_cast<std::size_t>(std::min(-x, kMaxStretched))];
}

/// Entry i: the least x with squash(x) >= 8 i + 4.
constexpr std::array<std::int16_t, 8192> make_stretch_table() {
  std::array<std::int16_t, 8192> table{};
  std::int32_t x = -kMaxStretched;
  for (std::uint32_t i = 0; i < table.size(); ++i) {
    while (x < kMaxStretched && look_up_squash(x) < 8 * i + 4) ++x;
    table[i] = static_cast<std::int16_t>(x);
  }
  return table;
}

constexpr auto kStretch = make_stretch_table();

/// Entry i: 4096 log2(65536 / (16 i + 8)), digit by digit.
constexpr std::array<std::uint32_t, 4096> make_cost_table() {
  std::array<std::uint32_t, 4096> table{};
  for (std::uint32_t i = 0; i < table.size(); ++i) {
    std::uint64_t mantissa = 16 * i + 8;
    std::uint32_t whole = 0, fraction = 0;
    for (; mantissa < 65536; mantissa <<= 1) ++whole;
    mantissa <<= 15;
    for (std::uint32_t digit = 1u << 11; digit > 0; digit >>= 1) {
      mantissa = (mantissa * mantissa) >> 31;
      if ((mantissa >> 32) == 0) continue;
      mantissa >>= 1;
      fraction |= digit;
    }
    table[i] = whole * 4096 - fraction;
  }
  return table;
}

constexpr auto kCost = make_cost_table();

/// 65536 / (n + 3/2), rounded down.
constexpr std::array<std::uint32_t, kCountLimit + 1> make_rate_table() {
  std::array<std::uint32_t, kCountLimit + 1> table{};
  for (std::uint32_t n = 0; n < table.size(); ++n) table[n] = 131072 / (2 * n + 3);
  return table;
}

constexpr auto kRate = make_rate_table();

}  // namespace

std::uint32_t squash(std::int32_t x) { return look_up_squash(x); }
std::int32_t stretch(std::uint32_t probability) { return kStretch[probability >> 3]; }
std::uint32_t bit_cost(std::uint32_t probability) { return kCost[probability >> 4]; }

void BitCounter::update(bool bit) {
  const std::int64_t target = bit ? 0xFFFFFFFFll : 0;
  const std::int64_t change = (target - static_cast<std::int64_t>(probability)) * kRate[count];
  // Rounded toward zero, so that the probability stays inside its range.
  probability = static_cast<std::uint32_t>(static_cast<std::int64_t>(probability) + change / 65536);
  if (count < kCountLimit) ++count;
}

void MixedBit::predict(MixerWeights& weights) {
  weights_ = &weights;
  if (weights.count == 0) weights.weight.fill(65536 / static_cast<std::int32_t>(size_));
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < size_; ++i) {
    BitCounter& counter = *counters_[i];
    if (counter.count == 0 && i > 0) counter.probability = squash(inputs_[0]) << 16;
    inputs_[i] = stretch(counter.probability >> 16);
    sum += std::int64_t{weights.weight[i]} * inputs_[i];
  }
  const std::int64_t mixed = std::clamp<std::int64_t>(sum / 65536, -kMaxStretched, kMaxStretched);
  probability_ = std::clamp(squash(static_cast<std::int32_t>(mixed)), kLeastProbability,
                            65536 - kLeastProbability);
}

void MixedBit::predict_alone() {
  probability_ =
      std::clamp(counters_[0]->probability >> 16, kLeastProbability, 65536 - kLeastProbability);
}

void MixedBit::update(bool bit) {
  if (weights_ == nullptr) {
    counters_[0]->update(bit);
    return;
  }
  const std::int64_t error = (bit ? 65536 : 0) - static_cast<std::int64_t>(probability_);
  const std::uint32_t steps = std::min(weights_->count / 16, kFirstRate - kLastRate);
  const std::int64_t rate = kFirstRate - steps;
  constexpr std::int64_t kLargest = std::int64_t{1} << 20;
  for (std::size_t i = 0; i < size_; ++i) {
    const std::int64_t change = (error * inputs_[i] * rate) / (std::int64_t{1} << kRateShift);
    weights_->weight[i] =
        static_cast<std::int32_t>(std::clamp(weights_->weight[i] + change, -kLargest, kLargest));
    counters_[i]->update(bit);
  }
  if (weights_->count < 0xFFFF) ++weights_->count;
}

}  // namespace nacre::entropy
