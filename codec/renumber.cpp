// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/renumber.h"

#include <algorithm>
#include <string>
#include <tuple>

namespace nacre::codec {
namespace {

/// The same triangle in the input: corner k here is corner (k + turn) % 3 there.
struct Counterpart {
  std::uint32_t triangle;
  std::uint32_t turn;
};

struct DirectedSide {
  std::uint32_t from, to;
  Counterpart at;
};

Result<std::vector<Counterpart>> match_base(const LevelTopology& input,
                                            const LevelTopology& canonical,
                                            std::span<const std::uint32_t> base_order) {
  const auto by_ends = [](const DirectedSide& a, const DirectedSide& b) {
    return std::tie(a.from, a.to) < std::tie(b.from, b.to);
  };
  std::vector<DirectedSide> sides;
  sides.reserve(3 * input.triangles.size());
  for (std::uint32_t f = 0; f < input.triangles.size(); ++f) {
    const Triangle& t = input.triangles[f];
    for (std::uint32_t k = 0; k < 3; ++k) sides.push_back({t[k], t[(k + 1) % 3], {f, k}});
  }
  std::sort(sides.begin(), sides.end(), by_ends);

  std::vector<Counterpart> match;
  match.reserve(canonical.triangles.size());
  for (std::size_t f = 0; f < canonical.triangles.size(); ++f) {
    Triangle t;
    for (std::size_t k = 0; k < 3; ++k) t[k] = base_order[canonical.triangles[f][k]];
    const auto side =
        std::lower_bound(sides.begin(), sides.end(), DirectedSide{t[0], t[1], {}}, by_ends);
    if (side == sides.end() || side->from != t[0] || side->to != t[1] ||
        input.triangles[side->at.triangle][(side->at.turn + 2) % 3] != t[2]) {
      return Error{ErrorCode::kBadInput,
                   "base triangle " + std::to_string(f) + " has no counterpart", f};
    }
    match.push_back(side->at);
  }
  return match;
}

/// A corner child has its corner first in both numberings; the middle one is turned as its parent.
std::vector<Counterpart> match_children(const std::vector<Counterpart>& parents) {
  std::vector<Counterpart> children(4 * parents.size());
  for (std::size_t f = 0; f < parents.size(); ++f) {
    const auto [triangle, turn] = parents[f];
    for (std::uint32_t k = 0; k < 3; ++k) children[4 * f + k] = {4 * triangle + (k + turn) % 3, 0};
    children[4 * f + 3] = {4 * triangle + 3, turn};
  }
  return children;
}

}  // namespace

Result<std::vector<std::uint32_t>> canonical_order(const Topology& input, const Topology& canonical,
                                                   std::span<const std::uint32_t> base_order) {
  const LevelTopology& base = canonical.level(0);
  if (input.level_count() != canonical.level_count() ||
      input.vertex_count() != canonical.vertex_count() ||
      input.level(0).triangles.size() != base.triangles.size() ||
      base_order.size() != base.vertex_count) {
    return Error{ErrorCode::kBadInput, "the two base meshes differ in size", 0};
  }
  auto match = match_base(input.level(0), base, base_order);
  if (!match) return match.error();

  std::vector<std::uint32_t> order(canonical.vertex_count());
  std::copy(base_order.begin(), base_order.end(), order.begin());
  for (int j = 0; j < canonical.level_count(); ++j) {
    const LevelTopology &ours = canonical.level(j), &theirs = input.level(j);
    for (std::size_t f = 0; f < ours.triangles.size(); ++f) {
      const auto [triangle, turn] = (*match)[f];
      for (std::size_t k = 0; k < 3; ++k) {
        order[ours.vertex_count + ours.triangle_edges[f][k]] =
            theirs.vertex_count + theirs.triangle_edges[triangle][(k + turn) % 3];
      }
    }
    if (j + 1 < canonical.level_count()) *match = match_children(*match);
  }
  return order;
}

}  // namespace nacre::codec
