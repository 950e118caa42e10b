// SPDX-License-Identifier: Apache-2.0
#include "codec/decode.h"

#include <algorithm>
#include <array>
#include <new>
#include <string>

#include "codec/level_decoder.h"
#include "codec/stream_reader.h"

namespace nacre::codec {
namespace {

constexpr std::array<std::string_view, 4> kProfileNames = {"paper", "best", "nmc", "eqmc"};

Result<void> check_limit(const StreamLayout& layout, int level, const DecodeOptions& options) {
  const std::uint64_t vertices =
      level_counts(layout.header)[static_cast<std::size_t>(level)].vertices;
  if (vertices > options.max_vertices) {
    return Error{ErrorCode::kLimitExceeded,
                 "the stream decodes to " + std::to_string(vertices) + " vertices, the limit is " +
                     std::to_string(options.max_vertices),
                 6};
  }
  return {};
}

int wanted_level(const DecodeOptions& options, int available) {
  return options.max_level < 0 ? available : std::min(options.max_level, available);
}

/// The payload of band j; empty where there is none.
Result<std::span<const std::uint8_t>> band_payload(std::span<const std::uint8_t> bytes,
                                                   const StreamLayout& layout, std::size_t j) {
  if (j >= layout.header.bands.size()) return std::span<const std::uint8_t>();
  return read_section(bytes, layout.sections[2 + j]);
}

Result<void> decode_comparator_levels(std::span<const std::uint8_t> bytes,
                                      const StreamLayout& layout, int levels,
                                      const DecodeOptions& options, LevelDecoder& decoder) {
  if (options.comparators == nullptr) {
    return Error{ErrorCode::kUnsupportedVersion,
                 "the stream is of profile " + std::string(profile_name(layout.header.profile)) +
                     ", which this decoder does not have",
                 5};
  }
  const auto bands =
      options.comparators(bytes, layout, decoder.topology(), levels, options.max_vertices);
  if (!bands) return bands.error();
  for (const std::vector<Vec3>& details : *bands)
    if (const auto ok = decoder.next_level(details); !ok) return ok.error();
  return {};
}

Result<SemiRegularMesh> decode_layout(std::span<const std::uint8_t> bytes,
                                      const StreamLayout& layout, int levels,
                                      const DecodeOptions& options) {
  const auto connectivity = read_section(bytes, layout.sections[0]);
  if (!connectivity) return connectivity.error();
  const auto positions = read_section(bytes, layout.sections[1]);
  if (!positions) return positions.error();
  const auto decoder = LevelDecoder::begin(layout, *connectivity, *positions, levels);
  if (!decoder) return decoder.error();
  if (is_comparator(layout.header.profile)) {
    const auto ok = decode_comparator_levels(bytes, layout, levels, options, **decoder);
    if (!ok) return ok.error();
    return (*decoder)->take();
  }
  for (int j = 0; j < levels; ++j) {
    const auto payload = band_payload(bytes, layout, static_cast<std::size_t>(j));
    if (!payload) return payload.error();
    if (const auto ok = (*decoder)->next_level(*payload); !ok) return ok.error();
  }
  return (*decoder)->take();
}

StreamInfo describe(const StreamLayout& layout, std::size_t bytes_present) {
  const Header& header = layout.header;
  StreamInfo info;
  info.version = kVersion;
  info.profile = header.profile;
  info.transform = header.transform;
  info.base_vertices = static_cast<std::uint32_t>(header.base_vertices);
  info.base_triangles = static_cast<std::uint32_t>(header.base_triangles);
  info.base_bits = header.grid_bits;
  info.origin = header.origin;
  info.level_table = header.level_table;
  info.certified_error = header.certified_error;
  for (std::size_t i = 0; i < layout.sections.size(); ++i) {
    const SectionRange& range = layout.sections[i];
    StreamInfo::Section section;
    section.name = i == 0 ? "base connectivity" : (i == 1 ? "base positions" : "band");
    section.offset = range.offset;
    section.bytes = range.end() - range.offset;
    if (i >= 2 && range.payload_bytes > 0) section.step = step_size(header.bands[i - 2].step_index);
    info.sections.push_back(section);
  }
  const auto counts = level_counts(header);
  for (std::size_t j = 0; j < counts.size(); ++j) {
    const std::size_t last = std::min(j + 1, layout.sections.size() - 1);
    info.levels.push_back({layout.sections[last].end(), counts[j].vertices, counts[j].triangles});
  }
  info.bytes_header = layout.header_bytes;
  info.bytes_present = bytes_present;
  info.bytes_whole = layout.bytes_whole();
  return info;
}

}  // namespace

std::string_view profile_name(Profile profile) {
  return kProfileNames[static_cast<std::size_t>(profile)];
}

std::optional<Profile> profile_of_name(std::string_view name) {
  for (std::size_t i = 0; i < kProfileNames.size(); ++i)
    if (kProfileNames[i] == name) return static_cast<Profile>(i);
  return std::nullopt;
}

Result<StreamInfo> inspect(std::span<const std::uint8_t> bytes, const DecodeOptions& options) {
  const auto layout = read_layout(bytes);
  if (!layout) return layout.error();
  const auto available = available_levels(*layout, bytes.size(), options.accept_prefix);
  if (!available) return available.error();
  if (const auto ok = check_limit(*layout, wanted_level(options, *available), options); !ok)
    return ok.error();
  return describe(*layout, bytes.size());
}

Result<StreamInfo> inspect_header(std::span<const std::uint8_t> beginning, std::size_t file_bytes) {
  const auto layout = read_layout(beginning);
  if (!layout) return layout.error();
  return describe(*layout, file_bytes);
}

Result<SemiRegularMesh> decode(std::span<const std::uint8_t> bytes, const DecodeOptions& options) {
  const auto layout = read_layout(bytes);
  if (!layout) return layout.error();
  const auto available = available_levels(*layout, bytes.size(), options.accept_prefix);
  if (!available) return available.error();
  const int levels = wanted_level(options, *available);
  if (const auto ok = check_limit(*layout, levels, options); !ok) return ok.error();
  try {
    return decode_layout(bytes, *layout, levels, options);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kLimitExceeded, "not enough memory for the stream's mesh", 0};
  }
}

}  // namespace nacre::codec
