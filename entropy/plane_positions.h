// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <memory>
#include <vector>

#include "entropy/binary_model.h"
#include "entropy/closed_mesh.h"
#include "entropy/plane_prediction.h"
#include "entropy/symbol_io.h"

/// Positions by planes, once for both directions and for prices: docs/FORMAT.md section 19.
namespace nacre::entropy {

/// Contexts of one kind of bit: counters by context and node, weights by node.
class BitTable {
 public:
  BitTable(std::size_t contexts, std::size_t nodes) : nodes_(nodes), counters_(contexts * nodes) {}
  BitCounter& counter(std::size_t context, std::size_t node) {
    return counters_[context * nodes_ + node];
  }

 private:
  std::size_t nodes_;
  std::vector<BitCounter> counters_;
};

/// Up to three tables that are mixed.
class MixedTables {
 public:
  MixedTables(std::array<std::size_t, 3> contexts, std::size_t nodes)
      : nodes_(nodes), weights_(nodes) {
    for (const std::size_t n : contexts) tables_.emplace_back(n, nodes);
  }
  template <class Io>
  bool code(Io& io, bool value, const std::array<std::size_t, 3>& contexts, std::size_t node) {
    node = std::min(node, nodes_ - 1);
    std::array<BitCounter*, 3> counters;
    for (std::size_t i = 0; i < 3; ++i) counters[i] = &tables_[i].counter(contexts[i], node);
    MixedBit bit(weights_[node], counters);
    return io.bit(value, bit);
  }

 private:
  std::size_t nodes_;
  std::vector<BitTable> tables_;
  std::vector<MixerWeights> weights_;
};

/// Everything that is learnt while positions are told.
struct PlaneModels {
  static constexpr std::size_t kLengths = 26;
  MixedTables plane{{16, 16, 16}, 4};
  MixedTables level{{128, 64, 128}, 14};
  MixedTables second{{16, 16, 16}, 4};
  MixedTables coarse{{64, 64, 64}, kLengths};
  MixedTables line{{64, 64, 64}, kLengths};
  MixedTables last{{256, 256, 256}, kLengths};
};

template <class Io>
class PlanePositionCoder {
 public:
  PlanePositionCoder(Io& io, PlaneModels& models, int bits)
      : io_(io), models_(models), bits_(bits) {}

  /// Codes `point`, or reads it with the choice. False if what was read is outside of the grid.
  [[nodiscard]] bool code(const Outlook& outlook, PositionChoice& choice, GridPoint& point,
                          ToldVertex& told) {
    told = {};
    if (outlook.plane_count == 0) return code_without_plane(outlook, point, told);
    choice.plane = code_index(choice.plane, outlook.plane_count, outlook);
    const Plane& plane = outlook.planes[choice.plane];
    const auto axes = plane_axes(plane.normal);
    code_levels(outlook, axes, choice);
    for (std::size_t i = 0; i < 2; ++i) told.levels[axes[i]] = choice.levels[i];
    told.kind = static_cast<VertexKind>(1 + (choice.levels[0] >= kFineLevel ? 1 : 0) +
                                        (choice.levels[1] >= kFineLevel ? 1 : 0));
    // Coarse before fine.
    const std::size_t f = first_told(choice);
    const std::size_t first = axes[f], second = axes[1 - f], last = axes[2];
    const int level = choice.levels[1 - f];
    if (!code_near(outlook, choice.levels[f], first, told, point)) return false;
    if (level > 0) code_second_plane(outlook, first, choice);
    if (choice.second_plane == kNone || level == 0) {
      if (!code_near(outlook, level, second, told, point)) return false;
    } else {
      const std::int64_t expected =
          solve_line(plane, outlook.planes[choice.second_plane], first, second, point, bits_);
      const std::array<std::size_t, 3> contexts = {
          static_cast<std::size_t>(told.kind + 4 * std::min(level, 7)),
          static_cast<std::size_t>(std::min(outlook.least_last, 15) + 16 * (told.kind == 3)),
          static_cast<std::size_t>(outlook.shift(level))};
      const int shift = outlook.shift(level);
      if (!put(
              expected + (code_value((point[second] - expected) >> shift, models_.line, contexts, 0)
                          << shift),
              second, point))
        return false;
    }
    const std::int64_t expected = solve_plane(plane, last, point, bits_);
    const std::size_t kind = told.kind - 1u + 3 * std::min(choice.plane, 1u);
    const std::array<std::size_t, 3> contexts = {
        kind * 16 + static_cast<std::size_t>(std::min(outlook.mean_last, 15)),
        kind * 16 + static_cast<std::size_t>(std::min(outlook.least_last, 15)),
        kind * 32 + static_cast<std::size_t>(std::min(outlook.near.scale / 2, 31))};
    const std::int64_t e = code_value(point[last] - expected, models_.last, contexts, 0);
    told.last_length =
        static_cast<std::uint8_t>(std::bit_width(static_cast<std::uint64_t>(std::abs(e))));
    return put(expected + e, last, point);
  }

