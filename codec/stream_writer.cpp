// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/stream_writer.h"

#include <cassert>

#include "codec/byte_writer.h"

namespace nacre::codec {

std::vector<std::uint8_t> write_header(const Header& header) {
  assert(header.bands.empty() || header.bands.back().payload_bytes > 0);
  const bool bits_follow = is_comparator(header.profile);
  ByteWriter writer;
  for (const std::uint8_t byte : kMagic) writer.byte(byte);
  writer.byte(kVersion);
  writer.byte(static_cast<std::uint8_t>(header.levels | (header.bands.size() << 4)));
  writer.byte(static_cast<std::uint8_t>(static_cast<int>(header.transform) |
                                        ((static_cast<int>(header.profile) & 1) << 1) |
                                        (header.has_origin() ? 0x04 : 0) |
                                        (bits_follow ? kGridBitsFollow : header.grid_bits) << 3));
  if (bits_follow) writer.byte(static_cast<std::uint8_t>(header.grid_bits));
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
