// SPDX-License-Identifier: Apache-2.0
#include "codec/stream_reader.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

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

/// binary32.
double float32(ByteReader& reader) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(reader.fixed(4)));
}

LevelTable parse_level_table(ByteReader& reader, int levels) {
  LevelTable table;
  table.bbox_diagonal = float32(reader);
  for (int j = 0; j <= levels; ++j) {
    const auto codes = static_cast<int>(reader.fixed(3));
    table.cuts.push_back(
        {table_psnr_db(codes & kMaxTableCode), table.bbox_diagonal * table_error(codes >> 12)});
  }
  return table;
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
  const int comparator = header.grid_bits == kGridBitsFollow ? 2 : 0;
  header.profile = static_cast<Profile>(((flags >> 1) & 0x01) + comparator);
  int more = 0;  // flags of the byte that follows
  if (header.grid_bits >= kGridBitsAndFlagsFollow) {
    const std::uint8_t follows = reader.byte();
    more = follows & (kLevelTableFlag | kCertifiedFlag);
    header.grid_bits = follows - more;
    // No other writer: 0 is out of range.
    if (comparator == 0 && more == 0) header.grid_bits = 0;
  }
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
  if ((more & kLevelTableFlag) != 0) header.level_table = parse_level_table(reader, header.levels);
  if ((more & kCertifiedFlag) != 0) header.certified_error = float32(reader);
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
  const auto is_length = [](double x) { return std::isfinite(x) && x >= 0; };
  if (header.level_table && !is_length(header.level_table->bbox_diagonal))
    return corrupt(6, "the level table's diagonal is not a length");
  if (header.certified_error && !is_length(*header.certified_error))
    return corrupt(6, "the certified error is not a length");
  if (header.connectivity_bytes > kMaxPayload || header.position_bytes > kMaxPayload)
    return corrupt(6, "the base mesh's length is out of range");
  return {};
}

}  // namespace

Result<std::optional<StreamLayout>> try_read_layout(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kMagic.size() + 1 &&
      std::ranges::equal(bytes, std::span(kMagic).first(std::min(bytes.size(), kMagic.size()))))
    return std::optional<StreamLayout>();
  if (const auto ok = check_signature(bytes); !ok) return ok.error();
  ByteReader reader(bytes.subspan(kMagic.size() + 1));
  StreamLayout layout;
  layout.header = parse_fields(reader);
  const std::size_t fields_end = kMagic.size() + 1 + reader.position();
  const std::uint64_t checksum = reader.fixed(2);
  if (reader.failed() && bytes.size() < kMaxHeaderBytes) return std::optional<StreamLayout>();
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
  return std::optional(std::move(layout));
}

Result<StreamLayout> read_layout(std::span<const std::uint8_t> bytes) {
  auto layout = try_read_layout(bytes);
  if (!layout) return layout.error();
  if (*layout) return std::move(**layout);
  if (const auto ok = check_signature(bytes); !ok) return ok.error();
  return corrupt(bytes.size(), "the header is cut or damaged");
}

Result<std::span<const std::uint8_t>> read_section(std::span<const std::uint8_t> bytes,
                                                   const SectionRange& section) {
  if (section.end() > bytes.size()) return corrupt(bytes.size(), "a section is cut");
  return checked_payload(bytes.subspan(section.offset, section.end() - section.offset), section);
}

Result<std::span<const std::uint8_t>> checked_payload(std::span<const std::uint8_t> bytes,
                                                      const SectionRange& section) {
  const auto payload = bytes.first(section.payload_bytes);
  const std::size_t width = checksum_bytes(payload.size());
  if (width == 0) return payload;
  ByteReader reader(bytes.subspan(payload.size(), width));
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
