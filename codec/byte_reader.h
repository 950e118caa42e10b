// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace nacre::codec {

/// Reads little-endian fields front to back. Running out of bytes, or a varint no writer makes,
/// sets failed() for good and yields zeros, so that a caller may check once after several fields.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  [[nodiscard]] bool failed() const { return failed_; }
  [[nodiscard]] std::size_t position() const { return position_; }
  [[nodiscard]] std::span<const std::uint8_t> rest() const { return bytes_.subspan(position_); }

  std::uint8_t byte() {
    if (failed_ || position_ == bytes_.size()) {
      failed_ = true;
      return 0;
    }
    return bytes_[position_++];
  }

  /// `count` <= 8 bytes, least significant first.
  std::uint64_t fixed(int count) {
    std::uint64_t value = 0;
    for (int i = 0; i < count; ++i) value |= std::uint64_t{byte()} << (8 * i);
    return value;
  }

  double float64() { return std::bit_cast<double>(fixed(8)); }

  /// 7 bits per byte, least significant first, in as few bytes as possible, below 2^63.
  std::uint64_t varint() {
    std::uint64_t value = 0;
    for (int shift = 0; shift < 63; shift += 7) {
      const std::uint8_t b = byte();
      value |= std::uint64_t{b & 0x7Fu} << shift;
      if ((b & 0x80) == 0) {
        if (b == 0 && shift > 0) failed_ = true;
        return failed_ ? 0 : value;
      }
    }
    failed_ = true;
    return 0;
  }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t position_ = 0;
  bool failed_ = false;
};

}  // namespace nacre::codec
