// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <numeric>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/geometry.h"

/// What a list of triangles is, found the slow way: with ordered maps, from the definitions.
namespace nacre {

struct ManifoldFacts {
  /// Empty for an oriented 2-manifold by vertex ids: no corner twice in a triangle, each directed
  /// side once, all triangles of a vertex in one fan, every vertex in a triangle. Else what is
  /// wrong; the counts are then meaningless.
  std::string defect;
  std::size_t pieces = 0, closed_pieces = 0, boundary_loops = 0;
  int genus = 0;  ///< summed over the pieces, boundary loops capped
};

namespace manifold_detail {

class Sets {
 public:
  explicit Sets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  std::size_t find(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t a, std::size_t b) { parent_[find(a)] = find(b); }

 private:
  std::vector<std::size_t> parent_;
};

using DirectedSides = std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t>;

/// Every triangle around a vertex spans one side of its link; the link must hang together.
inline std::string fan_defect(std::span<const Triangle> triangles, std::uint32_t vertex_count) {
  std::vector<std::map<std::uint32_t, std::uint32_t>> link(vertex_count);
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) link[t[k]][t[(k + 1) % 3]] = t[(k + 2) % 3];
  for (std::uint32_t v = 0; v < vertex_count; ++v) {
    if (link[v].empty()) return "vertex " + std::to_string(v) + " has no triangle";
    // A link in one part is one path or one cycle: at most one of its vertices starts it.
    std::set<std::uint32_t> ends;
    for (const auto& [from, to] : link[v]) ends.insert(to);
    std::uint32_t start = link[v].begin()->first;
    for (const auto& [from, to] : link[v])
      if (ends.count(from) == 0) start = from;
    std::size_t met = 0;
    for (std::uint32_t at = start; link[v].count(at) > 0 && met <= link[v].size(); ++met) {
      at = link[v][at];
      if (at == start) {
        ++met;
        break;
      }
    }
    if (met != link[v].size()) return "vertex " + std::to_string(v) + " has several fans";
  }
  return {};
}

}  // namespace manifold_detail

inline ManifoldFacts manifold_facts(std::span<const Triangle> triangles, std::size_t vertex_count) {
  using namespace manifold_detail;
  ManifoldFacts facts;
  DirectedSides sides;
  for (std::size_t f = 0; f < triangles.size(); ++f) {
    const Triangle& t = triangles[f];
    for (std::size_t k = 0; k < 3; ++k) {
      if (t[k] >= vertex_count) return {"triangle " + std::to_string(f) + " is out of range"};
      if (t[k] == t[(k + 1) % 3]) return {"triangle " + std::to_string(f) + " repeats a corner"};
      if (!sides.emplace(std::pair(t[k], t[(k + 1) % 3]), f).second)
        return {"triangle " + std::to_string(f) + " repeats a directed side"};
    }
  }
  facts.defect = fan_defect(triangles, static_cast<std::uint32_t>(vertex_count));
  if (!facts.defect.empty()) return facts;

  Sets pieces(vertex_count);
  std::map<std::uint32_t, std::uint32_t> next;  // along the boundary
  std::map<std::size_t, long> euler, loops;     // by piece
  for (const auto& [side, face] : sides) pieces.join(side.first, side.second);
  for (std::size_t v = 0; v < vertex_count; ++v) ++euler[pieces.find(v)];
  for (const Triangle& t : triangles) ++euler[pieces.find(t[0])];
  for (const auto& [side, face] : sides) {
    const bool border = sides.count({side.second, side.first}) == 0;
    if (border || side.first < side.second) --euler[pieces.find(side.first)];
    if (border) next[side.first] = side.second;
  }
  std::set<std::uint32_t> seen;
  for (const auto& [start, to] : next) {
    if (seen.count(start) > 0) continue;
    ++loops[pieces.find(start)];
    for (std::uint32_t at = start; seen.insert(at).second;) at = next.at(at);
  }
  for (const auto& [piece, chi] : euler) {
    ++facts.pieces;
    facts.closed_pieces += loops[piece] == 0;
    facts.boundary_loops += static_cast<std::size_t>(loops[piece]);
    const long twice_genus = 2 - chi - loops[piece];
    if (twice_genus < 0 || twice_genus % 2 != 0) return {"a piece has no whole genus"};
    facts.genus += static_cast<int>(twice_genus / 2);
  }
  return facts;
}

}  // namespace nacre
