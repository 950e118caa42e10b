// SPDX-License-Identifier: Apache-2.0
#include "entropy/estimation_quantisation.h"

#include <bit>
#include <cassert>
#include <cstdlib>

#include "entropy/binary_model.h"

namespace nacre::entropy {
namespace {

constexpr std::int32_t kLargestSeen = 1 << 16;
constexpr int kScaleClasses = 40;   // two to an octave of the estimated scale
constexpr int kSilentClasses = 16;  // by band: nothing but zeros around
constexpr int kClasses = kScaleClasses + kSilentClasses;
constexpr int kShrinkBits = 4, kShrinkZero = 8;

/// Weights of the magnitudes around a component, of 16 in all but for the parent's.
constexpr int kOtherHalf = 6, kFirstRing = 10, kSecondRing = 4;
/// A parent's detail in its own steps says this much, in quarters, about one of the child's.
constexpr int kParent = 6, kParentQuarters = 1;

int scale_class(std::int64_t scale) {
  if (scale < 2) return static_cast<int>(scale);
  const int k = static_cast<int>(std::bit_width(static_cast<std::uint64_t>(scale))) - 1;
  return std::min(2 * k + static_cast<int>((scale >> (k - 1)) & 1), kScaleClasses - 1);
}

/// The bits of one value, once for both directions; see detail_syntax.h for what a Coder is.
template <class Coder, class Class>
std::int32_t code_value(Coder& coder, Class& statistics, std::int32_t value) {
  if (!coder.bit(statistics.nonzero, value != 0)) return 0;
  const bool negative = coder.raw(value < 0);
  const auto magnitude = static_cast<std::uint32_t>(std::abs(value));
  const int own = static_cast<int>(std::bit_width(magnitude));
  int length = 1;
  while (length <= 24 &&
         coder.bit(statistics.longer[static_cast<std::size_t>(length - 1)], own > length))
    ++length;
  std::uint32_t decoded = 1;
  for (int i = length - 2; i >= 0; --i) {
    const bool wanted = ((magnitude >> i) & 1) != 0;
    bool bit = false;
    if (i == length - 2)
      bit = coder.bit(statistics.upper_half[static_cast<std::size_t>(length - 1)], wanted);
    else if (i == length - 3)
      bit = coder.bit(statistics.third_bit[decoded & 1], wanted);
    else
      bit = coder.raw(wanted);
    decoded = (decoded << 1) | (bit ? 1u : 0u);
  }
  const auto result = static_cast<std::int32_t>(decoded);
  return negative ? -result : result;
}

struct Writer {
  ArithmeticEncoder& coder;
  bool bit(AdaptiveBit& model, bool value) {
    coder.encode_bit(value, model.probability());
    model.update(value);
    return value;
  }
  bool raw(bool value) {
    coder.encode_bits(value ? 1 : 0, 1);
    return value;
  }
};

struct Counter {
  std::uint64_t cost = 0;
  bool bit(const AdaptiveBit& model, bool value) {
    cost += bit_cost(model.probability_of(value));
    return value;
  }
  bool raw(bool value) {
    cost += 4096;
    return value;
  }
};

struct Reader {
  ArithmeticDecoder& coder;
  bool bit(AdaptiveBit& model, bool) {
    const bool value = coder.decode_bit(model.probability());
    model.update(value);
    return value;
  }
  bool raw(bool) { return coder.decode_bits(1) != 0; }
};

}  // namespace

EqModel::EqModel() : classes_(2 * kClasses) {}

void EqModel::begin_band(const EqPlace& place) {
  assert(place.coarser == nullptr || magnitude_[0].size() == place.coarser->edges.size());
  place_ = place;
  inner_begin_ =
      place.coarser != nullptr ? 2 * static_cast<std::uint32_t>(place.coarser->edges.size()) : 0;
  for (std::size_t c = 0; c < 3; ++c) {
    coarser_[c] = std::move(magnitude_[c]);
    magnitude_[c].assign(place.level->edges.size(), 0);
  }
}

std::uint32_t EqModel::parent(std::uint32_t e) const {
  if (e < inner_begin_) return e / 2;
  const std::uint32_t face = (e - inner_begin_) / 3, corner = (e - inner_begin_) % 3;
  return place_.coarser->triangle_edges[face][(corner + 1) % 3];
}

EqModel::Class& EqModel::look(std::uint32_t e, std::size_t c) {
  const LevelTopology& level = *place_.level;
  const std::vector<std::int32_t>& magnitude = magnitude_[c];
  std::int64_t sum = 0, weight = 0;
  const auto add = [&](std::uint32_t other, int w) {
    if (other >= e) return;
    sum += std::int64_t{w} * magnitude[other];
    weight += w;
  };
  if (e < inner_begin_) add(e ^ 1u, kOtherHalf);
  for (const std::uint32_t face : level.edges[e].face) {
    if (face == kNone) continue;
    for (const std::uint32_t first : level.triangle_edges[face]) {
      if (first == e) continue;
      add(first, kFirstRing);
      const Edge& edge = level.edges[first];
      const std::uint32_t beyond = edge.face[0] == face ? edge.face[1] : edge.face[0];
      if (beyond == kNone) continue;
      for (const std::uint32_t second : level.triangle_edges[beyond])
        if (second != first) add(second, kSecondRing);
    }
  }
  sum *= 4;
  if (place_.coarser != nullptr) {
    sum += std::int64_t{kParent} * kParentQuarters * coarser_[c][parent(e)];
    weight += kParent;
  }
  const int kind = c == 0 ? 0 : kClasses;
  const int index = sum == 0 ? kScaleClasses + std::min(place_.band, kSilentClasses - 1)
                             : scale_class(64 * sum / weight);
  return classes_[static_cast<std::size_t>(kind + index)];
}

void EqModel::set(std::uint32_t e, std::size_t c, std::int32_t value) {
  magnitude_[c][e] = std::min(std::abs(value), kLargestSeen);
}

Result<EqBand> decode_eq_band(std::span<const std::uint8_t> payload, const EqPlace& place,
                              EqModel& model) {
  EqBand band;
  band.points.assign(place.level->edges.size(), EqPoint{0, 0, 0});
  model.begin_band(place);
  if (payload.empty()) return band;
  const auto corrupt = [&](const char* what) {
    return Error{ErrorCode::kCorruptStream, what, payload.size()};
  };
  ArithmeticDecoder coder(payload);
  Reader reader{coder};
  bool any = false;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::uint32_t e = 0; e < band.points.size(); ++e) {
      const std::int32_t value = code_value(reader, model.look(e, c), 0);
      if (value == 0) continue;
      if (coder.overrun() || std::abs(value) > kMaxEqMagnitude)
        return corrupt("the payload ends before the band does");
      model.set(e, c, value);
      band.points[e][c] = value;
      any = true;
    }
  }
  for (int& shrink : band.shrink_32nds)
    shrink = static_cast<int>(coder.decode_bits(kShrinkBits)) - kShrinkZero;
  if (!any) return corrupt("a band of zeros has no payload");
  if (!coder.ends_exactly()) return corrupt("the payload goes on after the band");
  return band;
}

std::uint64_t EqEncoder::cost(const EqModel::Class& statistics, std::int32_t value) {
  Counter counter;
  code_value(counter, statistics, value);
  return counter.cost;
}

void EqEncoder::put(EqModel::Class& statistics, std::uint32_t e, std::size_t c,
                    std::int32_t value) {
  Writer writer{coder_};
  code_value(writer, statistics, value);
  model_.set(e, c, value);
}

std::vector<std::uint8_t> EqEncoder::finish(const std::array<int, 3>& shrink_32nds) {
  for (const int shrink : shrink_32nds)
    coder_.encode_bits(static_cast<std::uint32_t>(shrink + kShrinkZero), kShrinkBits);
  return coder_.finish();
}

}  // namespace nacre::entropy
