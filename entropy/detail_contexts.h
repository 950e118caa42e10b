// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cstdlib>

#include "entropy/detail_model.h"

/// The part of DetailModel that every bit goes through, inline: contexts and their counters.
namespace nacre::entropy {

namespace contexts {

/// What the running average weighs in band 0.
inline constexpr int kAverageWeight = 40;

/// Two to an octave: 0, 1, 2, 3, 4-5, 6-7, 8-11, ...
inline int log_bin(std::int32_t value) {
  if (value < 2) return value;
  const int k = static_cast<int>(std::bit_width(static_cast<std::uint32_t>(value))) - 1;
  return 2 * k + ((value >> (k - 1)) & 1);
}

inline constexpr std::array<std::uint8_t, 10> kSmall = {0, 1, 2, 3, 3, 4, 4, 4, 4, 5};
inline int small_sum(int sum) { return kSmall[static_cast<std::size_t>(std::min(sum, 9))]; }
inline int sign3(int value) { return value < 0 ? 0 : (value == 0 ? 1 : 2); }
inline int sign5(int value) { return std::clamp(value, -2, 2) + 2; }
/// 32 values, symmetric.
inline int signed_bin(int mean) {
  const int bin = std::min(log_bin(std::abs(mean) / 8), 15);
  return mean < 0 ? 15 - bin : 16 + bin;
}

inline std::size_t at(int index) { return static_cast<std::size_t>(index); }

inline int near(const Surroundings& a) { return small_sum(a.few(kNear)); }
inline int far(const Surroundings& a) { return small_sum(a.few(kFar)); }
inline int beside(const Surroundings& a) { return small_sum(a.few(kBeside)); }
inline int beyond(const Surroundings& a) { return small_sum(a.few(kFar) + a.few(kBeyond)); }
inline int first(const Surroundings& a) { return small_sum(a.few(kNear) + a.few(kBeside)); }

}  // namespace contexts

inline DetailContext DetailModel::look(std::uint32_t e) const {
  DetailContext c;
  const Surroundings& around = around_[e];
  const bool has_coarser = place_.coarser != nullptr;
  c.detail = e;
  c.around = &around;
  c.kind = kind_of(e);
  c.is_quiet = (active_[e / kBlockDetails] >> (e % kBlockDetails) & 1) == 0;
  if (c.is_quiet) return c;
  c.is_faint = has_coarser && around.few(kNear) + around.few(kBeside) + around.parent() == 0;
  int expected = around.sum(Surroundings::kBand);
  if (has_coarser) {
    c.inherited = around.sum(Surroundings::kBelow) / 16;
    expected += c.inherited;
  } else {
    const int weight = around.sum(Surroundings::kBelow) + contexts::kAverageWeight;
    expected = static_cast<int>(
        (256 * std::int64_t{expected} + contexts::kAverageWeight * std::int64_t{average_}) /
        weight);
  }
  c.mean = around.sum(Surroundings::kMean) / 16;
  c.expected_bin = contexts::log_bin(expected);
  return c;
}

inline SingleBit DetailModel::quiet_may_rise(bool has_active) {
  return SingleBit(counter(kRise, 2 * level() + (has_active ? 1 : 0)));
}

inline SingleBit DetailModel::block_has_tangential(bool last_block_has) {
  return SingleBit(counter(kBlockTangential, 2 * level() + (last_block_has ? 1 : 0)));
}

inline SingleBit DetailModel::faint_is_nonzero(const DetailContext& c) {
  if (c.is_quiet) return SingleBit(counter(kQuiet, 3 * level() + c.kind));
  return SingleBit(counter(kFaint, (3 * level() + c.kind) * 32 + std::min(c.expected_bin, 31)));
}

inline MixedBit<7> DetailModel::is_nonzero(const DetailContext& c) {
  using namespace contexts;
  const Surroundings& a = *c.around;
  const int expected = std::min(c.expected_bin, 31), inherited = std::min(log_bin(c.inherited), 15);
  const int parent = std::min(log_bin(a.parent() * ratio_ / 2) / 2, 8);
  const int near = contexts::near(a), far = contexts::far(a), first = contexts::first(a);
  const int beside = std::min(contexts::beside(a), 3), beyond = contexts::beyond(a);
  return {weights_.zero[at(16 * c.kind + expected / 2)],
          {&counter(kZero0, 32 * c.kind + expected),
           &counter(kZero1, (4 * level() + c.kind) * 16 + expected / 2),
           &counter(kZero2, ((near * 6 + far) * 4 + beside) * 3 + c.kind),
           &counter(kZero3, (parent * 16 + inherited) * 3 + c.kind),
           &counter(kZero4, (first * 16 + inherited) * 3 + c.kind),
           &counter(kZero5, (beyond * 16 + inherited) * 6 + first),
           &counter(kZero6, (std::min(log_bin(std::abs(c.mean) / 8), 15) * 16 + expected / 2) * 3 +
                                c.kind)}};
}

inline MixedBit<4> DetailModel::is_negative(const DetailContext& c) {
  using namespace contexts;
  const int mean = signed_bin(c.mean), expected = std::min(c.expected_bin / 2, 7);
  const Surroundings& a = *c.around;
  const int near = a.sign(kNear), far = a.sign(kFar), beside = a.sign(kBeside);
  const int around = (sign3(near) * 3 + sign3(far)) * 3 + sign3(beside);
  return {
      weights_.sign[at(c.kind)],
      {&counter(kSign0, 3 * mean + c.kind), &counter(kSign1, (8 * mean + expected) * 3 + c.kind),
       &counter(kSign2, ((sign5(near) * 5 + sign5(far)) * 5 + sign5(beside)) * 3 + c.kind),
       &counter(kSign3, 9 * around + 3 * sign3(a.sign(kParents)) + sign3(a.sign(kOthers)))}};
}

inline MixedBit<6> DetailModel::is_above(const DetailContext& c, bool negative,
                                         int magnitude_class) {
  using namespace contexts;
  const int least = least_of_class(magnitude_class + 1);
  const Surroundings& a = *c.around;
  const int inherited = std::min(log_bin(c.inherited), 15), first = contexts::first(a);
  // log_bin(256 least)
  const int scale = 16 + log_bin(least);
  const int expected = std::min(c.expected_bin, 47);
  const int relative = std::clamp(expected - scale + 20, 0, 31);
  const int few = std::min(magnitude_class, 3), many = std::min(magnitude_class, 19);
  const int toward = negative ? -c.mean : c.mean;
  // The usual divisor known when this is compiled.
  const int relative_mean = magnitude_class == 0 ? toward / 64 : toward / (32 * least);
  const int bin = std::clamp(relative_mean - 8, -20, 11) + 20;
  return {weights_.above[at(few)],
          {&counter(kAbove0, 32 * few + relative), &counter(kAbove1, 48 * many + expected),
           &counter(kAbove2, (8 * many + level()) * 3 + c.kind),
           &counter(kAbove3, (few * 24 + std::clamp(inherited - scale + 20, 0, 23)) * 6 + first),
           &counter(kAbove4, ((6 * many + contexts::far(a)) * 6 + first) * 3 + c.kind),
           &counter(kAbove5, (few * 32 + bin) * 32 + relative)}};
}

inline MixedBit<3> DetailModel::has_tangential(const DetailContext& c, bool normal_is_zero) {
  using namespace contexts;
  const int around = std::min(c.around->tangential(), 3);
  const int edge = place_.level->edges[c.detail].is_boundary() ? 1 : 0;
  return {
      weights_.tangential[at(edge)],
      {&counter(kTangential0, ((edge * 4 + around) * 2 + (normal_is_zero ? 1 : 0)) * 3 + c.kind),
       &counter(kTangential1, (edge * 8 + level()) * 4 + around),
       &counter(kTangential2, edge * 16 + std::min(c.expected_bin / 2, 15))}};
}

inline MixedBit<2> DetailModel::tangential_is_nonzero(const DetailContext& c, int component) {
  const int place = 2 * component + (place_.level->edges[c.detail].is_boundary() ? 1 : 0);
  return {weights_.tangential_zero,
          {&counter(kTangentialZero0, 4 * place + std::min(c.around->tangential(), 3)),
           &counter(kTangentialZero1, 3 * place + c.kind)}};
}

inline SingleBit DetailModel::tangential_is_negative(const DetailContext& c, int component) {
  const int edge = place_.level->edges[c.detail].is_boundary() ? 1 : 0;
  return SingleBit(counter(kTangentialSign, 2 * component + edge));
}

inline MixedBit<2> DetailModel::tangential_is_above(const DetailContext& c, int component,
                                                    int magnitude_class) {
  using namespace contexts;
  const int around = std::min(log_bin(c.around->tangential()), 7);
  return {weights_.tangential_above,
          {&counter(kTangentialAbove0, component * kMagnitudeClasses + magnitude_class),
           &counter(kTangentialAbove1, around * kMagnitudeClasses + magnitude_class)}};
}

}  // namespace nacre::entropy
