// SPDX-License-Identifier: Apache-2.0
//
// Read me first: neighbouring details have similar magnitudes, and so have a band's and the
// coarser one's at the same place. A weighted sum of those around gives the magnitude expected;
// the bits' probabilities are learnt for each of its (logarithmic) values, and for finer
// descriptions of the neighbourhood, and mixed. Normals of neighbours also go the same way more
// often than not (the butterfly undershoots where the surface bends), hence the expected value.
//
// Most details are zero, so nothing is gathered: each detail that is not zero adds what it means
// to those around it that are still to come, and where nothing was added nothing is looked at.
#include "entropy/detail_model.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstdlib>

#include "entropy/detail_start.h"

namespace nacre::entropy {
namespace {

constexpr std::int32_t kLargestSeen = 4095;

/// What a magnitude of 1 adds to the magnitude expected, in 1/256, by the kind of the one that
/// expects (3: band 0) and where the other is: its other half; first ring, outer and inner edges;
/// second ring, outer and inner edges.
constexpr std::array<std::array<int, 5>, 4> kMagnitudeWeights = {
    {{0, 35, 0, 15, 0}, {40, 31, 0, 11, 0}, {0, 36, 20, 15, 6}, {0, 30, 0, 8, 0}}};
/// The same for values, in 1/256.
constexpr std::array<std::array<int, 5>, 4> kValueWeights = {
    {{0, 48, 0, -14, 0}, {-27, 54, 0, -17, 0}, {0, 37, 43, -6, -16}, {0, 20, 0, 0, 0}}};
/// And for those of the coarser band: parent, uncle, cousin; in 1/512 of a coarser step.
constexpr std::array<std::array<int, 3>, 3> kInheritedWeights = {
    {{32, 15, 12}, {32, 13, 8}, {6, 16, 4}}};
constexpr std::array<std::array<int, 3>, 3> kInheritedValueWeights = {
    {{12, 0, 0}, {16, 0, 0}, {4, 6, -4}}};
/// What the running average weighs in band 0.
constexpr int kAverageWeight = 40;

/// Groups of neighbours whose magnitudes and signs are told apart, and the first four by the
/// columns above.
enum Group : std::size_t { kNear, kFar, kBeside, kBeyond, kParents, kOthers };
constexpr std::array<Group, 5> kGroups = {kBeside, kNear, kBeside, kFar, kBeyond};

enum Role { kParent, kUncle, kCousin };

/// 2^15 2^(k/32), rounded.
constexpr std::array<std::int32_t, 32> kStepPowers = {
    32768, 33486, 34219, 34968, 35734, 36516, 37316, 38133, 38968, 39821, 40693,
    41584, 42495, 43425, 44376, 45348, 46341, 47356, 48393, 49452, 50535, 51642,
    52773, 53928, 55109, 56316, 57549, 58809, 60097, 61413, 62757, 64132};

/// 256 2^(excess / 32), for excesses of -8 .. 4 octaves.
std::int32_t step_ratio(int excess) {
  excess = std::clamp(excess, -256, 128);
  const int octave = excess >= 0 ? excess / 32 : -((31 - excess) / 32);
  const std::int64_t mantissa = kStepPowers[static_cast<std::size_t>(excess - 32 * octave)];
  return static_cast<std::int32_t>((mantissa << (octave + 8)) >> 15);
}

/// Two to an octave: 0, 1, 2, 3, 4-5, 6-7, 8-11, ...
int log_bin(std::int32_t value) {
  if (value < 2) return value;
  const int k = static_cast<int>(std::bit_width(static_cast<std::uint32_t>(value))) - 1;
  return 2 * k + ((value >> (k - 1)) & 1);
}

constexpr std::array<std::uint8_t, 9> kSmall = {0, 1, 2, 3, 3, 4, 4, 4, 4};
int small_sum(int sum) { return sum > 8 ? 5 : kSmall[static_cast<std::size_t>(sum)]; }
int sign3(int value) { return value < 0 ? 0 : (value == 0 ? 1 : 2); }
int sign5(int value) { return std::clamp(value, -2, 2) + 2; }
/// 32 values, symmetric.
int signed_bin(int mean) {
  const int bin = std::min(log_bin(std::abs(mean) / 8), 15);
  return mean < 0 ? 15 - bin : 16 + bin;
}

std::size_t at(int index) { return static_cast<std::size_t>(index); }

int few_signed(int value) { return std::clamp(value, -10, 10); }

std::uint32_t face_beyond(const Edge& edge, std::uint32_t face) {
  return edge.face[0] == face ? edge.face[1] : edge.face[0];
}

}  // namespace

int magnitude_class(std::int32_t magnitude) {
  if (magnitude <= 4) return magnitude - 1;
  const auto m = static_cast<std::uint32_t>(magnitude - 1);
  const int k = static_cast<int>(std::bit_width(m)) - 1;
  return 2 * k + static_cast<int>((m >> (k - 1)) & 1);
}

std::int32_t least_of_class(int c) {
  if (c < 4) return c + 1;
  return ((2 + (c & 1)) << (c / 2 - 1)) + 1;
}

int raw_bits_of_class(int c) { return c < 4 ? 0 : c / 2 - 1; }

DetailModel::DetailModel(Start start) {
  static_assert(kCounters == kCounterStarts);
  if (start == Start::kBlank) return;
  for (std::size_t i = 0; i < kCounters; ++i) {
    if (kStarts[i] == kNo) continue;
    counters_[i] = BitCounter(squash(32 * kStarts[i]), kStartCount);
  }
}

void DetailModel::skip_band(const BandPlace& place) {
  place_ = place;
  nonzero_.clear();
}

void DetailModel::begin_band(const BandPlace& place) {
  const auto count = static_cast<std::uint32_t>(place.level->edges.size());
  place_ = place;
  ratio_ = step_ratio(place.coarser_step_excess);
  average_ = 512;
  coarser_nonzero_.swap(nonzero_);
  nonzero_.clear();
  around_.assign(count, Around{});
  active_.assign((count + kBlockDetails - 1) / kBlockDetails, place.coarser ? 0 : ~0ull);
  if (count % kBlockDetails != 0) active_.back() &= (1ull << (count % kBlockDetails)) - 1;
  inner_begin_ = place.coarser ? 2 * static_cast<std::uint32_t>(place.coarser->edges.size()) : 0;
  if (!place.coarser) return;
  for (std::size_t kind = 0; kind < 3; ++kind) {
    for (std::size_t role = 0; role < 3; ++role) {
      inherited_weights_[kind][role] = kInheritedWeights[kind][role] * ratio_ / 32;
      inherited_value_weights_[kind][role] = kInheritedValueWeights[kind][role] * ratio_ / 32;
    }
  }
  for (const Nonzero& source : coarser_nonzero_) spread_below(source);
}

void DetailModel::set(std::uint32_t e, const DetailPoint& point) {
  const std::int64_t sum = std::abs(std::int64_t{point[1]}) + std::abs(std::int64_t{point[2]});
  const Nonzero source = {
      e, static_cast<std::int16_t>(std::clamp(point[0], -kLargestSeen, kLargestSeen)),
      static_cast<std::uint8_t>(std::min<std::int64_t>(sum, 12))};
  const bool is_zero = source.normal == 0 && source.tangential == 0;
  if (!is_zero) nonzero_.push_back(source);
  if (place_.coarser == nullptr) {
    average_ += (256 * std::abs(source.normal) - average_) / 32;
  } else if (is_zero) {
    return;
  }
  spread_in_band(source);
}

/// `ring`: 0 the other half, 1 first, 3 second.
inline void DetailModel::add_in_band(const Nonzero& source, std::uint32_t target, int ring) {
  if (target <= source.detail) return;
  Around& around = around_[target];
  const bool is_inner = source.detail >= inner_begin_ && place_.coarser != nullptr;
  const bool has_coarser = place_.coarser != nullptr;
  const std::size_t row = has_coarser ? at(kind_of(target)) : 3;
  const std::size_t column = at(ring) + (is_inner ? 1 : 0);
  const int magnitude = std::abs(source.normal);
  around.band += kMagnitudeWeights[row][column] * magnitude;
  around.mean += 16 * kValueWeights[row][column] * source.normal;
  if (!has_coarser) around.below += kMagnitudeWeights[row][column];
  const std::size_t group = kGroups[column];
  around.few[group] = static_cast<std::uint8_t>(around.few[group] + std::min(magnitude, 15));
  around.signs[group] = static_cast<std::int8_t>(around.signs[group] + few_signed(source.normal));
  around.tangential = static_cast<std::uint8_t>(around.tangential + source.tangential);
  active_[target / kBlockDetails] |= 1ull << (target % kBlockDetails);
}

void DetailModel::spread_in_band(const Nonzero& source) {
  const LevelTopology& level = *place_.level;
  const std::uint32_t e = source.detail;
  if (e < inner_begin_) add_in_band(source, e ^ 1u, 0);
  for (const std::uint32_t face : level.edges[e].face) {
    if (face == kNone) continue;
    for (const std::uint32_t first : level.triangle_edges[face]) {
      if (first == e) continue;
      add_in_band(source, first, 1);
      const std::uint32_t beyond = face_beyond(level.edges[first], face);
      if (beyond == kNone) continue;
      for (const std::uint32_t second : level.triangle_edges[beyond])
        if (second != first) add_in_band(source, second, 3);
    }
  }
}

inline void DetailModel::add_below(const Nonzero& source, std::uint32_t target, int role) {
  Around& around = around_[target];
  const std::size_t kind = at(kind_of(target));
  const int magnitude = std::abs(source.normal);
  around.below += magnitude * inherited_weights_[kind][at(role)];
  around.mean += source.normal * inherited_value_weights_[kind][at(role)];
  if (role == kParent)
    around.parent = static_cast<std::uint16_t>(around.parent + (kind < 2 ? 2 : 1) * magnitude);
  const std::size_t group = role == kParent ? kParents : kOthers;
  around.signs[group] = static_cast<std::int8_t>(around.signs[group] + few_signed(source.normal));
  around.tangential = static_cast<std::uint8_t>(around.tangential + source.tangential / 2);
  active_[target / kBlockDetails] |= 1ull << (target % kBlockDetails);
}

void DetailModel::spread_below(const Nonzero& source) {
  const LevelTopology& level = *place_.coarser;
  const std::uint32_t parent = source.detail;
  const Edge& own = level.edges[parent];
  add_below(source, 2 * parent, kParent);
  add_below(source, 2 * parent + 1, kParent);
  for (const std::uint32_t face : own.face) {
    if (face == kNone) continue;
    const Triangle& sides = level.triangle_edges[face];
    for (std::uint32_t k = 0; k < 3; ++k) {
      // Inner edge k cuts off corner k, between sides k and k + 2.
      const bool touches = sides[k] == parent || sides[(k + 2) % 3] == parent;
      add_below(source, inner_begin_ + 3 * face + k, touches ? kParent : kUncle);
      const std::uint32_t side = sides[k];
      if (side == parent) continue;
      const Edge& edge = level.edges[side];
      for (std::uint32_t h = 0; h < 2; ++h) {
        const bool meets = edge.vertex[h] == own.vertex[0] || edge.vertex[h] == own.vertex[1];
        add_below(source, 2 * side + h, meets ? kUncle : kCousin);
      }
      const std::uint32_t beyond = face_beyond(edge, face);
      if (beyond == kNone) continue;
      const Triangle& far = level.triangle_edges[beyond];
      for (std::uint32_t i = 0; i < 3; ++i)
        if (far[i] == side || far[(i + 2) % 3] == side)
          add_below(source, inner_begin_ + 3 * beyond + i, kCousin);
    }
  }
}

DetailContext DetailModel::look(std::uint32_t e) const {
  DetailContext c;
  const Around& around = around_[e];
  const bool has_coarser = place_.coarser != nullptr;
  c.detail = e;
  c.kind = kind_of(e);
  c.is_quiet = (active_[e / kBlockDetails] >> (e % kBlockDetails) & 1) == 0;
  c.is_faint = has_coarser && around.few[kNear] + around.few[kBeside] + around.parent == 0;
  c.tangential = around.tangential;
  if (c.is_quiet) return c;
  int inherited = 0;
  if (has_coarser) {
    inherited = around.below / 16;
    c.expected = around.band + inherited;
  } else {
    c.expected = static_cast<int>(
        (256 * std::int64_t{around.band} + kAverageWeight * std::int64_t{average_}) /
        (around.below + kAverageWeight));
  }
  c.mean = around.mean / 16;
  c.expected_bin = log_bin(c.expected);
  c.inherited_bin = std::min(log_bin(inherited), 15);
  c.parent_bin = std::min(log_bin(around.parent * ratio_ / 2) / 2, 8);
  c.near = small_sum(around.few[kNear]);
  c.far = small_sum(around.few[kFar]);
  c.beside = small_sum(around.few[kBeside]);
  c.beyond = small_sum(around.few[kFar] + around.few[kBeyond]);
  c.first = small_sum(around.few[kNear] + around.few[kBeside]);
  c.signs = around.signs;
  return c;
}

MixedBit DetailModel::quiet_may_rise(bool has_active) {
  MixedBit bit;
  bit.add(counter(kRise, 2 * level() + (has_active ? 1 : 0)));
  bit.predict_alone();
  return bit;
}

MixedBit DetailModel::block_has_tangential(bool last_block_has) {
  MixedBit bit;
  bit.add(counter(kBlockTangential, 2 * level() + (last_block_has ? 1 : 0)));
  bit.predict_alone();
  return bit;
}

MixedBit DetailModel::is_nonzero(const DetailContext& c) {
  MixedBit bit;
  if (c.is_quiet) {
    bit.add(counter(kQuiet, 3 * level() + c.kind));
    bit.predict_alone();
    return bit;
  }
  const int expected = std::min(c.expected_bin, 31);
  if (c.is_faint) {
    bit.add(counter(kFaint, (3 * level() + c.kind) * 32 + expected));
    bit.predict_alone();
    return bit;
  }
  const int beside = std::min(c.beside, 3);
  bit.add(counter(kZero0, 32 * c.kind + expected));
  bit.add(counter(kZero1, (4 * level() + c.kind) * 16 + expected / 2));
  bit.add(counter(kZero2, ((c.near * 6 + c.far) * 4 + beside) * 3 + c.kind));
  bit.add(counter(kZero3, (c.parent_bin * 16 + c.inherited_bin) * 3 + c.kind));
  bit.add(counter(kZero4, (c.first * 16 + c.inherited_bin) * 3 + c.kind));
  bit.add(counter(kZero5, (c.beyond * 16 + c.inherited_bin) * 6 + c.first));
  bit.add(counter(kZero6,
                  (std::min(log_bin(std::abs(c.mean) / 8), 15) * 16 + expected / 2) * 3 + c.kind));
  bit.predict(weights_.zero[at(16 * c.kind + expected / 2)]);
  return bit;
}

MixedBit DetailModel::is_negative(const DetailContext& c) {
  MixedBit bit;
  const int mean = signed_bin(c.mean), expected = std::min(c.expected_bin / 2, 7);
  bit.add(counter(kSign0, 3 * mean + c.kind));
  bit.add(counter(kSign1, (8 * mean + expected) * 3 + c.kind));
  const auto& v = c.signs;
  bit.add(counter(kSign2,
                  ((sign5(v[kNear]) * 5 + sign5(v[kFar])) * 5 + sign5(v[kBeside])) * 3 + c.kind));
  const int around = (sign3(v[kNear]) * 3 + sign3(v[kFar])) * 3 + sign3(v[kBeside]);
  bit.add(counter(kSign3, 9 * around + 3 * sign3(v[kParents]) + sign3(v[kOthers])));
  bit.predict(weights_.sign[at(c.kind)]);
  return bit;
}

MixedBit DetailModel::is_above(const DetailContext& c, bool negative, int magnitude_class) {
  MixedBit bit;
  const int least = least_of_class(magnitude_class + 1);
  // log_bin(256 least)
  const int scale = 16 + log_bin(least);
  const int expected = std::min(c.expected_bin, 47);
  const int relative = std::clamp(expected - scale + 20, 0, 31);
  const int few = std::min(magnitude_class, 3), many = std::min(magnitude_class, 19);
  bit.add(counter(kAbove0, 32 * few + relative));
  bit.add(counter(kAbove1, 48 * many + expected));
  bit.add(counter(kAbove2, (8 * many + level()) * 3 + c.kind));
  bit.add(
      counter(kAbove3, (few * 24 + std::clamp(c.inherited_bin - scale + 20, 0, 23)) * 6 + c.first));
  bit.add(counter(kAbove4, ((6 * many + c.far) * 6 + c.first) * 3 + c.kind));
  const int toward = negative ? -c.mean : c.mean;
  const int bin = std::clamp(toward / (32 * least) - 8, -20, 11) + 20;
  bit.add(counter(kAbove5, (few * 32 + bin) * 32 + relative));
  bit.predict(weights_.above[at(few)]);
  return bit;
}

MixedBit DetailModel::has_tangential(const DetailContext& c, bool normal_is_zero) {
  MixedBit bit;
  const int around = std::min(c.tangential, 3);
  const int edge = place_.level->edges[c.detail].is_boundary() ? 1 : 0;
  bit.add(counter(kTangential0, ((edge * 4 + around) * 2 + (normal_is_zero ? 1 : 0)) * 3 + c.kind));
  bit.add(counter(kTangential1, (edge * 8 + level()) * 4 + around));
  bit.add(counter(kTangential2, edge * 16 + std::min(c.expected_bin / 2, 15)));
  bit.predict(weights_.tangential[at(edge)]);
  return bit;
}

MixedBit DetailModel::tangential_is_nonzero(const DetailContext& c, int component) {
  MixedBit bit;
  const int place = 2 * component + (place_.level->edges[c.detail].is_boundary() ? 1 : 0);
  bit.add(counter(kTangentialZero0, 4 * place + std::min(c.tangential, 3)));
  bit.add(counter(kTangentialZero1, 3 * place + c.kind));
  bit.predict(weights_.tangential_zero);
  return bit;
}

MixedBit DetailModel::tangential_is_negative(const DetailContext& c, int component) {
  MixedBit bit;
  const int edge = place_.level->edges[c.detail].is_boundary() ? 1 : 0;
  bit.add(counter(kTangentialSign, 2 * component + edge));
  bit.predict_alone();
  return bit;
}

MixedBit DetailModel::tangential_is_above(const DetailContext& c, int component,
                                          int magnitude_class) {
  MixedBit bit;
  bit.add(counter(kTangentialAbove0, component * kMagnitudeClasses + magnitude_class));
  const int around = std::min(log_bin(c.tangential), 7);
  bit.add(counter(kTangentialAbove1, around * kMagnitudeClasses + magnitude_class));
  bit.predict(weights_.tangential_above);
  return bit;
}

}  // namespace nacre::entropy
