// SPDX-License-Identifier: Apache-2.0
#include "base/topology.h"

#include <algorithm>
#include <limits>
#include <string>
#include <tuple>

namespace nacre {
namespace {

Error bad_triangle(std::size_t triangle, const std::string& what) {
  return {ErrorCode::kBadInput, "base triangle " + std::to_string(triangle) + " " + what, triangle};
}

/// One side of one triangle, keyed so that both sides of an edge sort together.
struct Side {
  std::uint32_t low, high;       // vertex ids, low < high
  std::uint32_t triangle, side;  // where it is
};

Result<void> check_triangles(std::span<const Triangle> triangles, std::uint32_t vertex_count) {
  for (std::size_t f = 0; f < triangles.size(); ++f) {
    const Triangle& t = triangles[f];
    for (const std::uint32_t v : t) {
      if (v >= vertex_count)
        return bad_triangle(
            f, "names vertex " + std::to_string(v) + " of " + std::to_string(vertex_count));
    }
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return bad_triangle(f, "repeats a vertex");
  }
  return {};
}

Result<void> number_base_edges(LevelTopology& level) {
  const auto& triangles = level.triangles;
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (std::uint32_t f = 0; f < triangles.size(); ++f) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t a = triangles[f][k], b = triangles[f][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), f, k});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& x, const Side& y) {
    return std::tie(x.low, x.high, x.triangle, x.side) <
           std::tie(y.low, y.high, y.triangle, y.side);
  });
  // The twin of each side, or kNone; sides are addressed as 3 * triangle + side.
  std::vector<std::uint32_t> twin(3 * triangles.size(), kNone);
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end].low == sides[i].low && sides[end].high == sides[i].high)
      ++end;
    if (end - i > 2) return bad_triangle(sides[i + 2].triangle, "is a third one on an edge");
    if (end - i == 2) {
      const Side &x = sides[i], &y = sides[i + 1];
      if (triangles[x.triangle][x.side] == triangles[y.triangle][y.side])
        return bad_triangle(y.triangle, "is oriented against its neighbour");
      twin[3 * x.triangle + x.side] = 3 * y.triangle + y.side;
      twin[3 * y.triangle + y.side] = 3 * x.triangle + x.side;
    }
    i = end;
  }
  level.triangle_edges.assign(triangles.size(), Triangle{kNone, kNone, kNone});
  for (std::uint32_t f = 0; f < triangles.size(); ++f) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      if (level.triangle_edges[f][k] != kNone) continue;
      const auto id = static_cast<std::uint32_t>(level.edges.size());
      const std::uint32_t other = twin[3 * f + k];
      level.edges.push_back(
          {{triangles[f][k], triangles[f][(k + 1) % 3]}, {f, other == kNone ? kNone : other / 3}});
      level.triangle_edges[f][k] = id;
      if (other != kNone) level.triangle_edges[other / 3][other % 3] = id;
    }
  }
  return {};
}

