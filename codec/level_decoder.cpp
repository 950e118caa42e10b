// SPDX-License-Identifier: Apache-2.0
#include "codec/level_decoder.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "codec/best_decode.h"
#include "codec/byte_reader.h"
#include "codec/stream_planes.h"
#include "entropy/connectivity.h"
#include "entropy/plane_positions_decode.h"
#include "entropy/stack_run.h"
#include "quant/quant.h"

namespace nacre::codec {
namespace {

/// The parts know nothing of the file: whatever they object to is damage at this place of it.
Error corrupt_at(std::size_t where, const std::string& section, const Error& cause) {
  return {ErrorCode::kCorruptStream,
          section + " does not decode: " + cause.message + " (byte " + std::to_string(where) + ")",
          where};
}

Result<entropy::Connectivity> decode_base(std::span<const std::uint8_t> payload,
                                          const StreamLayout& layout) {
  const SectionRange& section = layout.sections[0];
  const Header& header = layout.header;
  auto connectivity =
      entropy::decode_connectivity(payload, static_cast<std::uint32_t>(header.base_triangles));
  if (!connectivity) return corrupt_at(section.offset, "base connectivity", connectivity.error());
  if (connectivity->vertex_count != header.base_vertices ||
      connectivity->triangles.size() != header.base_triangles) {
    return Error{ErrorCode::kCorruptStream, "the base mesh is not of the size the header states",
                 section.offset};
  }
  return connectivity;
}

Result<std::vector<Vec3>> decode_base_positions(std::span<const std::uint8_t> payload,
                                                const StreamLayout& layout,
                                                const entropy::Connectivity& connectivity) {
  const SectionRange& section = layout.sections[1];
  const Header& header = layout.header;
  const auto grid =
      (has_planes(header) ? entropy::decode_positions_by_planes : entropy::decode_base_positions)(
          payload, connectivity, header.grid_bits);
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
Result<std::vector<Vec3>> decode_paper_band(std::span<const std::uint8_t> payload,
                                            std::size_t offset, double step, std::size_t count) {
  ByteReader reader(payload);
  const std::uint8_t info_byte = reader.byte();
  const BandInfo info{info_byte & 0x0F, info_byte >> 4};
  const std::uint64_t prefix_bytes = reader.varint();
  const auto codes = reader.rest();
  if (reader.failed() || prefix_bytes > codes.size()) {
    return Error{ErrorCode::kCorruptStream, "a band's parts are longer than the band", offset};
  }
  quant::ProductCode code;
  auto prefix = entropy::decode_stack_run(codes.first(prefix_bytes), count);
  if (!prefix) return corrupt_at(offset, "a band's prefixes", prefix.error());
  code.prefix = std::move(*prefix);
  const auto non_null = static_cast<std::size_t>(
      std::count_if(code.prefix.begin(), code.prefix.end(), [](std::int64_t p) { return p != 0; }));
  auto suffix = entropy::decode_stack_run(codes.subspan(prefix_bytes), non_null);
  if (!suffix) return corrupt_at(offset, "a band's suffixes", suffix.error());
  code.suffix = std::move(*suffix);
  const auto points = quant::from_product_code(code);
  if (!points) return corrupt_at(offset, "a band", points.error());
  return quant::dequantize(*points, step, info.tangential_ratio(), info.shrink());
}

/// Details that are not zero.
wavelet::SparseBand sparse(std::span<const Vec3> details) {
  wavelet::SparseBand band;
  for (std::uint32_t e = 0; e < details.size(); ++e) {
    const Vec3& d = details[e];
    if (d[0] == 0 && d[1] == 0 && d[2] == 0) continue;
    band.edges.push_back(e);
    band.details.push_back(d);
  }
  return band;
}

}  // namespace

LevelDecoder::LevelDecoder(const StreamLayout& layout, Topology topology, SemiRegularMesh base)
    : layout_(layout),
      topology_(std::move(topology)),
      mesh_(std::move(base)),
      synthesizer_(topology_, layout.header.transform) {}

Result<std::unique_ptr<LevelDecoder>> LevelDecoder::begin(
    const StreamLayout& layout, std::span<const std::uint8_t> connectivity_payload,
    std::span<const std::uint8_t> positions_payload, int finest) {
  auto connectivity = decode_base(connectivity_payload, layout);
  if (!connectivity) return connectivity.error();
  auto topology =
      Topology::build_for_decoding(connectivity->triangles, connectivity->vertex_count, finest);
  if (!topology) {
    if (topology.error().code == ErrorCode::kLimitExceeded) return topology.error();
    return corrupt_at(layout.sections[0].offset, "base connectivity", topology.error());
  }
  if (topology->level(0).edges.size() != level_counts(layout.header)[0].edges) {
    return Error{ErrorCode::kCorruptStream, "the base mesh's boundary is not as the header states",
                 layout.sections[0].offset};
  }
  auto positions = decode_base_positions(positions_payload, layout, *connectivity);
  if (!positions) return positions.error();
  SemiRegularMesh mesh;
  mesh.base_vertex_count = connectivity->vertex_count;
  mesh.base_triangles = std::move(connectivity->triangles);
  mesh.positions = std::move(*positions);
  mesh.positions.reserve(topology->vertex_count());
  mesh.origin = layout.header.origin;
  return std::unique_ptr<LevelDecoder>(
      new LevelDecoder(layout, std::move(*topology), std::move(mesh)));
}

Result<wavelet::SparseBand> LevelDecoder::decode_band(std::span<const std::uint8_t> payload) {
  const auto j = static_cast<std::size_t>(mesh_.level_count);
  const bool is_coded = !payload.empty();
  const std::size_t offset = is_coded ? layout_.sections[2 + j].offset : 0;
  if (layout_.header.profile == Profile::kBest)
    return decode_best_band(payload, layout_, topology_, mesh_.level_count, model_);
  if (!is_coded) return wavelet::SparseBand();
  const double step = step_size(layout_.header.bands[j].step_index);
  const auto details =
      decode_paper_band(payload, offset, step, topology_.band_size(mesh_.level_count));
  if (!details) return details.error();
  return sparse(*details);
}

Result<void> LevelDecoder::next_level(std::span<const std::uint8_t> payload) {
  const auto band = decode_band(payload);
  if (!band) return band.error();
  return add(*band);
}

Result<void> LevelDecoder::next_level(std::span<const Vec3> details) {
  return add(sparse(details));
}

Result<void> LevelDecoder::add(const wavelet::SparseBand& band) {
  // The butterfly leaves the vertices that were there, and were looked at, where they are.
  const bool looked_at =
      mesh_.level_count > 0 && layout_.header.transform == wavelet::Transform::kButterfly;
  const auto known = static_cast<std::ptrdiff_t>(looked_at ? mesh_.positions.size() : 0);
  synthesizer_.next_level(mesh_.level_count, band, mesh_.positions);
  ++mesh_.level_count;
  const auto bad =
      std::find_if(mesh_.positions.begin() + known, mesh_.positions.end(), [](const Vec3& p) {
        return !(std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]));
      });
  if (bad == mesh_.positions.end()) return {};
  const auto vertex = static_cast<std::size_t>(bad - mesh_.positions.begin());
  return corrupt_at(
      0, "the geometry",
      {ErrorCode::kBadInput,
       "vertex " + std::to_string(vertex) + " has a coordinate that is not finite", vertex});
}

}  // namespace nacre::codec
