// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>

#include "entropy/detail_model.h"

/// The order of a detail's bits, once for the encoder and the decoder. A Coder has
///   bool bit(Bit bit, bool value)         codes a SingleBit or MixedBit; a decoder returns its own
///   uint32_t raw(int count, uint32_t bits)
namespace nacre::entropy {

/// A magnitude of at least 1: its class in unary, then where it lies in the class.
template <class Coder, class IsAbove>
std::int32_t code_magnitude(Coder& coder, std::int32_t magnitude, const IsAbove& is_above) {
  int c = 0;
  const int own = magnitude > 0 ? magnitude_class(magnitude) : 0;
  while (c < kMagnitudeClasses - 1 && coder.bit(is_above(c), own > c)) ++c;
  std::int32_t rest = magnitude - least_of_class(c), value = 0;
  for (int left = raw_bits_of_class(c); left > 0;) {
    const int count = left < 16 ? left : 16;
    left -= count;
    const auto piece = static_cast<std::uint32_t>(rest >> left) & 0xFFFFu;
    value |= static_cast<std::int32_t>(coder.raw(count, piece)) << left;
    rest &= (1 << left) - 1;
  }
  return least_of_class(c) + value;
}

template <class Coder>
std::int32_t code_normal(Coder& coder, DetailModel& model, const DetailContext& context,
                         std::int32_t normal) {
  const bool any = context.is_faint ? coder.bit(model.faint_is_nonzero(context), normal != 0)
                                    : coder.bit(model.is_nonzero(context), normal != 0);
  if (!any) return 0;
  const bool negative = coder.bit(model.is_negative(context), normal < 0);
  const std::int32_t magnitude = code_magnitude(
      coder, std::abs(normal), [&](int c) { return model.is_above(context, negative, c); });
  return negative ? -magnitude : magnitude;
}

template <class Coder>
DetailPoint code_tangential(Coder& coder, DetailModel& model, const DetailContext& context,
                            DetailPoint point) {
  const bool any =
      coder.bit(model.has_tangential(context, point[0] == 0), point[1] != 0 || point[2] != 0);
  if (!any) return {point[0], 0, 0};
  for (int i = 0; i < 2; ++i) {
    std::int32_t& value = point[static_cast<std::size_t>(1 + i)];
    // One of the two is there: if not across, then along.
    const bool is_certain = i == 1 && point[1] == 0;
    if (!is_certain && !coder.bit(model.tangential_is_nonzero(context, i), value != 0)) {
      value = 0;
      continue;
    }
    const bool negative = coder.bit(model.tangential_is_negative(context, i), value < 0);
    value = code_magnitude(coder, std::abs(value),
                           [&](int c) { return model.tangential_is_above(context, i, c); });
    if (negative) value = -value;
  }
  return point;
}

/// What a block's head says.
struct BlockHead {
  bool quiet_may_rise = false;  ///< details with zeros around need not be zero
  bool has_tangential = false;
};

template <class Coder>
BlockHead code_block_head(Coder& coder, DetailModel& model, std::uint32_t block,
                          bool band_has_tangential, bool last_has_tangential, BlockHead head) {
  BlockHead coded;
  const std::uint64_t active = model.active(block);
  if (active != model.all_of(block))
    coded.quiet_may_rise = coder.bit(model.quiet_may_rise(active != 0), head.quiet_may_rise);
  if (band_has_tangential) {
    coded.has_tangential =
        coder.bit(model.block_has_tangential(last_has_tangential), head.has_tangential);
  }
  return coded;
}

template <class Coder>
DetailPoint code_detail(Coder& coder, DetailModel& model, const DetailContext& context,
                        const BlockHead& head, DetailPoint point) {
  if (context.is_quiet && !head.quiet_may_rise) {
    point[0] = 0;
  } else {
    point[0] = code_normal(coder, model, context, point[0]);
  }
  if (head.has_tangential) return code_tangential(coder, model, context, point);
  return {point[0], 0, 0};
}

inline constexpr int kShrinkBits = 4, kShrinkZero = 8, kRatioBits = 4;

}  // namespace nacre::entropy
