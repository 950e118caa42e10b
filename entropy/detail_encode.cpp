// SPDX-License-Identifier: GPL-3.0-or-later
#include <cassert>

#include "entropy/detail_coder.h"
#include "entropy/detail_syntax.h"

namespace nacre::entropy {
namespace {

struct Writer {
  ArithmeticEncoder& encoder;

  template <class Bit>
  bool bit(Bit mixed, bool value) {
    encoder.encode_bit(value, mixed.probability());
    mixed.update(value);
    return value;
  }
  std::uint32_t raw(int count, std::uint32_t bits) {
    encoder.encode_bits(bits, count);
    return bits;
  }
};

/// Adds up what Writer would write; learns nothing.
struct Counter {
  std::uint64_t cost = 0;

  template <class Bit>
  bool bit(const Bit& mixed, bool value) {
    cost += mixed.cost(value);
    return value;
  }
  std::uint32_t raw(int count, std::uint32_t bits) {
    cost += 4096u * static_cast<std::uint32_t>(count);
    return bits;
  }
};

}  // namespace

DetailEncoder::DetailEncoder(DetailModel& model, const BandPlace& place, bool has_tangential,
                             int ratio_quarters)
    : model_(model), has_tangential_(has_tangential) {
  model_.begin_band(place);
  Writer writer{coder_};
  writer.raw(1, has_tangential ? 1 : 0);
  if (has_tangential) writer.raw(kRatioBits, static_cast<std::uint32_t>(ratio_quarters));
}

void DetailEncoder::begin_block(std::uint32_t block, bool quiet_may_rise, bool has_tangential) {
  Writer writer{coder_};
  head_ = code_block_head(writer, model_, block, has_tangential_, head_.has_tangential,
                          {quiet_may_rise, has_tangential});
}

std::uint64_t DetailEncoder::normal_cost(const DetailContext& context, std::int32_t normal) {
  Counter counter;
  code_normal(counter, model_, context, normal);
  return counter.cost;
}

std::uint64_t DetailEncoder::tangential_cost(const DetailContext& context,
                                             const DetailPoint& point) {
  if (!head_.has_tangential) return 0;
  Counter counter;
  code_tangential(counter, model_, context, point);
  return counter.cost;
}

void DetailEncoder::put(const DetailContext& context, const DetailPoint& point) {
  Writer writer{coder_};
  const DetailPoint coded = code_detail(writer, model_, context, head_, point);
  assert(coded == point);
  static_cast<void>(coded);
  model_.set(context.detail, point);
}

std::vector<std::uint8_t> DetailEncoder::finish(const std::array<int, 3>& shrink_32nds) {
  Writer writer{coder_};
  for (const int shrink : shrink_32nds)
    writer.raw(kShrinkBits, static_cast<std::uint32_t>(shrink + kShrinkZero));
  return coder_.finish();
}

void show_details(const DetailBand& band, bool is_coded, const BandPlace& place,
                  DetailModel& model) {
  if (!is_coded) {
    model.skip_band(place);
    return;
  }
  bool has_tangential = false;
  std::vector<DetailPoint> points(place.level->edges.size(), DetailPoint{0, 0, 0});
  for (const DetailBand::Nonzero& n : band.points) {
    points[n.edge] = n.point;
    has_tangential |= n.point[1] != 0 || n.point[2] != 0;
  }
  DetailEncoder encoder(model, place, has_tangential, band.ratio_quarters);
  for (std::uint32_t e = 0; e < points.size(); ++e) {
    if (e % kBlockDetails == 0) {
      const std::uint64_t active = encoder.active(e / kBlockDetails);
      bool rises = false, moves = false;
      for (std::uint32_t i = 0; i < kBlockDetails && e + i < points.size(); ++i) {
        rises |= points[e + i][0] != 0 && (active >> i & 1) == 0;
        moves |= points[e + i][1] != 0 || points[e + i][2] != 0;
      }
      encoder.begin_block(e / kBlockDetails, rises, moves);
    }
    const DetailContext context = encoder.look(e);
    if (encoder.is_open(context)) encoder.put(context, points[e]);
  }
}

}  // namespace nacre::entropy
