// SPDX-License-Identifier: Apache-2.0
#include "codec/comparators.h"

#include <cmath>
#include <string>

#include "codec/stream_format.h"
#include "quant/quant.h"

namespace nacre::codec {
namespace {

using Bands = std::vector<std::vector<Vec3>>;

Error corrupt_at(std::size_t where, const std::string& what) {
  return {ErrorCode::kCorruptStream, what + " (byte " + std::to_string(where) + ")", where};
}

/// The trees reach through all bands, so they are decoded with the whole topology.
Result<Bands> decode_nmc_bands(std::span<const std::uint8_t> bytes, const StreamLayout& layout,
                               const Topology& topology, int levels, std::uint64_t max_vertices) {
  const Header& header = layout.header;
  if (level_counts(header).back().vertices > max_vertices) {
    return Error{ErrorCode::kLimitExceeded,
                 "the stream's trees have more nodes than vertices are allowed", 6};
  }
  const SectionRange& section = layout.sections[2];
  const auto payload = read_section(bytes, section);
  if (!payload) return payload.error();
  const int step = header.bands[0].step_index;
  if (payload->size() < 2 || ((*payload)[1] & 0xC0) != 0 ||
      step - zerotree_step_offset(header.levels - 1) < -kMaxStepIndex)
    return corrupt_at(section.offset, "the zerotree's head is out of range");
  const ZerotreeInfo info{{(*payload)[0] & 0x0F, (*payload)[0] >> 4}, (*payload)[1]};
  const auto whole =
      Topology::build(topology.level(0).triangles, topology.level(0).vertex_count, header.levels);
  if (!whole) return whole.error();
  const auto decoded = entropy::decode_zerotree(payload->subspan(2), *whole, header.levels);
  if (!decoded) return corrupt_at(section.offset, decoded.error().message);
  Bands bands = zerotree_details(*decoded, info, step);
  bands.resize(static_cast<std::size_t>(levels));
  return bands;
}

Result<Bands> decode_eqmc_bands(std::span<const std::uint8_t> bytes, const StreamLayout& layout,
                                const Topology& topology, int levels) {
  entropy::EqModel model;
  Bands bands;
  for (int j = 0; j < levels; ++j) {
    const auto index = static_cast<std::size_t>(j);
    bands.emplace_back(topology.band_size(j), Vec3::Zero());
    if (index >= layout.header.bands.size()) continue;
    const SectionRange& section = layout.sections[2 + index];
    auto payload = read_section(bytes, section);
    if (!payload) return payload.error();
    int ratio_quarters = 0;
    if (!payload->empty()) {
      ratio_quarters = payload->front();
      if (ratio_quarters > 63) return corrupt_at(section.offset, "a band's head is out of range");
      *payload = payload->subspan(1);
      if (payload->empty()) return corrupt_at(section.offset, "a band of zeros has no payload");
    }
    const entropy::EqPlace place{&topology.level(j), j > 0 ? &topology.level(j - 1) : nullptr, j};
    const auto band = entropy::decode_eq_band(*payload, place, model);
    if (!band) return corrupt_at(section.offset, band.error().message);
    if (!payload->empty())
      bands.back() = eq_details(*band, layout.header.bands[index].step_index, ratio_quarters);
  }
  return bands;
}

double tangential_ratio(int ratio_quarters) { return 1 + ratio_quarters * 0.25; }

}  // namespace

Result<Bands> decode_comparator_bands(std::span<const std::uint8_t> bytes,
                                      const StreamLayout& layout, const Topology& topology,
                                      int levels, std::uint64_t max_vertices) {
  if (!is_comparator(layout.header.profile))
    return Error{ErrorCode::kBadInput, "the stream is of another profile", 5};
  if (layout.header.bands.empty() || levels == 0) {
    Bands bands;
    for (int j = 0; j < levels; ++j) bands.emplace_back(topology.band_size(j), Vec3::Zero());
    return bands;
  }
  if (layout.header.profile == Profile::kEqmc)
    return decode_eqmc_bands(bytes, layout, topology, levels);
  return decode_nmc_bands(bytes, layout, topology, levels, max_vertices);
}

int zerotree_step_offset(int levels_above) {
  if (levels_above < 2) return levels_above == 0 ? 0 : 22;
  return 53 + kStepsPerOctave * (levels_above - 2);
}

Bands zerotree_details(const entropy::ZerotreeBands& bands, const ZerotreeInfo& info,
                       int finest_step_index) {
  Bands out;
  const int count = static_cast<int>(bands.points.size());
  const double ratio = tangential_ratio(info.ratio_quarters);
  for (int j = 0; j < count; ++j) {
    const auto& points = bands.points[static_cast<std::size_t>(j)];
    const auto& planes = bands.planes[static_cast<std::size_t>(j)];
    const double step = step_size(finest_step_index - zerotree_step_offset(count - 1 - j));
    std::vector<Vec3> details(points.size(), Vec3::Zero());
    for (std::size_t e = 0; e < points.size(); ++e) {
      for (std::size_t c = 0; c < 3; ++c) {
        const std::int32_t value = points[e][c];
        if (value == 0) continue;
        const std::int32_t magnitude = std::abs(value), unit = 1 << planes[e][c];
        const int centre = info.centres[magnitude == unit ? 0 : 1];
        // Exact but for the product.
        const double x =
            (magnitude + unit * ((8 + centre) * (1.0 / 32))) * (c == 0 ? step : step * ratio);
        details[e][static_cast<int>(c)] = value < 0 ? -x : x;
      }
    }
    out.push_back(std::move(details));
  }
  return out;
}

std::vector<Vec3> eq_details(const entropy::EqBand& band, int step_index, int ratio_quarters) {
  std::array<double, 3> shrinks{};
  for (std::size_t i = 0; i < 3; ++i) shrinks[i] = band.shrink_32nds[i] * (1.0 / 32);
  return quant::dequantize(band.points, step_size(step_index), tangential_ratio(ratio_quarters),
                           shrinks);
}

}  // namespace nacre::codec
