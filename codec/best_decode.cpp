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

Result<wavelet::SparseBand> decode_best_band(std::span<const std::uint8_t> payload,
                                             const StreamLayout& layout, const Topology& topology,
                                             int band, entropy::DetailModel& model) {
  const auto j = static_cast<std::size_t>(band);
  const std::vector<BandEntry>& entries = layout.header.bands;
  if (j >= entries.size()) return wavelet::SparseBand();
  const bool is_coded = entries[j].payload_bytes > 0;
  const bool coarser_is_coded = j > 0 && entries[j - 1].payload_bytes > 0;
  const entropy::BandPlace place{
      &topology.level(band), band > 0 ? &topology.level(band - 1) : nullptr, band,
      coarser_is_coded && is_coded ? entries[j - 1].step_index - entries[j].step_index : 0};
  const auto details = entropy::decode_details(payload, place, model);
  if (!details) {
    const std::size_t offset = layout.sections[2 + j].offset;
    return Error{ErrorCode::kCorruptStream,
                 "a band does not decode: " + details.error().message + " (byte " +
                     std::to_string(offset) + ")",
                 offset};
  }
  if (!is_coded) return wavelet::SparseBand();
  return reconstruct(*details, step_size(entries[j].step_index));
}

}  // namespace nacre::codec
