// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/symbols.h"

#include <algorithm>
#include <string>

#include "base/topology.h"
#include "codec/byte_reader.h"
#include "codec/byte_writer.h"
#include "codec/stream_planes.h"
#include "codec/stream_reader.h"
#include "codec/stream_writer.h"
#include "entropy/plane_position_writer.h"
#include "entropy/plane_positions_decode.h"
#include "entropy/stack_run.h"
#include "quant/quant.h"

namespace nacre::codec {
namespace {

Error bad(const std::string& what, std::size_t where = 0) {
  return {ErrorCode::kBadInput, what, where};
}

Result<void> check_profile(Profile profile) {
  if (profile == Profile::kBest || profile == Profile::kPaper) return {};
  return Error{ErrorCode::kUnsupportedVersion,
               "the symbols of profile " + std::string(profile_name(profile)) +
                   " cannot be taken apart; best and paper can",
               0};
}

/// The base's triangles and as many levels as there are bands.
Result<Topology> topology_of(const Header& header, const entropy::Connectivity& connectivity) {
  return Topology::build_for_decoding(connectivity.triangles, connectivity.vertex_count,
                                      static_cast<int>(header.bands.size()));
}

entropy::BandPlace place_of(const Topology& topology, const Header& header, std::size_t band,
                            bool is_coded, bool coarser_is_coded) {
  const auto level = static_cast<int>(band);
  const int excess = is_coded && coarser_is_coded
                         ? header.bands[band - 1].step_index - header.bands[band].step_index
                         : 0;
  return {&topology.level(level), level > 0 ? &topology.level(level - 1) : nullptr, level, excess};
}

Result<entropy::BandSymbols> read_paper_band(std::span<const std::uint8_t> payload,
                                             std::size_t count) {
  entropy::BandSymbols band;
  if (payload.empty()) return band;
  ByteReader reader(payload);
  const std::uint8_t info = reader.byte();
  band.shrink_32nds[0] = info & 0x0F;
  band.ratio_quarters = info >> 4;
  const std::uint64_t prefix_bytes = reader.varint();
  const auto codes = reader.rest();
  if (reader.failed() || prefix_bytes > codes.size())
    return Error{ErrorCode::kCorruptStream, "a band's parts are longer than the band", 0};
  auto prefix = entropy::decode_stack_run(codes.first(prefix_bytes), count);
  if (!prefix) return prefix.error();
  const auto non_null = std::ranges::count_if(*prefix, [](std::int64_t p) { return p != 0; });
  auto suffix =
      entropy::decode_stack_run(codes.subspan(prefix_bytes), static_cast<std::size_t>(non_null));
  if (!suffix) return suffix.error();
  auto points = quant::from_product_code({std::move(*prefix), std::move(*suffix)});
  if (!points) return points.error();
  band.points = std::move(*points);
  return band;
}

Result<std::vector<std::uint8_t>> write_paper_band(const entropy::BandSymbols& band,
                                                   std::size_t count) {
  std::vector<std::uint8_t> none;
  if (band.points.empty()) return none;
  if (band.points.size() != count) return bad("needs one point per detail");
  bool any = false;
  for (std::size_t e = 0; e < count; ++e) {
    for (const std::int32_t value : band.points[e]) {
      any |= value != 0;
      if (value < -quant::kMaxComponent || value > quant::kMaxComponent)
        return bad("a quantised detail lies past 2^24", e);
    }
  }
  if (!any) return none;
  if (band.shrink_32nds[0] < 0 || band.shrink_32nds[0] > 15 || band.ratio_quarters < 0 ||
      band.ratio_quarters > 15)
    return bad("offset and ratio of steps must lie in 0 .. 15");
  const quant::ProductCode code = quant::to_product_code(band.points);
  const auto prefix = entropy::encode_stack_run(code.prefix);
  ByteWriter writer;
  writer.byte(static_cast<std::uint8_t>(band.shrink_32nds[0] | (band.ratio_quarters << 4)));
  writer.varint(prefix.size());
  writer.append(prefix);
  writer.append(entropy::encode_stack_run(code.suffix));
  return writer.take();
}

std::vector<std::uint8_t> write_positions(const StreamSymbols& symbols,
                                          const entropy::Connectivity& base) {
  const Header& header = symbols.header;
  return (has_planes(header)
              ? entropy::encode_positions_by_planes
              : entropy::encode_base_positions)(symbols.grid, base, header.grid_bits);
}

}  // namespace

Result<StreamSymbols> read_symbols(std::span<const std::uint8_t> stream) {
  auto layout = read_layout(stream);
  if (!layout) return layout.error();
  if (const auto ok = check_profile(layout->header.profile); !ok) return ok.error();
  if (const auto whole = available_levels(*layout, stream.size(), false); !whole)
    return whole.error();
  StreamSymbols out;
  out.header = layout->header;
  const auto connectivity = read_section(stream, layout->sections[0]);
  if (!connectivity) return connectivity.error();
  out.connectivity.assign(connectivity->begin(), connectivity->end());
  const auto base = entropy::decode_connectivity(
      *connectivity, static_cast<std::uint32_t>(out.header.base_triangles));
  if (!base) return base.error();
  const auto positions = read_section(stream, layout->sections[1]);
  if (!positions) return positions.error();
  auto grid = (has_planes(out.header)
                   ? entropy::decode_positions_by_planes
                   : entropy::decode_base_positions)(*positions, *base, out.header.grid_bits);
  if (!grid) return grid.error();
  out.grid = std::move(*grid);
  const auto topology = topology_of(out.header, *base);
  if (!topology) return topology.error();
  entropy::DetailModel model;
  bool coarser_is_coded = false;
  for (std::size_t j = 0; j < out.header.bands.size(); ++j) {
    const auto payload = read_section(stream, layout->sections[2 + j]);
    if (!payload) return payload.error();
    const bool is_coded = !payload->empty();
    const auto place = place_of(*topology, out.header, j, is_coded, coarser_is_coded);
    auto band = out.header.profile == Profile::kBest
                    ? entropy::read_band_symbols(*payload, place, model)
                    : read_paper_band(*payload, place.level->edges.size());
    if (!band) return band.error();
    out.bands.push_back(std::move(*band));
    coarser_is_coded = is_coded;
  }
  return out;
}

Result<std::vector<std::uint8_t>> write_symbols(const StreamSymbols& symbols) {
  const Header& header = symbols.header;
  if (const auto ok = check_profile(header.profile); !ok) return ok.error();
  if (header.base_triangles > 0xFFFFFFFFu || header.grid_bits < 1 ||
      header.grid_bits > kMaxGridBits)
    return bad("the header's counts are out of range");
  const auto base = entropy::decode_connectivity(symbols.connectivity,
                                                 static_cast<std::uint32_t>(header.base_triangles));
  if (!base) return base.error();
  if (symbols.grid.size() != base->vertex_count) return bad("the base needs a point per vertex");
  for (std::size_t v = 0; v < symbols.grid.size(); ++v)
    for (const std::int32_t g : symbols.grid[v])
      if (g < 0 || g >= (1 << header.grid_bits))
        return bad("base vertex " + std::to_string(v) + " lies outside of its grid of " +
                       std::to_string(header.grid_bits) + " bits",
                   v);
  if (symbols.bands.size() != header.bands.size()) return bad("a band is missing");
  const auto topology = topology_of(header, *base);
  if (!topology) return topology.error();
  entropy::DetailModel model;
  std::vector<std::vector<std::uint8_t>> payloads;
  bool coarser_is_coded = false;
  for (std::size_t j = 0; j < symbols.bands.size(); ++j) {
    const auto& band = symbols.bands[j];
    const bool is_coded = std::ranges::any_of(
        band.points, [](const entropy::DetailPoint& p) { return p != entropy::DetailPoint{}; });
    const auto place = place_of(*topology, header, j, is_coded, coarser_is_coded);
    auto payload = header.profile == Profile::kBest
                       ? entropy::write_band_symbols(band, place, model)
                       : write_paper_band(band, place.level->edges.size());
    if (!payload) return bad("band " + std::to_string(j) + ": " + payload.error().message, j);
    payloads.push_back(std::move(*payload));
    coarser_is_coded = is_coded;
  }
  return write_stream(header, symbols.connectivity, write_positions(symbols, *base), payloads);
}

}  // namespace nacre::codec
