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
/// The group that a neighbour belongs to, by the same columns.
constexpr std::array<DetailGroup, 5> kGroups = {kBeside, kNear, kBeside, kFar, kBeyond};

enum Role : std::size_t { kParent, kUncle, kCousin };

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

std::size_t at(int index) { return static_cast<std::size_t>(index); }

/// Adds to the surroundings of details. Its members are copies: bytes that are written may be
/// anything, for all the compiler knows, but not these.
class Adder {
 public:
  template <class Around>
  Adder(Around& around, std::vector<std::uint64_t>& active, int tangential)
      : around_(around.data()), active_(active.data()), tangential_(tangential) {}

  void operator()(const Surroundings& what, std::uint32_t target) const {
    Surroundings& around = around_[target];
    around.add(what);
    if (tangential_ != 0) {
      std::uint8_t& count = around.counts[Surroundings::kTangential];
      count = static_cast<std::uint8_t>(count + tangential_);
    }
    active_[target / kBlockDetails] |= std::uint64_t{1} << (target % kBlockDetails);
  }

 private:
  Surroundings* around_;
  std::uint64_t* active_;
  int tangential_;
};

constexpr std::size_t kInnerKind = 2;  // of an edge inside a coarser triangle

std::uint32_t after(std::uint32_t k) { return k == 2 ? 0 : k + 1; }
std::uint32_t before(std::uint32_t k) { return k == 0 ? 2 : k - 1; }
std::uint32_t corner_at(const Triangle& triangle, std::uint32_t vertex) {
  return triangle[0] == vertex ? 0 : (triangle[1] == vertex ? 1 : 2);
}
std::uint32_t side_of(const Triangle& triangle_edges, std::uint32_t edge) {
  return corner_at(triangle_edges, edge);
}

std::uint32_t face_beyond(const Edge& edge, std::uint32_t face) {
  return edge.face[0] == face ? edge.face[1] : edge.face[0];
}

}  // namespace

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
  around_ = decltype(around_)(count);
  active_.assign((count + kBlockDetails - 1) / kBlockDetails, place.coarser ? 0 : ~0ull);
  if (count % kBlockDetails != 0) active_.back() &= (1ull << (count % kBlockDetails)) - 1;
  inner_begin_ = place.coarser ? 2 * static_cast<std::uint32_t>(place.coarser->edges.size()) : 0;
  for (int normal = -kReady; normal <= kReady; ++normal) {
    for (const bool is_inner : {false, true})
      in_band_[is_inner ? 1 : 0][at(normal + kReady)] = in_band(normal, is_inner);
    below_[at(normal + kReady)] = below(normal);
  }
  if (!place.coarser) return;
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

namespace {

/// A value of one detail as far as `group` tells it apart.
void note_value(int normal, DetailGroup group, Surroundings& out) {
  if (group <= kBeyond)
    out.counts[Surroundings::kFew + group] =
        static_cast<std::uint8_t>(std::min(std::abs(normal), 15));
  out.counts[Surroundings::kSigns + group] = static_cast<std::uint8_t>(std::clamp(normal, -10, 10));
}

}  // namespace

DetailModel::Spread DetailModel::in_band(int normal, bool is_inner) const {
  constexpr std::array<std::size_t, 3> kColumns = {0, 1, 3};
  const bool has_coarser = place_.coarser != nullptr;
  Spread spread{};
  for (std::size_t kind = 0; kind < 3; ++kind) {
    for (std::size_t ring = 0; ring < 3; ++ring) {
      Surroundings& out = spread[kind][ring];
      const std::size_t row = has_coarser ? kind : 3;
      const std::size_t column = kColumns[ring] + (is_inner && ring > 0 ? 1 : 0);
      const int weight = kMagnitudeWeights[row][column];
      out.sums[Surroundings::kBand] = static_cast<std::uint32_t>(weight * std::abs(normal));
      out.sums[Surroundings::kMean] =
          static_cast<std::uint32_t>(16 * kValueWeights[row][column] * normal);
      if (!has_coarser) out.sums[Surroundings::kBelow] = static_cast<std::uint32_t>(weight);
      note_value(normal, kGroups[column], out);
    }
  }
  return spread;
}

DetailModel::Spread DetailModel::below(int normal) const {
  Spread spread{};
  for (std::size_t kind = 0; kind < 3; ++kind) {
    for (std::size_t role = 0; role < 3; ++role) {
      Surroundings& out = spread[kind][role];
      const int magnitude = std::abs(normal);
      out.sums[Surroundings::kBelow] =
          static_cast<std::uint32_t>(kInheritedWeights[kind][role] * ratio_ / 32 * magnitude);
      out.sums[Surroundings::kMean] =
          static_cast<std::uint32_t>(kInheritedValueWeights[kind][role] * ratio_ / 32 * normal);
      if (role == kParent)
        out.sums[Surroundings::kParent] =
            static_cast<std::uint32_t>((kind < 2 ? 2 : 1) * magnitude);
      note_value(normal, role == kParent ? kParents : kOthers, out);
    }
  }
  return spread;
}

void DetailModel::spread_in_band(const Nonzero& source) {
  const bool is_inner = place_.coarser != nullptr && source.detail >= inner_begin_;
  const bool is_ready = std::abs(source.normal) <= kReady;
  Spread made;
  if (!is_ready) made = in_band(source.normal, is_inner);
  const Spread& spread = is_ready ? in_band_[is_inner ? 1 : 0][at(source.normal + kReady)] : made;
  if (place_.coarser == nullptr) {
    spread_in_base(source, spread[0]);
  } else if (is_inner) {
    spread_from_inner(source, spread[kInnerKind]);
  } else {
    spread_from_half(source, spread);
  }
}

