// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/stream_writer.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

#include "codec/byte_writer.h"

namespace nacre::codec {
namespace {

int grid_bits_field(const Header& header) {
  if (is_comparator(header.profile)) return kGridBitsFollow;
  const bool has_flags = header.level_table || header.certified_error;
  return has_flags ? kGridBitsAndFlagsFollow : header.grid_bits;
}

float rounded_up(double value) {
  const auto nearest = static_cast<float>(value);
  if (static_cast<double>(nearest) >= value) return nearest;
  return std::nextafter(nearest, std::numeric_limits<float>::infinity());
}

void write_rounded_up(double value, ByteWriter& writer) {
  writer.fixed(std::bit_cast<std::uint32_t>(rounded_up(value)), 4);
}

/// Rounded down; what is a step but for its own rounding is that step.
int psnr_code(double psnr_db) {
  const double steps = std::floor(psnr_db * 20 + 1e-6);
  return static_cast<int>(std::clamp(steps, 0.0, static_cast<double>(kMaxTableCode)));
}

/// The least code that is not below the error.
int error_code(double error, double diagonal) {
  int low = 0, high = kNoErrorCode;
  while (low < high) {
    const int middle = (low + high) / 2;
    if (diagonal * table_error(middle) >= error) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  return low;
}

void write_level_table(const LevelTable& table, ByteWriter& writer) {
  const float diagonal = rounded_up(table.bbox_diagonal);
  write_rounded_up(table.bbox_diagonal, writer);
  for (const LevelTable::Cut& cut : table.cuts) {
    const int error = error_code(cut.max_error, static_cast<double>(diagonal));
    writer.fixed(static_cast<std::uint64_t>(psnr_code(cut.psnr_db) | error << 12), 3);
  }
}

}  // namespace

std::vector<std::uint8_t> write_header(const Header& header) {
  assert(header.bands.empty() || header.bands.back().payload_bytes > 0);
  assert(!header.level_table ||
         header.level_table->cuts.size() == static_cast<std::size_t>(header.levels) + 1);
  const int more =
      (header.level_table ? kLevelTableFlag : 0) | (header.certified_error ? kCertifiedFlag : 0);
  const bool bits_follow = is_comparator(header.profile) || more != 0;
  ByteWriter writer;
  for (const std::uint8_t byte : kMagic) writer.byte(byte);
  writer.byte(kVersion);
  writer.byte(static_cast<std::uint8_t>(header.levels | (header.bands.size() << 4)));
  writer.byte(static_cast<std::uint8_t>(
      static_cast<int>(header.transform) | ((static_cast<int>(header.profile) & 1) << 1) |
      (header.has_origin() ? 0x04 : 0) | grid_bits_field(header) << 3));
  if (bits_follow) writer.byte(static_cast<std::uint8_t>(header.grid_bits | more));
  writer.varint(header.base_vertices);
  writer.varint(zigzag(static_cast<std::int64_t>(2 * header.base_vertices) -
                       static_cast<std::int64_t>(header.base_triangles)));
  writer.varint(header.boundary_edges);
  if (header.has_origin()) {
    for (int k = 0; k < 3; ++k) writer.float64(header.origin[k]);
  }
  writer.fixed(static_cast<std::uint16_t>(header.grid_step_index), 2);
  for (const std::int64_t corner : header.grid_corner) writer.varint(zigzag(corner));
  writer.varint(header.connectivity_bytes);
  writer.varint(header.position_bytes);
  for (std::size_t j = 0; j < header.bands.size(); ++j) {
    const BandEntry& band = header.bands[j];
    writer.varint(band.payload_bytes);
    if (band.payload_bytes > 0)
      writer.varint(zigzag(band.step_index - predicted_step_index(header, j)));
  }
  if (header.level_table) write_level_table(*header.level_table, writer);
  if (header.certified_error) write_rounded_up(*header.certified_error, writer);
  writer.fixed(crc16(writer.bytes()), 2);
  return writer.take();
}

std::vector<std::uint8_t> write_section(const std::vector<std::uint8_t>& payload) {
  ByteWriter writer;
  writer.append(payload);
  const std::size_t width = checksum_bytes(payload.size());
  if (width > 0)
    writer.fixed(width == 2 ? crc16(payload) : crc32c(payload), static_cast<int>(width));
  return writer.take();
}

std::vector<std::uint8_t> write_stream(Header header, const std::vector<std::uint8_t>& connectivity,
                                       const std::vector<std::uint8_t>& positions,
                                       std::span<const std::vector<std::uint8_t>> bands) {
  assert(header.bands.size() == bands.size());
  header.connectivity_bytes = connectivity.size();
  header.position_bytes = positions.size();
  for (std::size_t j = 0; j < bands.size(); ++j) header.bands[j].payload_bytes = bands[j].size();
  while (!header.bands.empty() && header.bands.back().payload_bytes == 0) header.bands.pop_back();

  ByteWriter writer;
  writer.append(write_header(header));
  writer.append(write_section(connectivity));
  writer.append(write_section(positions));
  for (const auto& band : bands) writer.append(write_section(band));
  return writer.take();
}

}  // namespace nacre::codec
