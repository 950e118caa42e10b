// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/geometry.h"
#include "codec/decode.h"
#include "wavelet/wavelet.h"

/// What the writer and the reader of a stream both need: constants, the header's fields, the table
/// of steps, checksums. docs/FORMAT.md is the specification; section numbers below are its.
namespace nacre::codec {

inline constexpr std::array<std::uint8_t, 3> kMagic = {'N', 'C', 'R'};
inline constexpr int kVersion = 0;

inline constexpr int kMaxLevels = 15;  ///< Levels and Coded_Bands are 4-bit fields
inline constexpr int kMaxGridBits = 24;
/// What the field of grid bits says if a byte of its own has them, and flags: always so in profiles
/// nmc and eqmc, and in the others where there are flags.
inline constexpr int kGridBitsFollow = 31, kGridBitsAndFlagsFollow = 30;
inline constexpr int kLevelTableFlag = 0x20, kCertifiedFlag = 0x40;  ///< of that byte
/// Steps lie in 2^-200 .. 2^200, so that squared and crossed lengths neither overflow nor vanish.
inline constexpr int kMaxStepIndex = 32 * 200;
inline constexpr int kStepsPerOctave = 32;
/// |corner| of the grid, in grid steps: corner + coordinate stays exact in a double.
inline constexpr std::int64_t kMaxGridCorner = std::int64_t{1} << 52;
/// Largest payload protected by 16 bits; CRC-16 finds any three flipped bits up to 4093 bytes.
inline constexpr std::size_t kShortPayload = 2048;
/// Largest payload a length field may state.
inline constexpr std::uint64_t kMaxPayload = std::uint64_t{1} << 40;

/// A profile whose decoder is not in the decoding half.
[[nodiscard]] inline bool is_comparator(Profile profile) {
  return profile == Profile::kNmc || profile == Profile::kEqmc;
}

/// One detail band as the header states it.
struct BandEntry {
  std::uint64_t payload_bytes = 0;  ///< 0: nothing is coded, every detail is zero
  int step_index = 0;               ///< meaningful if payload_bytes > 0
};

struct Header {
  Profile profile = Profile::kPaper;
  wavelet::Transform transform = wavelet::Transform::kButterfly;
  int levels = 0;  ///< J
  std::uint64_t base_vertices = 0, base_triangles = 0, boundary_edges = 0;
  Vec3 origin = Vec3::Zero();
  int grid_bits = 0;
  int grid_step_index = 0;
  std::array<std::int64_t, 3> grid_corner = {0, 0, 0};
  std::uint64_t connectivity_bytes = 0, position_bytes = 0;
  std::vector<BandEntry> bands;           ///< the coded ones; bands beyond are all zero
  std::optional<LevelTable> level_table;  ///< if there is one: levels + 1 cuts
  std::optional<double> certified_error;

  [[nodiscard]] bool has_origin() const {
    return origin[0] != 0 || origin[1] != 0 || origin[2] != 0;
  }
};

/// Vertices, edges and triangles of one level, as 64-bit counts.
struct LevelCounts {
  std::uint64_t vertices = 0, edges = 0, triangles = 0;
};

/// Counts of levels 0 .. header.levels from those of the base. Needs base counts below 2^32.
[[nodiscard]] std::vector<LevelCounts> level_counts(const Header& header);

/// 2^(index / 32) to the bit, |index| <= kMaxStepIndex (section 4).
[[nodiscard]] double step_size(int index);

/// What the header's step delta of a coded band is relative to: one octave per level below the last
/// coded one, the grid counting as level -1.
[[nodiscard]] int predicted_step_index(const Header& header, std::size_t band);

/// Quantiser parameters that the decoder needs, in the first byte of a band's payload.
struct BandInfo {
  int shrink_32nds = 0;    ///< 0 .. 15: reconstruction offset toward zero, in 1/32 steps
  int ratio_quarters = 0;  ///< 0 .. 15: tangential step / step = 1 + ratio_quarters / 4

  [[nodiscard]] double shrink() const { return shrink_32nds * (1.0 / 32); }
  [[nodiscard]] double tangential_ratio() const { return 1 + ratio_quarters * 0.25; }
};

/// Fields of a level table, 12 bits each (section 3).
inline constexpr int kMaxTableCode = 4095;
/// Errors of this code are not known.
inline constexpr int kNoErrorCode = kMaxTableCode;
[[nodiscard]] inline double table_psnr_db(int code) { return code / 20.0; }
/// Share of the diagonal: (128 + code mod 128) 2^(⌊code / 128⌋ − 38); infinite for kNoErrorCode.
[[nodiscard]] double table_error(int code);

/// CRC-16/IBM-3740: polynomial 0x1021, initial value 0xFFFF, not reflected.
[[nodiscard]] std::uint16_t crc16(std::span<const std::uint8_t> bytes);
/// CRC-32C (Castagnoli), reflected.
[[nodiscard]] std::uint32_t crc32c(std::span<const std::uint8_t> bytes);

/// Bytes of checksum after a payload: none after an empty one, 2 up to kShortPayload, else 4.
[[nodiscard]] inline std::size_t checksum_bytes(std::uint64_t payload_bytes) {
  return payload_bytes == 0 ? 0 : (payload_bytes <= kShortPayload ? 2 : 4);
}

/// Signed integers as unsigned ones, small magnitudes first: 0, -1, 1, -2, 2, ...
[[nodiscard]] inline std::uint64_t zigzag(std::int64_t value) {
  return (static_cast<std::uint64_t>(value) << 1) ^ static_cast<std::uint64_t>(value >> 63);
}
[[nodiscard]] inline std::int64_t unzigzag(std::uint64_t code) {
  return static_cast<std::int64_t>(code >> 1) ^ -static_cast<std::int64_t>(code & 1);
}

}  // namespace nacre::codec
