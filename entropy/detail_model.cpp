// SPDX-License-Identifier: Apache-2.0
//
// Read me first: neighbouring details have similar magnitudes, and so have a band's and the
// coarser one's at the same place. A weighted mean of those around gives the magnitude expected;
// the bits' probabilities are learnt for each of its (logarithmic) values, and for finer
// descriptions of the neighbourhood, and mixed. Normals of neighbours also go the same way more
// often than not (the butterfly undershoots where the surface bends), hence the expected value.
#include "entropy/detail_model.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstdlib>

#include "entropy/detail_start.h"

namespace nacre::entropy {
namespace {

constexpr std::int32_t kLargestSeen = 4095;
constexpr int kLevels = 8;  // bands that are told apart

/// Weights in 1/256 of the mean magnitudes: the other half of the coarser edge, first ring's outer
/// and inner edges, second ring's, then parent, uncles, cousins. Rows: kinds; band 0.
constexpr std::array<std::array<int, 8>, 4> kMagnitudeWeights = {{{0, 70, 0, 30, 0, 16, 15, 12},
                                                                  {40, 62, 0, 22, 0, 16, 13, 8},
                                                                  {0, 72, 40, 90, 12, 6, 8, 8},
                                                                  {0, 120, 0, 60, 0, 0, 0, 0}}};
/// The same for sums of signed values.
constexpr std::array<std::array<int, 8>, 4> kValueWeights = {{{0, 48, 0, -14, 0, 6, 0, 0},
                                                              {-27, 54, 0, -17, 0, 8, 0, 0},
                                                              {0, 37, 43, -6, -16, 4, 3, -2},
                                                              {0, 20, 0, 0, 0, 0, 0, 0}}};
/// What the coarser band weighs beside the groups above; in band 0, what the average does.
constexpr int kInheritedWeight = 140, kAverageWeight = 40, kBandZeroWeight = 180;

/// 2^15 2^(k/32), rounded.
constexpr std::array<std::int32_t, 32> kStepPowers = {
    32768, 33486, 34219, 34968, 35734, 36516, 37316, 38133, 38968, 39821, 40693,
    41584, 42495, 43425, 44376, 45348, 46341, 47356, 48393, 49452, 50535, 51642,
    52773, 53928, 55109, 56316, 57549, 58809, 60097, 61413, 62757, 64132};

/// 256 2^(excess / 32), for |excess| up to 8 octaves.
std::int64_t step_ratio(int excess) {
  excess = std::clamp(excess, -256, 255);
  const int octave = excess >= 0 ? excess / 32 : -((31 - excess) / 32);
  const std::int64_t mantissa = kStepPowers[static_cast<std::size_t>(excess - 32 * octave)];
  return (mantissa << (octave + 8)) >> 15;
}

/// Two to an octave: 0, 1, 2, 3, 4-5, 6-7, 8-11, ...
int log_bin(std::int64_t value) {
  if (value < 2) return static_cast<int>(value);
  const int k = static_cast<int>(std::bit_width(static_cast<std::uint64_t>(value))) - 1;
  return 2 * k + static_cast<int>((value >> (k - 1)) & 1);
}

int small_sum(int sum) { return sum < 3 ? sum : (sum < 5 ? 3 : (sum < 9 ? 4 : 5)); }  // 6 values
int tiny_sum(int sum) { return sum < 2 ? sum : (sum < 4 ? 2 : 3); }                   // 4 values
int sign3(int value) { return value < 0 ? 0 : (value == 0 ? 1 : 2); }
int sign5(int value) { return std::clamp(value, -2, 2) + 2; }
/// 32 values, symmetric.
int signed_bin(int mean) {
  const int bin = std::min(log_bin(std::abs(mean) / 8), 15);
  return mean < 0 ? 15 - bin : 16 + bin;
}

void start(std::vector<BitCounter>& counters, std::span<const std::int8_t> probabilities) {
  assert(counters.size() == probabilities.size());
  for (std::size_t i = 0; i < counters.size(); ++i) {
    if (probabilities[i] == kNo) continue;
    counters[i] = {squash(32 * probabilities[i]) << 16, kStartCount};
  }
}

std::size_t at(int index) { return static_cast<std::size_t>(index); }

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

/// Sums over groups of neighbours that are known: the other half (0), first ring outer (1) and
/// inner (2), second ring outer (3) and inner (4).
struct DetailModel::Ring {
  std::array<int, 5> magnitude{}, value{}, count{};
  int tangential = 0;
};

DetailModel::BitKind DetailModel::make_kind(std::initializer_list<std::size_t> table_sizes,
                                            std::size_t mixers) {
  BitKind kind;
  for (const std::size_t size : table_sizes) kind.tables.emplace_back(size);
  kind.mixers.resize(mixers);
  return kind;
}

DetailModel::DetailModel()
    : quiet_(kLevels * 3),
      zero_(make_kind({96, 512, 432, 2187, 288, 576, 768}, 48)),
      sign_(make_kind({96, 768, 375, 729}, 3)),
      magnitude_(make_kind({128, 48 * 20, 20 * 24, 4 * 144, 20 * 108, 4096}, 4)),
      tangential_flag_(make_kind({64, 64, 32}, 2)),
      tangential_zero_(make_kind({16, 12}, 1)),
      tangential_sign_(make_kind({4}, 1)),
      tangential_magnitude_(make_kind({2 * kMagnitudeClasses, 8 * kMagnitudeClasses}, 1)) {
  start(quiet_, kQuietStart);
  start(zero_.tables[0], kZeroStart);
  start(sign_.tables[0], kSignStart);
  start(magnitude_.tables[0], kMagnitudeStart);
}

void DetailModel::begin_band(const BandPlace& place) {
  const bool has_coarser = place.coarser != nullptr;
  assert(!has_coarser || normal_.size() == place.coarser->edges.size());
  place_ = place;
  inner_begin_ = has_coarser ? 2 * static_cast<std::uint32_t>(place.coarser->edges.size()) : 0;
  ratio_ = step_ratio(place.coarser_step_excess);
  average_ = 512;
  coarser_normal_ = std::move(normal_);
  coarser_tangential_ = std::move(tangential_);
  normal_.assign(place.level->edges.size(), 0);
  tangential_.assign(place.level->edges.size(), 0);
}

void DetailModel::set(std::uint32_t e, const DetailPoint& point) {
  normal_[e] = std::clamp(point[0], -kLargestSeen, kLargestSeen);
  const std::int64_t sum = std::abs(std::int64_t{point[1]}) + std::abs(std::int64_t{point[2]});
  tangential_[e] = static_cast<std::int32_t>(std::min<std::int64_t>(sum, kLargestSeen));
  if (place_.coarser == nullptr) average_ += (256 * std::abs(normal_[e]) - average_) / 32;
}

void DetailModel::look_in_band(std::uint32_t e, Ring& ring) const {
  const LevelTopology& level = *place_.level;
  const bool has_inner = place_.coarser != nullptr;
  const auto add = [&](std::size_t group, std::uint32_t other) {
    if (other >= e) return;
    const std::int32_t value = normal_[other];
    ring.magnitude[group] += std::abs(value);
    ring.value[group] += value;
    ring.tangential += tangential_[other];
    ++ring.count[group];
  };
  if (has_inner && e < inner_begin_) add(0, e ^ 1u);
  for (const std::uint32_t face : level.edges[e].face) {
    if (face == kNone) continue;
    for (const std::uint32_t first : level.triangle_edges[face]) {
      if (first == e) continue;
      add(has_inner && first >= inner_begin_ ? 2 : 1, first);
      const Edge& edge = level.edges[first];
      const std::uint32_t beyond = edge.face[0] == face ? edge.face[1] : edge.face[0];
      if (beyond == kNone) continue;
      for (const std::uint32_t second : level.triangle_edges[beyond]) {
        if (second != first) add(has_inner && second >= inner_begin_ ? 4 : 3, second);
      }
    }
  }
}

void DetailModel::look_below(std::uint32_t e, DetailContext& context) const {
  const LevelTopology& level = *place_.coarser;
  // Twice the parent's, as the parent of an inner edge is the mean of two.
  std::array<int, 3> magnitude{}, value{}, count{};
  const auto add = [&](std::size_t group, std::uint32_t edge, int times = 1) {
    const std::int32_t v = coarser_normal_[edge];
    magnitude[group] += times * std::abs(v);
    value[group] += times * v;
    context.tangential += coarser_tangential_[edge];
    ++count[group];
  };
  if (e < inner_begin_) {
    const std::uint32_t parent = e / 2;
    const std::uint32_t end = level.edges[parent].vertex[e & 1];
    add(0, parent, 2);
    for (const std::uint32_t face : level.edges[parent].face) {
      if (face == kNone) continue;
      for (const std::uint32_t side : level.triangle_edges[face]) {
        if (side == parent) continue;
        const auto& ends = level.edges[side].vertex;
        add(ends[0] == end || ends[1] == end ? 1 : 2, side);
      }
    }
  } else {
    const std::uint32_t face = (e - inner_begin_) / 3, k = (e - inner_begin_) % 3;
    const Triangle& sides = level.triangle_edges[face];
    add(1, sides[(k + 1) % 3]);
    for (const std::uint32_t side : {sides[k], sides[(k + 2) % 3]}) {
      add(0, side);
      const Edge& edge = level.edges[side];
      const std::uint32_t beyond = edge.face[0] == face ? edge.face[1] : edge.face[0];
      if (beyond == kNone) continue;
      for (const std::uint32_t far : level.triangle_edges[beyond])
        if (far != side) add(2, far);
    }
  }
  const auto scaled = [&](std::size_t group, int divisor) {
    if (divisor == 0) return 0;
    constexpr std::int64_t kLargest = std::int64_t{1} << 20;
    return static_cast<int>(std::min(magnitude[group] * ratio_ / divisor, kLargest));
  };
  context.parent = scaled(0, 2);
  context.uncle = scaled(1, count[1]);
  context.cousin = scaled(2, count[2]);
  for (std::size_t i = 0; i < 3; ++i) context.sums[4 + i] = value[i];
}

DetailContext DetailModel::look(std::uint32_t e) const {
  DetailContext context;
  context.detail = e;
  const bool has_coarser = place_.coarser != nullptr;
  context.kind = !has_coarser ? 0 : (e < inner_begin_ ? static_cast<int>(e & 1) : 2);
  context.is_boundary = place_.level->edges[e].is_boundary();
  Ring ring;
  look_in_band(e, ring);
  if (has_coarser) look_below(e, context);

  const std::size_t row = has_coarser ? at(context.kind) : 3;
  const auto& weights = kMagnitudeWeights[row];
  int known = 0, all = 0, sum = 0;
  for (std::size_t i = 0; i < 5; ++i) {
    all += weights[i];
    if (ring.count[i] == 0) continue;
    known += weights[i];
    sum += weights[i] * (256 * ring.magnitude[i] / ring.count[i]);
  }
  const std::int64_t inherited = std::int64_t{weights[5]} * context.parent +
                                 std::int64_t{weights[6]} * context.uncle +
                                 std::int64_t{weights[7]} * context.cousin;
  context.inherited = static_cast<int>(inherited / 256);
  if (has_coarser) {
    context.expected = static_cast<int>((sum + inherited) * (all + kInheritedWeight) /
                                        (known + kInheritedWeight) / 256);
  } else {
    context.expected = static_cast<int>((std::int64_t{sum} + kAverageWeight * average_) /
                                        (known + kAverageWeight));
  }
  const auto& u = kValueWeights[row];
  const std::int64_t below =
      u[5] * context.sums[4] / 2 + u[6] * context.sums[5] + u[7] * context.sums[6];
  std::int64_t mean = below * ratio_ / 256;
  for (std::size_t i = 0; i < 5; ++i) mean += u[i] * ring.value[i];
  context.mean = static_cast<int>(std::clamp<std::int64_t>(mean, -(1 << 20), 1 << 20));

  context.near = ring.magnitude[1];
  context.far = ring.magnitude[3];
  context.beside = ring.magnitude[2] + ring.magnitude[0];
  context.sums[0] = ring.value[1];
  context.sums[1] = ring.value[3];
  context.sums[2] = ring.value[2] + ring.value[0];
  context.sums[3] = ring.magnitude[4];
  context.tangential += ring.tangential;
  context.is_quiet = has_coarser && context.parent + context.uncle + context.cousin == 0;
  for (const int magnitude : ring.magnitude) context.is_quiet &= magnitude == 0;
  return context;
}

MixedBit DetailModel::is_nonzero(const DetailContext& c) {
  MixedBit bit;
  const int level = std::min(place_.band, kLevels - 1);
  if (c.is_quiet) {
    bit.add(quiet_[at(3 * level + c.kind)]);
    bit.predict_alone();
    return bit;
  }
  auto& t = zero_.tables;
  const int expected = std::min(log_bin(c.expected), 31);
  const int inherited = std::min(log_bin(c.inherited), 15);
  const int first = small_sum(c.near + c.beside);
  bit.add(t[0][at(32 * c.kind + expected)]);
  bit.add(t[1][at((4 * level + c.kind) * 16 + expected / 2)]);
  bit.add(
      t[2][at(((small_sum(c.near) * 6 + small_sum(c.far)) * 4 + tiny_sum(c.beside)) * 3 + c.kind)]);
  const auto coarse = [](int value) { return std::min(log_bin(value) / 2, 8); };
  bit.add(t[3][at(((coarse(c.parent) * 9 + coarse(c.uncle)) * 9 + coarse(c.cousin)) * 3 + c.kind)]);
  bit.add(t[4][at((first * 16 + inherited) * 3 + c.kind)]);
  bit.add(t[5][at((small_sum(c.far + c.sums[3]) * 16 + inherited) * 6 + first)]);
  bit.add(t[6][at((std::min(log_bin(std::abs(c.mean) / 8), 15) * 16 + expected / 2) * 3 + c.kind)]);
  bit.predict(zero_.mixers[at(16 * c.kind + expected / 2)]);
  return bit;
}

MixedBit DetailModel::is_negative(const DetailContext& c) {
  MixedBit bit;
  auto& t = sign_.tables;
  const int mean = signed_bin(c.mean), expected = std::min(log_bin(c.expected) / 2, 7);
  const auto& s = c.sums;
  bit.add(t[0][at(3 * mean + c.kind)]);
  bit.add(t[1][at((8 * mean + expected) * 3 + c.kind)]);
  bit.add(t[2][at(((sign5(s[0]) * 5 + sign5(s[1])) * 5 + sign5(s[2])) * 3 + c.kind)]);
  const int around = (sign3(s[0]) * 3 + sign3(s[1])) * 3 + sign3(s[2]);
  const int below = (sign3(s[4]) * 3 + sign3(s[5])) * 3 + sign3(s[6]);
  bit.add(t[3][at(27 * around + below)]);
  bit.predict(sign_.mixers[at(c.kind)]);
  return bit;
}

MixedBit DetailModel::is_above(const DetailContext& c, bool negative, int magnitude_class) {
  MixedBit bit;
  auto& t = magnitude_.tables;
  const int least = least_of_class(magnitude_class + 1);
  const int scale = log_bin(std::int64_t{256} * least);
  const int expected = std::min(log_bin(c.expected), 47);
  const int relative = std::clamp(expected - scale + 20, 0, 31);
  const int few = std::min(magnitude_class, 3), many = std::min(magnitude_class, 19);
  const int first = small_sum(c.near + c.beside);
  bit.add(t[0][at(32 * few + relative)]);
  bit.add(t[1][at(48 * many + expected)]);
  bit.add(t[2][at((8 * many + std::min(place_.band, kLevels - 1)) * 3 + c.kind)]);
  bit.add(t[3][at((few * 24 + std::clamp(log_bin(c.inherited) - scale + 20, 0, 23)) * 6 + first)]);
  bit.add(t[4][at(((6 * many + small_sum(c.far)) * 6 + first) * 3 + c.kind)]);
  const std::int64_t toward = negative ? -c.mean : c.mean;
  const std::int64_t excess = (toward - std::int64_t{256} * least) / 32 / least;
  const int bin = static_cast<int>(std::clamp<std::int64_t>(excess, -20, 11)) + 20;
  bit.add(t[5][at((few * 32 + bin) * 32 + relative)]);
  bit.predict(magnitude_.mixers[at(few)]);
  return bit;
}

MixedBit DetailModel::has_tangential(const DetailContext& c, bool normal_is_zero) {
  MixedBit bit;
  auto& t = tangential_flag_.tables;
  const int around = std::min(c.tangential, 3), edge = c.is_boundary ? 1 : 0;
  const int level = std::min(place_.band, kLevels - 1);
  bit.add(t[0][at(((edge * 4 + around) * 2 + (normal_is_zero ? 1 : 0)) * 3 + c.kind)]);
  bit.add(t[1][at((edge * 8 + level) * 4 + around)]);
  bit.add(t[2][at(edge * 16 + std::min(log_bin(c.expected) / 2, 15))]);
  bit.predict(tangential_flag_.mixers[at(edge)]);
  return bit;
}

MixedBit DetailModel::tangential_is_nonzero(const DetailContext& c, int component) {
  MixedBit bit;
  auto& t = tangential_zero_.tables;
  const int place = 2 * component + (c.is_boundary ? 1 : 0);
  bit.add(t[0][at(4 * place + std::min(c.tangential, 3))]);
  bit.add(t[1][at(3 * place + c.kind)]);
  bit.predict(tangential_zero_.mixers[0]);
  return bit;
}

MixedBit DetailModel::tangential_is_negative(const DetailContext& c, int component) {
  MixedBit bit;
  bit.add(tangential_sign_.tables[0][at(2 * component + (c.is_boundary ? 1 : 0))]);
  bit.predict_alone();
  return bit;
}

MixedBit DetailModel::tangential_is_above(const DetailContext& c, int component,
                                          int magnitude_class) {
  MixedBit bit;
  auto& t = tangential_magnitude_.tables;
  bit.add(t[0][at(component * kMagnitudeClasses + magnitude_class)]);
  const int around = std::min(log_bin(c.tangential), 7);
  bit.add(t[1][at(around * kMagnitudeClasses + magnitude_class)]);
  bit.predict(tangential_magnitude_.mixers[0]);
  return bit;
}

}  // namespace nacre::entropy
