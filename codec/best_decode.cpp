// SPDX-License-Identifier: Apache-2.0
#include "codec/best_decode.h"

#include <algorithm>
#include <string>

namespace nacre::codec {

wavelet::SparseBand reconstruct(const entropy::DetailBand& band, double step) {
  // The order of these operations is part of the format.
  const double tangential_step = step * (1 + band.ratio_quarters * 0.25);
  const auto component = [&](std::int32_t value, double unit) {
    if (value == 0) return 0.0;
    const std::int32_t magnitude = std::abs(value);
    const double shrink =
        band.shrink_32nds[static_cast<std::size_t>(std::min(magnitude, 3) - 1)] * (1.0 / 32);
    const double size = (static_cast<double>(magnitude) - shrink) * unit;
    return value < 0 ? -size : size;
  };
  wavelet::SparseBand sparse;
  sparse.edges.reserve(band.points.size());
  sparse.details.reserve(band.points.size());
  for (const auto& [edge, point] : band.points) {
    sparse.edges.push_back(edge);
    sparse.details.emplace_back(component(point[0], step), component(point[1], tangential_step),
                                component(point[2], tangential_step));
  }
  return sparse;
}

Result<std::vector<wavelet::SparseBand>> decode_best_bands(std::span<const std::uint8_t> bytes,
                                                           const StreamLayout& layout,
                                                           const Topology& topology, int levels) {
  entropy::DetailModel model;
  std::vector<wavelet::SparseBand> bands(static_cast<std::size_t>(levels));
  const BandEntry* coarser = nullptr;
  for (std::size_t j = 0; j < bands.size() && j < layout.header.bands.size(); ++j) {
    const BandEntry& entry = layout.header.bands[j];
    const SectionRange& section = layout.sections[2 + j];
    const auto payload = read_section(bytes, section);
    if (!payload) return payload.error();
    const bool is_coded = entry.payload_bytes > 0;
    const auto level = static_cast<int>(j);
    const entropy::BandPlace place{
        &topology.level(level), level > 0 ? &topology.level(level - 1) : nullptr, level,
        coarser != nullptr && is_coded ? coarser->step_index - entry.step_index : 0};
    const auto band = entropy::decode_details(*payload, place, model);
    if (!band) {
      return Error{ErrorCode::kCorruptStream,
                   "a band does not decode: " + band.error().message + " (byte " +
                       std::to_string(section.offset) + ")",
                   section.offset};
    }
    coarser = is_coded ? &entry : nullptr;
    if (is_coded) bands[j] = reconstruct(*band, step_size(entry.step_index));
  }
  return bands;
}

}  // namespace nacre::codec
