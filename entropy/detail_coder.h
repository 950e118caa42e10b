// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/result.h"
#include "entropy/arithmetic.h"
#include "entropy/detail_model.h"
#include "entropy/detail_syntax.h"

/// Quantised details of a band ↔ bytes, with contexts from the mesh. See README.md.
namespace nacre::entropy {

inline constexpr int kLeastShrink = -8, kMostShrink = 7;

/// A band's quantised details, and what is needed to make them details again.
struct DetailBand {
  /// A detail that is not zero.
  struct Nonzero {
    std::uint32_t edge = 0;
    DetailPoint point{};
  };
  std::vector<Nonzero> points;  ///< by increasing edge
  /// Offset toward zero of magnitudes 1, 2, and more, in 1/32 steps: kLeastShrink .. kMostShrink.
  std::array<int, 3> shrink_32nds{};
  int ratio_quarters = 0;  ///< tangential step / step = 1 + it / 4; 0 .. 15
};

/// Decodes one band. An empty payload is a band of zeros. `model` goes from band to band, coarse
/// to fine.
///
/// Errors   kCorruptStream: any bytes that DetailEncoder does not write.
[[nodiscard]] Result<DetailBand> decode_details(std::span<const std::uint8_t> payload,
                                                const BandPlace& place, DetailModel& model);

/// Encoder. Codes one band detail by detail, so that the caller can choose each value by its cost.
class DetailEncoder {
 public:
  /// With `has_tangential` false no point may have a tangential part.
  DetailEncoder(DetailModel& model, const BandPlace& place, bool has_tangential,
                int ratio_quarters);

  /// Before detail kBlockDetails * block: what the block's details may be.
  void begin_block(std::uint32_t block, bool quiet_may_rise, bool has_tangential);
  /// Details come in order; each is looked at, perhaps costed, and put.
  [[nodiscard]] DetailContext look(std::uint32_t e) const { return model_.look(e); }
  [[nodiscard]] std::uint64_t active(std::uint32_t block) const { return model_.active(block); }
  /// False if `context` lets the detail be nothing but zero: it need not be put.
  [[nodiscard]] bool is_open(const DetailContext& context) const {
    return normal_is_open(context) || head_.has_tangential;
  }
  [[nodiscard]] bool normal_is_open(const DetailContext& context) const {
    return !context.is_quiet || head_.quiet_may_rise;
  }
  /// Bits that a normal component would take now, in 1/4096 of a bit, for magnitudes up to
  /// least_of_class(kMagnitudeClasses - 1). Not for a quiet detail where they may not rise.
  [[nodiscard]] std::uint64_t normal_cost(const DetailContext& context, std::int32_t normal);
  /// Bits for a tangential part, `any` of it and its flag, beside a given normal component.
  [[nodiscard]] std::uint64_t tangential_cost(const DetailContext& context,
                                              const DetailPoint& point);
  void put(const DetailContext& context, const DetailPoint& point);
  [[nodiscard]] std::vector<std::uint8_t> finish(const std::array<int, 3>& shrink_32nds);

 private:
  DetailModel& model_;
  ArithmeticEncoder coder_;
  bool has_tangential_;
  BlockHead head_;
};

/// Makes `model` what it is after coding `band`; for learning. Without payload: skip_band().
void show_details(const DetailBand& band, bool is_coded, const BandPlace& place,
                  DetailModel& model);

}  // namespace nacre::entropy
