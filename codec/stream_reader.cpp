// SPDX-License-Identifier: Apache-2.0
#include "codec/stream_reader.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "codec/byte_reader.h"

namespace nacre::codec {
namespace {

Error corrupt(std::size_t where, const std::string& what) {
  return {ErrorCode::kCorruptStream, what + " (byte " + std::to_string(where) + ")", where};
}

/// Magic and version, which come before any layout is known.
Result<void> check_signature(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kMagic.size() + 1)
    return corrupt(bytes.size(), "not a nacre stream: too short");
  if (!std::equal(kMagic.begin(), kMagic.end(), bytes.begin()))
    return corrupt(0, "not a nacre stream: it does not start with \"NCR\"");
  const int version = bytes[kMagic.size()];
  if (version != kVersion) {
    return Error{ErrorCode::kUnsupportedVersion,
                 "stream version " + std::to_string(version) + "; this decoder reads version " +
                     std::to_string(kVersion),
                 kMagic.size()};
  }
  return {};
}

/// All fields after the version and before the checksum, in file order. Values are not judged here:
/// damage should be reported as such, so the checksum is compared before anything else.
Header parse_fields(ByteReader& reader) {
  Header header;
  const std::uint8_t shape = reader.byte();
  const std::uint8_t flags = reader.byte();
  header.levels = shape & 0x0F;
  header.bands.resize(shape >> 4);
  header.transform = static_cast<wavelet::Transform>(flags & 0x01);
  header.grid_bits = flags >> 3;
  const bool bits_follow = header.grid_bits == kGridBitsFollow;
  header.profile = static_cast<Profile>(((flags >> 1) & 0x01) + (bits_follow ? 2 : 0));
  if (bits_follow) header.grid_bits = reader.byte();
  header.base_vertices = reader.varint();
  header.base_triangles =
      2 * header.base_vertices - static_cast<std::uint64_t>(unzigzag(reader.varint()));
  header.boundary_edges = reader.varint();
  if ((flags & 0x04) != 0) {
    for (int k = 0; k < 3; ++k) header.origin[k] = reader.float64();
  }
  // Two's complement, 16 bits.
  header.grid_step_index = static_cast<std::int16_t>(reader.fixed(2));
  for (std::int64_t& corner : header.grid_corner) corner = unzigzag(reader.varint());
  header.connectivity_bytes = reader.varint();
  header.position_bytes = reader.varint();
  for (std::size_t j = 0; j < header.bands.size(); ++j) {
    BandEntry& band = header.bands[j];
    band.payload_bytes = reader.varint();
    if (band.payload_bytes == 0) continue;
    const std::int64_t delta = unzigzag(reader.varint());
    const std::int64_t bounded = std::clamp<std::int64_t>(delta, -(1 << 20), 1 << 20);
    band.step_index = predicted_step_index(header, j) + static_cast<int>(bounded);
  }
  return header;
}

Result<void> check_counts(const Header& header) {
  constexpr std::uint64_t kMaxCount = std::numeric_limits<std::uint32_t>::max();
  const std::uint64_t V = header.base_vertices, F = header.base_triangles;
  if (V > kMaxCount || F > kMaxCount || header.boundary_edges > kMaxCount)
    return corrupt(6, "base mesh counts are out of range");
  // Every vertex has a triangle, every triangle three vertices and three sides.
  if (V < 3 || F < 1 || V > 3 * F || header.boundary_edges > 3 * F ||
      (3 * F + header.boundary_edges) % 2 != 0)
    return corrupt(6, "base mesh counts contradict each other");
  return {};
}

Result<void> check_values(const Header& header) {
  if (const auto ok = check_counts(header); !ok) return ok.error();
  if (header.bands.size() > static_cast<std::size_t>(header.levels))
    return corrupt(4, "more bands than levels");
  if (!header.bands.empty() && header.bands.back().payload_bytes == 0)
    return corrupt(4, "the last coded band is empty");
  if (header.grid_bits < 1 || header.grid_bits > kMaxGridBits)
    return corrupt(5, "bits per base coordinate are out of range");
  if (is_comparator(header.profile) && header.transform != wavelet::Transform::kButterfly)
    return corrupt(5, "this profile has no transform but the butterfly");
  if (header.profile == Profile::kNmc && header.bands.size() > 1)
    return corrupt(4, "this profile has one band of all details");
  for (int k = 0; k < 3; ++k) {
    if (!std::isfinite(header.origin[k])) return corrupt(6, "the origin is not finite");
    if (header.grid_corner[k] > kMaxGridCorner || header.grid_corner[k] < -kMaxGridCorner)
      return corrupt(6, "the grid's corner is out of range");
  }
  const auto bad_step = [](int index) { return index < -kMaxStepIndex || index > kMaxStepIndex; };
  if (bad_step(header.grid_step_index)) return corrupt(6, "the grid's step is out of range");
  for (const BandEntry& band : header.bands) {
    if (band.payload_bytes > kMaxPayload) return corrupt(6, "a band's length is out of range");
    if (band.payload_bytes > 0 && bad_step(band.step_index))
      return corrupt(6, "a band's step is out of range");
  }
  if (header.connectivity_bytes > kMaxPayload || header.position_bytes > kMaxPayload)
    return corrupt(6, "the base mesh's length is out of range");
  return {};
}

}  // namespace

