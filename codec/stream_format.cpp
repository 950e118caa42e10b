// SPDX-License-Identifier: Apache-2.0
#include "codec/stream_format.h"

#include <bit>
#include <cassert>
#include <limits>

namespace nacre::codec {
namespace {

/// 2^(i / 32), correctly rounded.
constexpr std::array<double, 32> kMantissas = {
    0x1.0000000000000p+0, 0x1.059b0d3158574p+0, 0x1.0b5586cf9890fp+0, 0x1.11301d0125b51p+0,
    0x1.172b83c7d517bp+0, 0x1.1d4873168b9aap+0, 0x1.2387a6e756238p+0, 0x1.29e9df51fdee1p+0,
    0x1.306fe0a31b715p+0, 0x1.371a7373aa9cbp+0, 0x1.3dea64c123422p+0, 0x1.44e086061892dp+0,
    0x1.4bfdad5362a27p+0, 0x1.5342b569d4f82p+0, 0x1.5ab07dd485429p+0, 0x1.6247eb03a5585p+0,
    0x1.6a09e667f3bcdp+0, 0x1.71f75e8ec5f74p+0, 0x1.7a11473eb0187p+0, 0x1.82589994cce13p+0,
    0x1.8ace5422aa0dbp+0, 0x1.93737b0cdc5e5p+0, 0x1.9c49182a3f090p+0, 0x1.a5503b23e255dp+0,
    0x1.ae89f995ad3adp+0, 0x1.b7f76f2fb5e47p+0, 0x1.c199bdd85529cp+0, 0x1.cb720dcef9069p+0,
    0x1.d5818dcfba487p+0, 0x1.dfc97337b9b5fp+0, 0x1.ea4afa2a490dap+0, 0x1.f50765b6e4540p+0,
};

template <class T>
constexpr std::array<T, 256> make_crc_table(T polynomial, bool reflected) {
  std::array<T, 256> table{};
  constexpr int kBits = 8 * sizeof(T);
  for (unsigned byte = 0; byte < 256; ++byte) {
    T value = static_cast<T>(reflected ? byte : byte << (kBits - 8));
    for (int bit = 0; bit < 8; ++bit) {
      if (reflected) {
        value = static_cast<T>((value >> 1) ^ ((value & 1) != 0 ? polynomial : 0));
      } else {
        const bool top = ((value >> (kBits - 1)) & 1) != 0;
        value = static_cast<T>((value << 1) ^ (top ? polynomial : 0));
      }
    }
    table[byte] = value;
  }
  return table;
}

constexpr auto kCrc16Table = make_crc_table<std::uint16_t>(0x1021, false);
constexpr auto kCrc32Table = make_crc_table<std::uint32_t>(0x82F63B78u, true);

}  // namespace

double table_error(int code) {
  if (code == kNoErrorCode) return std::numeric_limits<double>::infinity();
  constexpr int kMantissa = 128, kLeastExponent = -38;
  return (kMantissa + code % kMantissa) *
         step_size(kStepsPerOctave * (code / kMantissa + kLeastExponent));
}

std::vector<LevelCounts> level_counts(const Header& header) {
  std::vector<LevelCounts> counts;
  LevelCounts level{header.base_vertices, (3 * header.base_triangles + header.boundary_edges) / 2,
                    header.base_triangles};
  counts.push_back(level);
  for (int j = 0; j < header.levels; ++j) {
    level = {level.vertices + level.edges, 2 * level.edges + 3 * level.triangles,
             4 * level.triangles};
    counts.push_back(level);
  }
  return counts;
}

double step_size(int index) {
  assert(index >= -kMaxStepIndex && index <= kMaxStepIndex);
  const int octave = index >> 5;  // floor: arithmetic shift
  const auto exponent = static_cast<std::uint64_t>(octave + 1023);
  return kMantissas[static_cast<std::size_t>(index & 31)] * std::bit_cast<double>(exponent << 52);
}

int predicted_step_index(const Header& header, std::size_t band) {
  int octaves = 1;
  for (std::size_t k = band; k-- > 0; ++octaves) {
    if (header.bands[k].payload_bytes > 0)
      return header.bands[k].step_index + kStepsPerOctave * octaves;
  }
  return header.grid_step_index + kStepsPerOctave * octaves;
}

std::uint16_t crc16(std::span<const std::uint8_t> bytes) {
  unsigned crc = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    crc = ((crc << 8) ^ kCrc16Table[((crc >> 8) ^ byte) & 0xFF]) & 0xFFFF;
  }
  return static_cast<std::uint16_t>(crc);
}

std::uint32_t crc32c(std::span<const std::uint8_t> bytes) {
  std::uint32_t crc = 0xFFFFFFFFu;
  for (const std::uint8_t byte : bytes) crc = (crc >> 8) ^ kCrc32Table[(crc ^ byte) & 0xFF];
  return ~crc;
}

}  // namespace nacre::codec
