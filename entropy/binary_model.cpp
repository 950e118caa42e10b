// SPDX-License-Identifier: Apache-2.0
#include "entropy/binary_model.h"

namespace nacre::entropy {
namespace {

using SquashTable = std::array<std::uint16_t, 2 * kMaxStretched + 1>;

/// By repeated multiplication with exp(-1/256) = kDecay / 2^32.
constexpr SquashTable make_squash_table() {
  constexpr std::uint64_t kDecay = 4278222805u, kOne = std::uint64_t{1} << 32;
  SquashTable table{};
  std::uint64_t e = kOne;  // exp(-x / 256) in 1/2^32
  for (std::size_t x = 0; x <= kMaxStretched; ++x) {
    const std::uint64_t p = std::min<std::uint64_t>((std::uint64_t{1} << 48) / (kOne + e), 65535);
    table[kMaxStretched - x] = static_cast<std::uint16_t>(65536 - p);
    table[kMaxStretched + x] = static_cast<std::uint16_t>(p);
    e = (e * kDecay + kOne / 2) >> 32;
  }
  return table;
}

/// Entry i: the least x with squash(x) >= 16 i + 8.
constexpr std::array<std::int16_t, 4096> make_stretch_table(const SquashTable& squash_table) {
  std::array<std::int16_t, 4096> table{};
  std::size_t x = 0;
  for (std::uint32_t i = 0; i < table.size(); ++i) {
    while (x < 2 * kMaxStretched && squash_table[x] < 16 * i + 8) ++x;
    table[i] = static_cast<std::int16_t>(static_cast<int>(x) - kMaxStretched);
  }
  return table;
}

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

constexpr std::array<std::uint32_t, tables::kCountLimit + 1> make_rate_table() {
  std::array<std::uint32_t, tables::kCountLimit + 1> table{};
  for (std::uint32_t n = 0; n < table.size(); ++n) table[n] = 131072 / (2 * n + 3);
  return table;
}

constexpr SquashTable kSquashValues = make_squash_table();

}  // namespace

namespace tables {
constinit const SquashTable kSquash = kSquashValues;
constinit const std::array<std::int16_t, 4096> kStretch = make_stretch_table(kSquashValues);
constinit const std::array<std::uint32_t, kCountLimit + 1> kRate = make_rate_table();
}  // namespace tables

std::uint32_t bit_cost(std::uint32_t probability) { return kCost[probability >> 4]; }

}  // namespace nacre::entropy
