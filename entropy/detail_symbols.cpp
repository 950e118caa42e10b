// SPDX-License-Identifier: GPL-3.0-or-later
#include "entropy/detail_symbols.h"

#include <algorithm>
#include <cstdlib>

#include "entropy/detail_reader.h"

namespace nacre::entropy {
namespace {

constexpr DetailPoint kZero = {0, 0, 0};
constexpr std::uint8_t kRises = 1, kMoves = 2;

Error corrupt(const char* what, std::size_t where) {
  return {ErrorCode::kCorruptStream, what, where};
}

Result<void> check(const BandSymbols& band, std::size_t count) {
  if (band.points.size() != count)
    return Error{ErrorCode::kBadInput, "needs one point per detail", band.points.size()};
  for (std::size_t e = 0; e < count; ++e)
    for (const std::int32_t value : band.points[e])
      if (value < -kMaxDetail || value > kMaxDetail)
        return Error{ErrorCode::kBadInput, "a quantised detail lies past 2^24", e};
  for (const int shrink : band.shrink_32nds)
    if (shrink < kLeastShrink || shrink > kMostShrink)
      return Error{ErrorCode::kBadInput, "an offset must lie in -8 .. 7", 0};
  if (band.ratio_quarters < 0 || band.ratio_quarters > 15)
    return Error{ErrorCode::kBadInput, "the ratio of steps must lie in 0 .. 15", 0};
  return {};
}

bool is_zero(const BandSymbols& band) {
  return std::ranges::all_of(band.points, [](const DetailPoint& p) { return p == kZero; });
}

/// What the head of a block must say for its points to be possible.
std::uint8_t needed(const BandSymbols& band, std::size_t first, std::uint64_t active) {
  std::uint8_t head = 0;
  const std::size_t end = std::min(first + kBlockDetails, band.points.size());
  for (std::size_t e = first; e < end; ++e) {
    const DetailPoint& p = band.points[e];
    if (p[0] != 0 && (active >> (e - first) & 1) == 0) head |= kRises;
    if (p[1] != 0 || p[2] != 0) head |= kMoves;
  }
  return head;
}

}  // namespace

Result<BandSymbols> read_band_symbols(std::span<const std::uint8_t> payload, const BandPlace& place,
                                      DetailModel& model) {
  BandSymbols band;
  if (payload.empty()) {
    model.skip_band(place);
    return band;
  }
  model.begin_band(place);
  DetailReader reader{ArithmeticDecoder(payload)};
  const BandHead band_head = read_band_head(reader);
  band.has_tangential = band_head.has_tangential;
  band.ratio_quarters = band_head.ratio_quarters;
  const auto count = static_cast<std::uint32_t>(place.level->edges.size());
  band.points.assign(count, kZero);
  BlockHead head;
  for (std::uint32_t e = 0; e < count; ++e) {
    if (e % kBlockDetails == 0) {
      if (reader.decoder.overrun()) break;
      head = code_block_head(reader, model, e / kBlockDetails, band.has_tangential,
                             head.has_tangential, {});
      band.heads.push_back(static_cast<std::uint8_t>((head.quiet_may_rise ? kRises : 0) |
                                                     (head.has_tangential ? kMoves : 0)));
    }
    const DetailContext context = model.look(e);
    if (context.is_quiet && !head.quiet_may_rise && !head.has_tangential) continue;
    band.points[e] = code_detail(reader, model, context, head, kZero);
    model.set(e, band.points[e]);
  }
  if (reader.decoder.overrun())
    return corrupt("the payload ends before the band does", payload.size());
  band.shrink_32nds = read_shrinks(reader);
  if (!reader.decoder.ends_exactly())
    return corrupt("the payload goes on after the band", payload.size());
  if (is_zero(band)) return corrupt("a band of zeros has no payload", payload.size());
  return band;
}

Result<std::vector<std::uint8_t>> write_band_symbols(const BandSymbols& band,
                                                     const BandPlace& place, DetailModel& model) {
  const std::size_t count = place.level->edges.size();
  if (!band.points.empty()) {
    if (const auto ok = check(band, count); !ok) return ok.error();
  }
  if (is_zero(band)) {
    model.skip_band(place);
    return std::vector<std::uint8_t>();
  }
  const bool moves =
      std::ranges::any_of(band.points, [](const DetailPoint& p) { return p[1] != 0 || p[2] != 0; });
  const bool has_tangential = band.has_tangential || moves;
  DetailEncoder encoder(model, place, has_tangential, has_tangential ? band.ratio_quarters : 0);
  for (std::uint32_t e = 0; e < count; ++e) {
    if (e % kBlockDetails == 0) {
      const std::uint32_t block = e / kBlockDetails;
      const std::uint8_t said = block < band.heads.size() ? band.heads[block] : std::uint8_t{0};
      const auto head = static_cast<std::uint8_t>(said | needed(band, e, encoder.active(block)));
      encoder.begin_block(block, (head & kRises) != 0, has_tangential && (head & kMoves) != 0);
    }
    const DetailContext context = encoder.look(e);
    if (encoder.is_open(context)) encoder.put(context, band.points[e]);
  }
  return encoder.finish(band.shrink_32nds);
}

}  // namespace nacre::entropy
