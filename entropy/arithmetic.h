// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/result.h"

/// Integers ↔ bytes. No floating point anywhere in this folder. See README.md.
namespace nacre::entropy {

/// Adaptive frequencies of a small alphabet; encoder and decoder move in step.
class AdaptiveModel {
 public:
  /// Range 1 .. 256 symbols. `increment` sets the speed of adaptation. Starts uniform.
  explicit AdaptiveModel(int symbol_count, std::uint32_t increment = 32);
  /// Starts from given frequencies (each >= 1), e.g. ones learnt beforehand.
  AdaptiveModel(std::span<const std::uint16_t> frequencies, std::uint32_t increment);

  void update(int symbol);
  [[nodiscard]] int symbol_count() const { return static_cast<int>(frequencies_.size()); }
  [[nodiscard]] std::uint32_t total() const { return total_; }
  [[nodiscard]] std::uint32_t frequency(int symbol) const { return frequencies_[static_cast<std::size_t>(symbol)]; }
  [[nodiscard]] std::uint32_t cumulative(int symbol) const;  ///< sum of frequencies below symbol
  [[nodiscard]] int find(std::uint32_t cumulative_value) const;

 private:
  std::vector<std::uint32_t> frequencies_;
  std::uint32_t total_ = 0;
  std::uint32_t increment_ = 32;
};

/// Range coder with 32-bit state and carry propagation; the bytes are stated in docs/FORMAT.md.
class ArithmeticEncoder {
 public:
  void encode(int symbol, AdaptiveModel& model);
  /// `count` <= 16 equiprobable bits, most significant first.
  void encode_bits(std::uint32_t bits, int count);
  /// Ends the code in as few bytes as decode unambiguously; the encoder is then empty.
  [[nodiscard]] std::vector<std::uint8_t> finish();
  ArithmeticEncoder();

 private:
  void encode_interval(std::uint32_t low, std::uint32_t size, std::uint32_t total);
  void shift_low();
  std::uint64_t low_ = 0;
  std::uint32_t range_ = 0xFFFFFFFFu;
  std::uint8_t cache_ = 0;
  std::uint64_t pending_ = 0;
  bool started_ = false;
  std::vector<std::uint8_t> bytes_;
};

/// Reads past the end give zero bytes (the encoder drops trailing zeros) and are counted, so that
/// a caller with an end condition can reject a truncated payload: see overrun().
class ArithmeticDecoder {
 public:
  explicit ArithmeticDecoder(std::span<const std::uint8_t> bytes);
  [[nodiscard]] int decode(AdaptiveModel& model);
  [[nodiscard]] std::uint32_t decode_bits(int count);
  /// True once decoding needed more bytes than any encoder would have dropped, or met an interval
  /// no encoder makes: the payload is corrupt.
  [[nodiscard]] bool overrun() const { return overrun_; }

 private:
  std::uint32_t decode_target(std::uint32_t total);
  void consume(std::uint32_t low, std::uint32_t size);
  std::uint8_t next_byte();
  std::span<const std::uint8_t> bytes_;
  std::size_t position_ = 0;
  std::uint32_t range_ = 0xFFFFFFFFu;
  std::uint32_t code_ = 0;
  std::uint32_t scale_ = 0;
  bool overrun_ = false;
};

}  // namespace nacre::entropy