 private:
  [[nodiscard]] bool put(std::int64_t x, std::size_t axis, GridPoint& point) const {
    if (x < 0 || x >= std::int64_t{1} << bits_) return false;
    point[axis] = static_cast<std::int32_t>(x);
    return true;
  }

  [[nodiscard]] bool code_without_plane(const Outlook& outlook, GridPoint& point,
                                        ToldVertex& told) {
    told.kind = 3;
    for (std::size_t k = 0; k < 3; ++k) {
      if (outlook.near.neighbours == 0) {
        point[k] = static_cast<std::int32_t>(
            code_long_bits(io_, static_cast<std::uint32_t>(point[k]), bits_));
      } else if (!code_near(outlook, outlook.finest_level(), k, told, point)) {
        return false;
      }
    }
    told.last_length = static_cast<std::uint8_t>(outlook.near.scale / 2);
    return true;
  }

  std::uint32_t code_index(std::uint32_t index, std::uint32_t count, const Outlook& o) {
    const std::array<std::size_t, 3> contexts = {
        static_cast<std::size_t>(4 * (o.is_level ? 1 : 0) + static_cast<int>(count) - 1),
        o.gate_kinds,
        static_cast<std::size_t>(std::min(o.kinds[2], 3) * 4 + std::min(o.kinds[1], 3))};
    std::uint32_t i = 0;
    while (i + 1 < count && models_.plane.code(io_, index > i, contexts, i)) ++i;
    return i;
  }

  void code_levels(const Outlook& o, const std::array<std::size_t, 3>& axes,
                   PositionChoice& choice) {
    for (std::size_t i = 0; i < 2; ++i) {
      const std::size_t before = i == 0 ? 0 : 1u + std::min<std::size_t>(choice.levels[0], 6);
      const std::array<std::size_t, 3> contexts = {
          16 * before + 4 * std::min(choice.plane, 3u) + (o.plane_count - 1),
          16 * (i + 2 * (o.is_level ? 1u : 0u)) + o.gate_kinds,
          16 * before + static_cast<std::size_t>(o.mean_levels[axes[i]])};
      int level = 0;
      while (level < o.finest_level() && models_.level.code(io_, choice.levels[i] > level, contexts,
                                                            static_cast<std::size_t>(level)))
        ++level;
      choice.levels[i] = static_cast<std::uint8_t>(level);
    }
  }