void DetailModel::spread_in_base(const Nonzero& source, const std::array<Surroundings, 3>& spread) {
  const LevelTopology& level = *place_.level;
  const std::uint32_t e = source.detail;
  const Adder add(around_, active_, source.tangential);
  const auto add_after = [&](std::uint32_t target, std::size_t ring) {
    if (target > e) add(spread[ring], target);
  };
  for (const std::uint32_t face : level.edges[e].face) {
    if (face == kNone) continue;
    for (const std::uint32_t first : level.triangle_edges[face]) {
      if (first == e) continue;
      add_after(first, 1);
      const std::uint32_t beyond = face_beyond(level.edges[first], face);
      if (beyond == kNone) continue;
      for (const std::uint32_t second : level.triangle_edges[beyond])
        if (second != first) add_after(second, 2);
    }
  }
}

// The rings of an edge that a split has made, by the triangles that were split: four times fewer
// than the split ones.

void DetailModel::spread_from_inner(const Nonzero& source,
                                    const std::array<Surroundings, 3>& spread) {
  // All others that come later are inner ones too: in the same triangle; and across its two sides
  // at the corner that is cut off.
  const LevelTopology& coarser = *place_.coarser;
  const Adder add(around_, active_, source.tangential);
  const std::uint32_t inner = inner_begin_;
  const std::uint32_t face = (source.detail - inner) / 3, corner = (source.detail - inner) % 3;
  for (std::uint32_t k = corner + 1; k < 3; ++k) add(spread[1], inner + 3 * face + k);
  const Triangle& sides = coarser.triangle_edges[face];
  const std::uint32_t vertex = coarser.triangles[face][corner];
  for (const std::uint32_t side : {sides[corner], sides[before(corner)]}) {
    const std::uint32_t beyond = face_beyond(coarser.edges[side], face);
    if (beyond == kNone || beyond < face) continue;
    const std::uint32_t k = corner_at(coarser.triangles[beyond], vertex);
    add(spread[2], inner + 3 * beyond + k);
  }
}

void DetailModel::spread_from_half(const Nonzero& source, const Spread& spread) {
  const LevelTopology& coarser = *place_.coarser;
  const Adder add(around_, active_, source.tangential);
  const std::uint32_t inner = inner_begin_, e = source.detail, own = e / 2;
  const Edge& edge = coarser.edges[own];
  const std::uint32_t vertex = edge.vertex[e % 2];
  const auto add_half = [&](std::uint32_t side, std::size_t ring) {
    const std::uint32_t half = coarser.edges[side].vertex[0] == vertex ? 0 : 1;
    const std::uint32_t target = 2 * side + half;
    if (target > e) add(spread[half][ring], target);
  };
  const auto add_inner = [&](std::uint32_t face, std::uint32_t corner, std::size_t ring) {
    add(spread[kInnerKind][ring], inner + 3 * face + corner);
  };
  if (e % 2 == 0) add(spread[1][0], e + 1);
  for (const std::uint32_t face : edge.face) {
    if (face == kNone) continue;
    const std::uint32_t corner = corner_at(coarser.triangles[face], vertex);
    for (std::uint32_t k = 0; k < 3; ++k) add_inner(face, k, k == corner ? 1 : 2);
    const Triangle& sides = coarser.triangle_edges[face];
    const std::uint32_t other = sides[corner] == own ? sides[before(corner)] : sides[corner];
    add_half(other, 1);
    const std::uint32_t beyond = face_beyond(coarser.edges[other], face);
    if (beyond == kNone) continue;
    const std::uint32_t far_corner = corner_at(coarser.triangles[beyond], vertex);
    add_inner(beyond, far_corner, 2);
    const Triangle& far_sides = coarser.triangle_edges[beyond];
    add_half(far_sides[far_corner] == other ? far_sides[before(far_corner)] : far_sides[far_corner],
             2);
  }
}

void DetailModel::spread_below(const Nonzero& source) {
  const LevelTopology& level = *place_.coarser;
  const std::uint32_t parent = source.detail;
  const Edge& own = level.edges[parent];
  const bool is_ready = std::abs(source.normal) <= kReady;
  Spread made;
  if (!is_ready) made = below(source.normal);
  const Spread& spread = is_ready ? below_[at(source.normal + kReady)] : made;
  const Adder add(around_, active_, source.tangential / 2);
  const std::uint32_t inner = inner_begin_;
  const auto add_inner = [&](std::uint32_t face, std::uint32_t corner, Role role) {
    add(spread[kInnerKind][role], inner + 3 * face + corner);
  };
  for (std::uint32_t h = 0; h < 2; ++h) add(spread[h][kParent], 2 * parent + h);
  for (const std::uint32_t face : own.face) {
    if (face == kNone) continue;
    const Triangle& sides = level.triangle_edges[face];
    // Inner edge k cuts off corner k, between sides k and k - 1.
    const std::uint32_t k = side_of(sides, parent), next = after(k), last = before(k);
    add_inner(face, k, kParent);
    add_inner(face, next, kParent);
    add_inner(face, last, kUncle);
    for (const std::uint32_t side : {sides[next], sides[last]}) {
      const Edge& edge = level.edges[side];
      const bool meets =
          edge.vertex[0] == own.vertex[0] || edge.vertex[0] == own.vertex[1];  // or the other does
      add(spread[0][meets ? kUncle : kCousin], 2 * side);
      add(spread[1][meets ? kCousin : kUncle], 2 * side + 1);
      const std::uint32_t beyond = face_beyond(edge, face);
      if (beyond == kNone) continue;
      const std::uint32_t i = side_of(level.triangle_edges[beyond], side);
      add_inner(beyond, i, kCousin);
      add_inner(beyond, after(i), kCousin);
    }
  }
}

}  // namespace nacre::entropy