/// The next level's triangles and, unless it is the finest, its edges. See the class comment.
LevelTopology split(const LevelTopology& level, bool with_edges) {
  const auto E = static_cast<std::uint32_t>(level.edges.size());
  const auto F = static_cast<std::uint32_t>(level.triangles.size());
  const std::uint32_t V = level.vertex_count;
  LevelTopology next;
  next.vertex_count = V + E;
  next.triangles.resize(4 * static_cast<std::size_t>(F));
  for (std::size_t i = 0; i < next.triangles.size(); ++i)
    next.triangles[i] = level.child(i / 4, i % 4);
  if (!with_edges) return next;

  next.edges.resize(2 * static_cast<std::size_t>(E) + 3 * static_cast<std::size_t>(F));
  next.triangle_edges.resize(next.triangles.size());
  for (std::uint32_t e = 0; e < E; ++e) {
    const Edge& edge = level.edges[e];
    // The child at corner k of a face owns the half of each side that touches the corner.
    const auto child_at = [&](std::uint32_t face, std::uint32_t vertex) {
      if (face == kNone) return kNone;
      std::uint32_t k = 0;
      while (level.triangles[face][k] != vertex) ++k;
      return 4 * face + k;
    };
    for (std::uint32_t h = 0; h < 2; ++h) {
      Edge& half = next.edges[2 * e + h];
      half.vertex = h == 0 ? std::array{edge.vertex[0], V + e} : std::array{V + e, edge.vertex[1]};
      half.face = {child_at(edge.face[0], edge.vertex[h]), child_at(edge.face[1], edge.vertex[h])};
    }
  }
  for (std::uint32_t f = 0; f < F; ++f) {
    const Triangle& e = level.triangle_edges[f];
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t previous = (k + 2) % 3;
      const std::uint32_t inner = 2 * E + 3 * f + k;
      next.edges[inner] = {{V + e[k], V + e[previous]}, {4 * f + k, 4 * f + 3}};
      // Half 0 of an edge touches its vertex[0].
      const std::uint32_t v = level.triangles[f][k];
      const std::uint32_t out = 2 * e[k] + (level.edges[e[k]].vertex[0] == v ? 0 : 1);
      const std::uint32_t in = 2 * e[previous] + (level.edges[e[previous]].vertex[0] == v ? 0 : 1);
      next.triangle_edges[4 * f + k] = {out, inner, in};
      // Side s of the middle triangle joins the midpoints of sides s and s + 1: it cuts off corner
      // s + 1.
      next.triangle_edges[4 * f + 3][previous] = inner;
    }
  }
  return next;
}

}  // namespace

std::uint32_t LevelTopology::opposite_corner(std::uint32_t triangle, std::uint32_t edge) const {
  const Triangle& e = triangle_edges[triangle];
  const std::uint32_t side = e[0] == edge ? 0 : (e[1] == edge ? 1 : 2);
  return triangles[triangle][(side + 2) % 3];
}

Result<Topology> Topology::build(std::span<const Triangle> base_triangles,
                                 std::uint32_t base_vertex_count, int level_count) {
  return build(base_triangles, base_vertex_count, level_count, Finest::kWithTriangles);
}

Result<Topology> Topology::build_for_decoding(std::span<const Triangle> base_triangles,
                                              std::uint32_t base_vertex_count, int level_count) {
  return build(base_triangles, base_vertex_count, level_count, Finest::kCounted);
}

Result<Topology> Topology::build(std::span<const Triangle> base_triangles,
                                 std::uint32_t base_vertex_count, int level_count, Finest finest) {
  // 4^J F faces and 3 · 4^J F / 2 edges must fit below kNone; edges are the largest set.
  constexpr std::uint64_t kMaxIds = std::numeric_limits<std::uint32_t>::max() / 4;
  if (level_count < 0 || level_count > 15 ||
      ((static_cast<std::uint64_t>(base_triangles.size()) * 3) << (2 * level_count)) > kMaxIds) {
    return Error{ErrorCode::kLimitExceeded,
                 std::to_string(base_triangles.size()) + " base triangles split " +
                     std::to_string(level_count) + " times do not fit in 32-bit ids",
                 0};
  }
  if (const auto ok = check_triangles(base_triangles, base_vertex_count); !ok) return ok.error();

  Topology topology;
  LevelTopology base;
  base.vertex_count = base_vertex_count;
  base.triangles.assign(base_triangles.begin(), base_triangles.end());
  if (const auto ok = number_base_edges(base); !ok) return ok.error();
  topology.levels_.reserve(static_cast<std::size_t>(level_count) + 1);
  topology.levels_.push_back(std::move(base));
  for (int j = 0; j < level_count; ++j) {
    const LevelTopology& last = topology.levels_.back();
    LevelTopology next;
    if (j + 1 < level_count || finest == Finest::kWithTriangles) {
      next = split(last, j + 1 < level_count);
    } else {
      next.vertex_count = last.vertex_count + static_cast<std::uint32_t>(last.edges.size());
    }
    topology.levels_.push_back(std::move(next));
  }
  return topology;
}

}  // namespace nacre
