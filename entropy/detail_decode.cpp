// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "entropy/detail_coder.h"
#include "entropy/detail_syntax.h"

namespace nacre::entropy {
namespace {

struct Reader {
  ArithmeticDecoder decoder;

  bool bit(MixedBit mixed, bool) {
    const bool value = decoder.decode_bit(mixed.probability());
    mixed.update(value);
    return value;
  }
  std::uint32_t raw(int count, std::uint32_t) { return decoder.decode_bits(count); }
};

}  // namespace

Result<DetailBand> decode_details(std::span<const std::uint8_t> payload, const BandPlace& place,
                                  DetailModel& model) {
  DetailBand band;
  band.points.assign(place.level->edges.size(), DetailPoint{0, 0, 0});
  model.begin_band(place);
  if (payload.empty()) return band;
  const auto corrupt = [&](const char* what) {
    return Error{ErrorCode::kCorruptStream, what, payload.size()};
  };
  Reader reader{ArithmeticDecoder(payload)};
  const bool has_tangential = reader.raw(1, 0) != 0;
  if (has_tangential) band.ratio_quarters = static_cast<int>(reader.raw(kRatioBits, 0));
  bool any = false;
  for (std::uint32_t e = 0; e < band.points.size(); ++e) {
    const DetailContext context = model.look(e);
    const DetailPoint point = code_detail(reader, model, context, has_tangential, {0, 0, 0});
    model.set(e, point);
    if (point == DetailPoint{0, 0, 0}) continue;
    any = true;
    band.points[e] = point;
    if (reader.decoder.overrun()) return corrupt("the payload ends before the band does");
  }
  for (int& shrink : band.shrink_32nds)
    shrink = static_cast<int>(reader.raw(kShrinkBits, 0)) - kShrinkZero;
  if (!any) return corrupt("a band of zeros has no payload");
  if (!reader.decoder.ends_exactly()) return corrupt("the payload goes on after the band");
  return band;
}

}  // namespace nacre::entropy