Result<StreamLayout> read_layout(std::span<const std::uint8_t> bytes) {
  if (const auto ok = check_signature(bytes); !ok) return ok.error();
  ByteReader reader(bytes.subspan(kMagic.size() + 1));
  StreamLayout layout;
  layout.header = parse_fields(reader);
  const std::size_t fields_end = kMagic.size() + 1 + reader.position();
  const std::uint64_t checksum = reader.fixed(2);
  if (reader.failed())
    return corrupt(std::min(bytes.size(), fields_end), "the header is cut or damaged");
  if (checksum != crc16(bytes.first(fields_end)))
    return corrupt(fields_end, "the header's checksum does not match");
  if (const auto ok = check_values(layout.header); !ok) return ok.error();

  layout.header_bytes = fields_end + 2;
  std::size_t offset = layout.header_bytes;
  const auto add = [&](std::uint64_t payload_bytes) {
    layout.sections.push_back({offset, static_cast<std::size_t>(payload_bytes)});
    offset = layout.sections.back().end();
  };
  add(layout.header.connectivity_bytes);
  add(layout.header.position_bytes);
  for (const BandEntry& band : layout.header.bands) add(band.payload_bytes);
  return layout;
}

Result<std::span<const std::uint8_t>> read_section(std::span<const std::uint8_t> bytes,
                                                   const SectionRange& section) {
  if (section.end() > bytes.size()) return corrupt(bytes.size(), "a section is cut");
  const auto payload = bytes.subspan(section.offset, section.payload_bytes);
  const std::size_t width = checksum_bytes(payload.size());
  if (width == 0) return payload;
  ByteReader reader(bytes.subspan(section.offset + payload.size(), width));
  const std::uint64_t stored = reader.fixed(static_cast<int>(width));
  if (stored != (width == 2 ? crc16(payload) : crc32c(payload)))
    return corrupt(section.offset, "a section's checksum does not match");
  return payload;
}

Result<int> available_levels(const StreamLayout& layout, std::size_t byte_count,
                             bool accept_prefix) {
  const std::size_t whole = layout.bytes_whole();
  if (byte_count > whole) return corrupt(whole, "there are bytes after the stream's end");
  if (byte_count == whole) return layout.header.levels;
  if (!accept_prefix)
    return corrupt(byte_count, "the stream is cut: " + std::to_string(whole) + " bytes expected");
  if (byte_count < layout.sections[1].end())
    return corrupt(byte_count, "the stream is cut before the end of the base mesh");
  int levels = 0;
  while (layout.sections[2 + static_cast<std::size_t>(levels)].end() <= byte_count) ++levels;
  return levels;
}

}  // namespace nacre::codec
