// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>

#include "entropy/detail_coder.h"
#include "entropy/detail_reader.h"

namespace nacre::entropy {
namespace {

/// Decodes a band's details block by block; false if the payload was too short.
bool decode_points(DetailReader& reader, DetailModel& model, std::uint32_t count,
                   bool has_tangential, std::vector<DetailBand::Nonzero>& points, bool sets_zeros) {
  BlockHead head;
  for (std::uint32_t first = 0; first < count; first += kBlockDetails) {
    const std::uint32_t block = first / kBlockDetails, end = std::min(first + kBlockDetails, count);
    head = code_block_head(reader, model, block, has_tangential, head.has_tangential, {});
    const bool all = head.quiet_may_rise || head.has_tangential;
    // Details become active while those before them are decoded, so the set is read anew.
    for (std::uint32_t e = first; e < end; ++e) {
      if (!all) {
        const std::uint64_t left = model.active(block) >> (e - first);
        if (left == 0) break;
        e += static_cast<std::uint32_t>(std::countr_zero(left));
      }
      const DetailContext context = model.look(e);
      const DetailPoint point = code_detail(reader, model, context, head, {0, 0, 0});
      const bool is_zero = point == DetailPoint{0, 0, 0};
      if (!is_zero) points.push_back({e, point});
      if (!is_zero || sets_zeros) model.set(e, point);
    }
    if (reader.decoder.overrun()) return false;
  }
  return true;
}

}  // namespace

Result<DetailBand> decode_details(std::span<const std::uint8_t> payload, const BandPlace& place,
                                  DetailModel& model) {
  DetailBand band;
  if (payload.empty()) {
    model.skip_band(place);
    return band;
  }
  model.begin_band(place);
  const auto corrupt = [&](const char* what) {
    return Error{ErrorCode::kCorruptStream, what, payload.size()};
  };
  DetailReader reader{ArithmeticDecoder(payload)};
  const BandHead band_head = read_band_head(reader);
  band.ratio_quarters = band_head.ratio_quarters;
  const auto count = static_cast<std::uint32_t>(place.level->edges.size());
  if (!decode_points(reader, model, count, band_head.has_tangential, band.points,
                     place.coarser == nullptr))
    return corrupt("the payload ends before the band does");
  band.shrink_32nds = read_shrinks(reader);
  if (band.points.empty()) return corrupt("a band of zeros has no payload");
  if (!reader.decoder.ends_exactly()) return corrupt("the payload goes on after the band");
  return band;
}

}  // namespace nacre::entropy
