// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "entropy/arithmetic.h"
#include "entropy/binary_model.h"

/// One description of a syntax for both directions: code that is written against these two reads
/// what it would write, because it is the same code. The writer returns what it is given; the
/// reader ignores it and returns what was read.
namespace nacre::entropy {

class SymbolWriter {
 public:
  static constexpr bool kReads = false;
  int symbol(int value, AdaptiveModel& model) {
    encoder_.encode(value, model);
    return value;
  }
  std::uint32_t bits(std::uint32_t value, int count) {
    encoder_.encode_bits(value, count);
    return value;
  }
  /// A bit that is predicted; it is learnt, too.
  template <std::size_t N>
  bool bit(bool value, MixedBit<N>& mixed) {
    encoder_.encode_bit(value, mixed.probability());
    mixed.update(value);
    return value;
  }
  [[nodiscard]] bool failed() const { return false; }
  [[nodiscard]] std::vector<std::uint8_t> finish() { return encoder_.finish(); }

 private:
  ArithmeticEncoder encoder_;
};

class SymbolReader {
 public:
  static constexpr bool kReads = true;
  explicit SymbolReader(std::span<const std::uint8_t> bytes) : decoder_(bytes) {}
  int symbol(int /*value*/, AdaptiveModel& model) { return decoder_.decode(model); }
  std::uint32_t bits(std::uint32_t /*value*/, int count) { return decoder_.decode_bits(count); }
  template <std::size_t N>
  bool bit(bool /*value*/, MixedBit<N>& mixed) {
    const bool value = decoder_.decode_bit(mixed.probability());
    mixed.update(value);
    return value;
  }
  [[nodiscard]] bool failed() const { return decoder_.overrun(); }
  [[nodiscard]] bool ends_exactly() const { return decoder_.ends_exactly(); }

 private:
  ArithmeticDecoder decoder_;
};

/// Adds up what bits would cost, in 1/4096 bit, and learns nothing.
class BitPricer {
 public:
  static constexpr bool kReads = false;
  std::uint32_t bits(std::uint32_t value, int count) {
    cost_ += static_cast<std::uint32_t>(count) << 12;
    return value;
  }
  template <std::size_t N>
  bool bit(bool value, MixedBit<N>& mixed) {
    cost_ += mixed.cost(value);
    return value;
  }
  [[nodiscard]] bool failed() const { return false; }
  [[nodiscard]] std::uint32_t cost() const { return cost_; }

 private:
  std::uint32_t cost_ = 0;
};

/// `count` <= 32 equiprobable bits, most significant first, in pieces of at most 16.
template <class Io>
std::uint32_t code_long_bits(Io& io, std::uint32_t value, int count) {
  std::uint32_t result = 0;
  while (count > 0) {
    const int piece = std::min(count, 16);
    count -= piece;
    result = (result << piece) | io.bits((value >> count) & ((1u << piece) - 1), piece);
  }
  return result;
}

/// A number below 2^32 - 1: the bit length of value + 1 by `lengths` (32 symbols), less one, then
/// the bits below its leading one, equiprobable.
template <class Io>
std::uint32_t code_number(Io& io, std::uint32_t value, AdaptiveModel& lengths) {
  const int length = io.symbol(static_cast<int>(std::bit_width(value + 1)) - 1, lengths);
  const std::uint32_t lead = std::uint32_t{1} << length;
  return lead + code_long_bits(io, (value + 1) & (lead - 1), length) - 1;
}

/// A number in [0, range), each equally likely: the top 8 bits as one of an alphabet of just the
/// possible ones, the rest as bits. The result is below range for a writer only.
template <class Io>
std::uint32_t code_uniform(Io& io, std::uint32_t value, std::uint32_t range) {
  const int low_bits = std::max(0, static_cast<int>(std::bit_width(range - 1)) - 8);
  AdaptiveModel top(static_cast<int>((range - 1) >> low_bits) + 1);
  const auto high = static_cast<std::uint32_t>(io.symbol(static_cast<int>(value >> low_bits), top));
  return (high << low_bits) | code_long_bits(io, value & ((1u << low_bits) - 1), low_bits);
}

}  // namespace nacre::entropy
