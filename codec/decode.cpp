// SPDX-License-Identifier: Apache-2.0
#include "codec/decode.h"

#include <algorithm>
#include <array>
#include <new>
#include <string>

#include "codec/best_decode.h"
#include "codec/byte_reader.h"
#include "codec/stream_reader.h"
#include "entropy/connectivity.h"
#include "entropy/stack_run.h"
#include "quant/quant.h"

namespace nacre::codec {
namespace {

constexpr std::array<std::string_view, 4> kProfileNames = {"paper", "best", "nmc", "eqmc"};

/// The parts know nothing of the file: whatever they object to is damage at this place of it.
Error corrupt_at(std::size_t where, const std::string& section, const Error& cause) {
  return {ErrorCode::kCorruptStream,
          section + " does not decode: " + cause.message + " (byte " + std::to_string(where) + ")",
          where};
}

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

Result<entropy::Connectivity> decode_base(std::span<const std::uint8_t> bytes,
                                          const StreamLayout& layout) {
  const SectionRange& section = layout.sections[0];
  const Header& header = layout.header;
  const auto payload = read_section(bytes, section);
  if (!payload) return payload.error();
  auto connectivity =
      entropy::decode_connectivity(*payload, static_cast<std::uint32_t>(header.base_triangles));
  if (!connectivity) return corrupt_at(section.offset, "base connectivity", connectivity.error());
  if (connectivity->vertex_count != header.base_vertices ||
      connectivity->triangles.size() != header.base_triangles) {
    return Error{ErrorCode::kCorruptStream, "the base mesh is not of the size the header states",
                 section.offset};
  }
  return connectivity;
}

Result<std::vector<Vec3>> decode_base_positions(std::span<const std::uint8_t> bytes,
                                                const StreamLayout& layout,
                                                const entropy::Connectivity& connectivity) {
  const SectionRange& section = layout.sections[1];
  const Header& header = layout.header;
  const auto payload = read_section(bytes, section);
  if (!payload) return payload.error();
  const auto grid = entropy::decode_base_positions(*payload, connectivity, header.grid_bits);
  if (!grid) return corrupt_at(section.offset, "base positions", grid.error());
  const double step = step_size(header.grid_step_index);
  std::vector<Vec3> positions;
  positions.reserve(grid->size());
  for (const entropy::GridPoint& g : *grid) {
    Vec3 p;
    for (int k = 0; k < 3; ++k) {
      // An exact integer sum, then one rounding.
      p[k] = static_cast<double>(header.grid_corner[static_cast<std::size_t>(k)] +
                                 g[static_cast<std::size_t>(k)]) *
             step;
    }
    positions.push_back(p);
  }
  return positions;
}

/// Details of one band of the paper's profile from its section; section 9 of the document.
Result<std::vector<Vec3>> decode_band(std::span<const std::uint8_t> bytes,
                                      const StreamLayout& layout, std::size_t band,
                                      std::size_t count) {
  if (band >= layout.header.bands.size() || layout.header.bands[band].payload_bytes == 0)
    return std::vector<Vec3>(count, Vec3::Zero());
  const SectionRange& section = layout.sections[2 + band];
  const auto payload = read_section(bytes, section);
  if (!payload) return payload.error();

  ByteReader reader(*payload);
  const std::uint8_t info_byte = reader.byte();
  const BandInfo info{info_byte & 0x0F, info_byte >> 4};
  const std::uint64_t prefix_bytes = reader.varint();
  const auto codes = reader.rest();
  if (reader.failed() || prefix_bytes > codes.size()) {
    return Error{ErrorCode::kCorruptStream, "a band's parts are longer than the band",
                 section.offset};
  }
  quant::ProductCode code;
  auto prefix = entropy::decode_stack_run(codes.first(prefix_bytes), count);
  if (!prefix) return corrupt_at(section.offset, "a band's prefixes", prefix.error());
  code.prefix = std::move(*prefix);
  const auto non_null = static_cast<std::size_t>(
      std::count_if(code.prefix.begin(), code.prefix.end(), [](std::int64_t p) { return p != 0; }));
  auto suffix = entropy::decode_stack_run(codes.subspan(prefix_bytes), non_null);
  if (!suffix) return corrupt_at(section.offset, "a band's suffixes", suffix.error());
  code.suffix = std::move(*suffix);
  const auto points = quant::from_product_code(code);
  if (!points) return corrupt_at(section.offset, "a band", points.error());
  return quant::dequantize(*points, step_size(layout.header.bands[band].step_index),
                           info.tangential_ratio(), info.shrink());
}

Result<std::vector<std::vector<Vec3>>> decode_bands(std::span<const std::uint8_t> bytes,
                                                    const StreamLayout& layout,
                                                    const Topology& topology, int levels,
                                                    const DecodeOptions& options) {
  if (is_comparator(layout.header.profile)) {
    if (options.comparators != nullptr)
      return options.comparators(bytes, layout, topology, levels, options.max_vertices);
    return Error{ErrorCode::kUnsupportedVersion,
                 "the stream is of profile " + std::string(profile_name(layout.header.profile)) +
                     ", which this decoder does not have",
                 5};
  }
  std::vector<std::vector<Vec3>> bands;
  for (int j = 0; j < levels; ++j) {
    auto band = decode_band(bytes, layout, static_cast<std::size_t>(j), topology.band_size(j));
    if (!band) return band.error();
    bands.push_back(std::move(*band));
  }
  return bands;
}

Result<std::vector<Vec3>> decode_positions(std::span<const std::uint8_t> bytes,
                                           const StreamLayout& layout, const Topology& topology,
                                           int levels, std::vector<Vec3> base_positions,
                                           const DecodeOptions& options) {
  const auto transform = layout.header.transform;
  Result<std::vector<Vec3>> positions = std::vector<Vec3>();
  if (layout.header.profile == Profile::kBest) {
    const auto bands = decode_best_bands(bytes, layout, topology, levels);
    if (!bands) return bands.error();
    positions = wavelet::synthesize(topology, std::move(base_positions), *bands, transform);
  } else {
    auto bands = decode_bands(bytes, layout, topology, levels, options);
    if (!bands) return bands.error();
    const Pyramid pyramid = {std::move(base_positions), std::move(*bands)};
    positions = wavelet::synthesize(topology, pyramid, transform);
  }
  if (!positions) return corrupt_at(0, "the geometry", positions.error());
  return positions;
}

Result<SemiRegularMesh> decode_layout(std::span<const std::uint8_t> bytes,
                                      const StreamLayout& layout, int levels,
                                      const DecodeOptions& options) {
  auto connectivity = decode_base(bytes, layout);
  if (!connectivity) return connectivity.error();
  auto topology = Topology::build_for_decoding(connectivity->triangles,
                                               connectivity->vertex_count, levels);
  if (!topology) {
    if (topology.error().code == ErrorCode::kLimitExceeded) return topology.error();
    return corrupt_at(layout.sections[0].offset, "base connectivity", topology.error());
  }
  if (topology->level(0).edges.size() != level_counts(layout.header)[0].edges) {
    return Error{ErrorCode::kCorruptStream, "the base mesh's boundary is not as the header states",
                 layout.sections[0].offset};
  }
  auto base_positions = decode_base_positions(bytes, layout, *connectivity);
  if (!base_positions) return base_positions.error();
  auto positions = decode_positions(bytes, layout, *topology, levels, std::move(*base_positions),
                                    options);
  if (!positions) return positions.error();
  SemiRegularMesh mesh;
  mesh.base_vertex_count = connectivity->vertex_count;
  mesh.base_triangles = std::move(connectivity->triangles);
  mesh.level_count = levels;
  mesh.positions = std::move(*positions);
  mesh.origin = layout.header.origin;
  return mesh;
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
