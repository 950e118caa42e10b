// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>

#include "entropy/detail_coder.h"
#include "entropy/detail_reader.h"

namespace nacre::entropy {
namespace {

/// Decodes a band's details block by block.
class BandReader {
 public:
  BandReader(DetailReader& reader, DetailModel& model, std::uint32_t count, bool sets_zeros,
             std::vector<DetailBand::Nonzero>& points)
      : reader_(reader), model_(model), count_(count), sets_zeros_(sets_zeros), points_(points) {}

  /// False if the payload was too short.
  bool run(bool has_tangential) {
    BlockHead head;
    for (std::uint32_t first = 0; first < count_; first += kBlockDetails) {
      head = code_block_head(reader_, model_, first / kBlockDetails, has_tangential,
                             head.has_tangential, {});
      if (head.has_tangential) {
        read_block(reader_, first, head);
      } else {
        // A copy that nothing else can see stays in registers.
        DetailReader reader = reader_;
        read_block(reader, first, {head.quiet_may_rise, false});
        reader_ = reader;
      }
      if (reader_.decoder.overrun()) return false;
    }
    return true;
  }

 private:
  void read_block(DetailReader& reader, std::uint32_t first, const BlockHead& head) {
    const std::uint32_t block = first / kBlockDetails;
    const std::uint32_t end = std::min(first + kBlockDetails, count_);
    const bool all = head.quiet_may_rise || head.has_tangential;
    // Details become active while those before them are decoded, so the set is read anew.
    for (std::uint32_t e = first; e < end; ++e) {
      if (!all) {
        const std::uint64_t left = model_.active(block) >> (e - first);
        if (left == 0) break;
        e += static_cast<std::uint32_t>(std::countr_zero(left));
      }
      const DetailContext context = model_.look(e);
      const DetailPoint point = code_detail(reader, model_, context, head, {0, 0, 0});
      const bool is_zero = point == DetailPoint{0, 0, 0};
      if (!is_zero) points_.push_back({e, point});
      if (!is_zero || sets_zeros_) model_.set(e, point);
    }
  }

  DetailReader& reader_;
  DetailModel& model_;
  std::uint32_t count_;
  bool sets_zeros_;  ///< the model is told of details that are zero as well
  std::vector<DetailBand::Nonzero>& points_;
};

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
  if (!BandReader(reader, model, count, place.coarser == nullptr, band.points)
           .run(band_head.has_tangential))
    return corrupt("the payload ends before the band does");
  band.shrink_32nds = read_shrinks(reader);
  if (band.points.empty()) return corrupt("a band of zeros has no payload");
  if (!reader.decoder.ends_exactly()) return corrupt("the payload goes on after the band");
  return band;
}

}  // namespace nacre::entropy
