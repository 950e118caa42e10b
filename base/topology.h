// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "base/geometry.h"
#include "base/result.h"

namespace nacre {

/// One edge of one level. Directed as in its first face: face[0] has it as vertex[0] → vertex[1].
struct Edge {
  std::array<std::uint32_t, 2> vertex;
  std::array<std::uint32_t, 2> face;  ///< face[1] == kNone on the boundary

  [[nodiscard]] bool is_boundary() const { return face[1] == kNone; }
};

/// Connectivity of one level. Side k of a triangle joins its corners k and (k + 1) % 3.
struct LevelTopology {
  std::uint32_t vertex_count = 0;
  std::vector<Triangle> triangles;       ///< vertex ids, counter-clockwise from outside
  std::vector<Triangle> triangle_edges;  ///< edge id of side k; empty on the finest level
  std::vector<Edge> edges;               ///< empty on the finest level

  /// The corner of `triangle` that is not on `edge`.
  [[nodiscard]] std::uint32_t opposite_corner(std::uint32_t triangle, std::uint32_t edge) const;
  /// Triangle 4 f + k of the next level.
  [[nodiscard]] Triangle child(std::size_t f, std::size_t k) const {
    const std::uint32_t v = vertex_count;
    const Triangle& e = triangle_edges[f];
    if (k == 3) return {v + e[0], v + e[1], v + e[2]};
    return {triangles[f][k], v + e[k], v + e[k == 0 ? 2 : k - 1]};
  }
};

/// Connectivity of a semi-regular mesh: a base mesh and its 1→4 splits, numbered canonically.
///
/// Numbering, for a level with V vertices, E edges and F triangles; the next level has
///   vertices   0 .. V-1 kept; vertex V + e is the midpoint of edge e
///   edges      2e = (vertex[0], m), 2e+1 = (m, vertex[1]) for edge e with midpoint m;
///              2E + 3f + k = the edge that cuts corner k off triangle f, from side k's midpoint
///              to side (k+2)%3's
///   triangles  4f + k = (corner k, midpoint of side k, midpoint of side (k+2)%3) for k < 3;
///              4f + 3 = (midpoints of sides 0, 1, 2)
/// Base edges are numbered by first appearance over the triangles' sides 0, 1, 2 in order. So the
/// vertices of a level are a prefix of those of the next, and no search or hash is ever needed.
class Topology {
 public:
  /// Builds all levels 0 .. level_count.
  ///
  /// Errors   kBadInput if a vertex id is out of range, a triangle repeats a vertex, an edge has
  ///          more than two triangles or two of the same direction; `where` is the triangle.
  ///          kLimitExceeded if the finest level would not fit in 32-bit ids.
  static Result<Topology> build(std::span<const Triangle> base_triangles,
                                std::uint32_t base_vertex_count, int level_count);
  /// The same, with a finest level that has only its vertex count: all that decoding needs. Its
  /// triangles, half of the memory of all levels, are made by triangle() when they are asked for.
  static Result<Topology> build_for_decoding(std::span<const Triangle> base_triangles,
                                             std::uint32_t base_vertex_count, int level_count);

  /// J: how many times the base is split. Levels are 0 .. J; bands are 0 .. J-1, band j holding
  /// the vertices that level j+1 adds to level j.
  [[nodiscard]] int level_count() const { return static_cast<int>(levels_.size()) - 1; }
  [[nodiscard]] const LevelTopology& level(int j) const { return levels_[static_cast<size_t>(j)]; }
  [[nodiscard]] std::uint32_t vertex_count() const { return levels_.back().vertex_count; }
  [[nodiscard]] std::size_t triangle_count(int j) const {
    return levels_.front().triangles.size() << (2 * j);
  }
  /// Of any level, also of a finest one that has only its vertex count.
  [[nodiscard]] Triangle triangle(int j, std::size_t i) const {
    const auto& stored = level(j).triangles;
    return stored.empty() ? level(j - 1).child(i / 4, i % 4) : stored[i];
  }
  [[nodiscard]] std::uint32_t band_size(int j) const {
    return level(j + 1).vertex_count - level(j).vertex_count;
  }

 private:
  enum class Finest : bool { kCounted, kWithTriangles };
  static Result<Topology> build(std::span<const Triangle> base_triangles,
                                std::uint32_t base_vertex_count, int level_count, Finest finest);

  std::vector<LevelTopology> levels_;
};

}  // namespace nacre