  /// The planes that make a line with the first, in order; the choice of one of them or none.
  void code_second_plane(const Outlook& o, std::size_t axis, PositionChoice& choice) {
    const std::size_t both =
        choice.levels[0] >= kFineLevel && choice.levels[1] >= kFineLevel ? 1 : 0;
    std::uint32_t chosen = kNone;
    std::uint32_t seen = 0;
    for (std::uint32_t i = 0; i < o.plane_count && chosen == kNone; ++i) {
      if (i == choice.plane || !have_line(o.planes[choice.plane], o.planes[i], axis)) continue;
      const std::array<std::size_t, 3> contexts = {
          8 * both + 4 * std::min(choice.plane, 1u) + std::min(i, 3u), o.gate_kinds,
          static_cast<std::size_t>(std::min(o.kinds[2], 3) * 4 + std::min(o.kinds[3], 3))};
      if (models_.second.code(io_, choice.second_plane == i, contexts, seen++)) chosen = i;
    }
    choice.second_plane = chosen;
  }

  /// A coordinate that no plane tells.
  [[nodiscard]] bool code_near(const Outlook& o, int level, std::size_t axis, ToldVertex& told,
                               GridPoint& point) {
    const std::int64_t expected = o.near.point[axis];
    const int shift = o.shift(level);
    const std::int64_t e = (point[axis] - expected) >> shift;
    const auto neighbours = static_cast<std::size_t>(o.near.neighbours);
    // From levels to the coarsest one: raw bits.
    const int skipped = std::max(0, o.coarse_bits - shift - 1);
    const std::array<std::size_t, 3> contexts = {
        neighbours * 4 + told.kind,
        static_cast<std::size_t>(std::min(o.most_coarse, 7)) * 8 +
            static_cast<std::size_t>(std::min<int>(told.coarse_length, 7)),
        o.gate_kinds + 16 * static_cast<std::size_t>(std::min(level, 3))};
    const std::int64_t q = code_value(e, models_.coarse, contexts, skipped);
    const auto length = std::bit_width(static_cast<std::uint64_t>(std::abs(q) >> skipped));
    told.coarse_length = std::max(told.coarse_length, static_cast<std::uint8_t>(length));
    return put(expected + q * (std::int64_t{1} << shift), axis, point);
  }

  /// A bit length less `skipped` in unary, then the bits below the leading one.
  std::int64_t code_value(std::int64_t e, MixedTables& lengths,
                          const std::array<std::size_t, 3>& contexts, int skipped) {
    const auto magnitude = static_cast<std::uint32_t>(std::abs(e));
    const int length = static_cast<int>(std::bit_width(magnitude));
    int symbol = 0;
    while (symbol + skipped < bits_ + 1 &&
           lengths.code(io_, length > symbol + skipped, contexts, static_cast<std::size_t>(symbol)))
      ++symbol;
    std::uint32_t coded = 0;
    if (symbol == 0) {
      coded = code_long_bits(io_, magnitude, skipped);
    } else {
      const int below = symbol + skipped - 1;
      const std::uint32_t lead = std::uint32_t{1} << below;
      coded = lead + code_long_bits(io_, magnitude & (lead - 1), below);
    }
    if (coded == 0) return 0;
    return io_.bits(e < 0 ? 1 : 0, 1) == 1 ? -std::int64_t{coded} : std::int64_t{coded};
  }

  Io& io_;
  PlaneModels& models_;
  int bits_;
};

/// The vertices in turn, with what is known of each: shared by encoder and decoder.
class PlaneTraversal {
 public:
  PlaneTraversal(const ClosedMesh& mesh, int bits)
      : order_(mesh),
        told_(mesh.vertex_count),
        bits_(bits),
        default_scale_(
            std::max(2, 2 * bits + 3 - static_cast<int>(std::bit_width(mesh.vertex_count)))) {}

  [[nodiscard]] std::uint32_t next() { return order_.next(); }
  [[nodiscard]] Outlook look_out(std::uint32_t vertex, std::span<const GridPoint> points) const {
    return entropy::look_out(order_, points, told_, vertex, bits_, default_scale_, 0);
  }
  void finish(std::uint32_t vertex, const ToldVertex& told) {
    told_[vertex] = told;
    order_.finish(vertex);
  }

 private:
  PositionOrder order_;
  std::vector<ToldVertex> told_;
  int bits_;
  int default_scale_;
};

}  // namespace nacre::entropy
