// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/result.h"

/// Integers ↔ bytes. No floating point anywhere in this folder. See README.md.
namespace nacre::entropy {

/// Adaptive frequencies of a small alphabet; encoder and decoder move in step.
///
/// update(s) adds `increment` to the frequency of s; then, while the total is above kMaxTotal,
/// every frequency f becomes (f + 1) / 2, rounded down. All in unsigned integers of 32 bits.
class AdaptiveModel {
 public:
  /// Frequencies are halved when their sum passes this, so range / total keeps at least 9 bits.
  static constexpr std::uint32_t kMaxTotal = 1u << 15;
  static constexpr std::uint32_t kMaxIncrement = 1u << 12;

  /// Range 1 .. 256 symbols, increment 1 .. kMaxIncrement: the speed of adaptation. Starts with
  /// frequency 1 each.
  explicit AdaptiveModel(int symbol_count, std::uint32_t increment = 32);
  /// Starts from given frequencies (each >= 1), e.g. ones learnt beforehand; halved as in update()
  /// if their sum is above kMaxTotal.
  AdaptiveModel(std::span<const std::uint16_t> frequencies, std::uint32_t increment);

  void update(int symbol);
  [[nodiscard]] int symbol_count() const { return static_cast<int>(frequencies_.size()); }
  [[nodiscard]] std::uint32_t total() const { return total_; }
  [[nodiscard]] std::uint32_t frequency(int symbol) const {
    return frequencies_[static_cast<std::size_t>(symbol)];
  }
  [[nodiscard]] std::uint32_t cumulative(int symbol) const;  ///< sum of frequencies below symbol
  /// The symbol s with cumulative(s) <= value < cumulative(s) + frequency(s); value < total().
  [[nodiscard]] int find(std::uint32_t cumulative_value) const;

 private:
  void halve_while_too_large();

  std::vector<std::uint32_t> frequencies_;
  std::uint32_t total_ = 0;
  std::uint32_t increment_ = 32;
};

/// Range coder with 32-bit range and carry propagation; the bytes are stated in docs/FORMAT.md.
///
/// Ensures  (1) for one sequence of models, no payload is a proper prefix of another: a truncated
///              or extended payload never passes ArithmeticDecoder::ends_exactly()
///          (2) coding nothing, or only certain symbols (models of one symbol), takes 0 bytes
/// Source   [Martin1979], [Schindler1998]; carry propagation as in LZMA's coder.
class ArithmeticEncoder {
 public:
  void encode(int symbol, AdaptiveModel& model);
  /// `count` <= 16 equiprobable bits, most significant first; bits < 2^count.
  void encode_bits(std::uint32_t bits, int count);
  /// A bit whose probability of being 1 is `probability` / 65536, in 1 .. 65535.
  void encode_bit(bool bit, std::uint32_t probability);
  /// Ends the code in the fewest bytes that decode to the same symbols whatever follows them; the
  /// encoder is then empty.
  [[nodiscard]] std::vector<std::uint8_t> finish();

 private:
  void encode_interval(std::uint32_t low, std::uint32_t size, std::uint32_t total);
  void shift_low();

  std::uint64_t low_ = 0;  // < 2^33; bit 32 is a carry into the bytes held back
  std::uint32_t range_ = 0xFFFFFFFFu;
  std::uint8_t cache_ = 0;     // last byte that a carry can still change ...
  std::uint64_t pending_ = 0;  // ... followed by this many 0xFF
  bool started_ = false;       // the first shift only fills the cache
  std::vector<std::uint8_t> bytes_;
};

/// Never fails on any bytes: every code value stands for some symbols. Reads past the end give zero
/// bytes. A caller loops until its own end condition or overrun(), then asks ends_exactly().
class ArithmeticDecoder {
 public:
  explicit ArithmeticDecoder(std::span<const std::uint8_t> bytes);
  [[nodiscard]] int decode(AdaptiveModel& model);
  /// `count` <= 16.
  [[nodiscard]] std::uint32_t decode_bits(int count) {
    assert(count >= 0 && count <= 16);
    const std::uint32_t total = 1u << count, bits = target(total);
    consume(bits, 1, total);
    return bits;
  }
  /// See ArithmeticEncoder::encode_bit().
  [[nodiscard]] bool decode_bit(std::uint32_t probability) {
    const auto split = static_cast<std::uint32_t>((std::uint64_t{range_} * probability) >> 16);
    const bool bit = code_ < split;
    code_ -= bit ? 0 : split;
    range_ = bit ? split : range_ - split;
    while (range_ < kMinRange) {
      range_ <<= 8;
      read_byte();
    }
    return bit;
  }

  /// True once the payload is known to be corrupt: the decoder is more bytes past the end than its
  /// 4 bytes of look-ahead, or the first 4 bytes are 0xFF. Stays true.
  [[nodiscard]] bool overrun() const { return overrun_; }
  /// After the last symbol: the payload is byte for byte the one that ArithmeticEncoder::finish()
  /// writes for the symbols decoded. False after overrun().
  [[nodiscard]] bool ends_exactly() const;

 private:
  static constexpr std::uint32_t kMinRange = 1u << 24;
  static constexpr std::size_t kLookAhead = 4;

  [[nodiscard]] std::uint32_t target(std::uint32_t total) {
    unit_ = range_ / total;
    return std::min(code_ / unit_, total - 1);
  }
  void consume(std::uint32_t low, std::uint32_t size, std::uint32_t total) {
    code_ -= unit_ * low;
    range_ = low + size == total ? range_ - unit_ * low : unit_ * size;
    while (range_ < kMinRange) {
      range_ <<= 8;
      read_byte();
    }
  }
  void read_byte() {
    const std::uint32_t byte = position_ < bytes_.size() ? bytes_[position_] : 0u;
    ++position_;
    if (position_ > bytes_.size() + kLookAhead) overrun_ = true;
    window_ = (window_ << 8) | byte;
    code_ = (code_ << 8) | byte;
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t position_ = 0;  // bytes read, those past the end included
  std::uint32_t range_ = 0xFFFFFFFFu;
  std::uint32_t unit_ = 0;    // range / total of the symbol being decoded
  std::uint32_t code_ = 0;    // code value - low, always < range_
  std::uint32_t window_ = 0;  // the last 4 bytes read
  bool overrun_ = false;
};

}  // namespace nacre::entropy
