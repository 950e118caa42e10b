// SPDX-License-Identifier: Apache-2.0
#include "wavelet/loop.h"

#include "wavelet/turn.h"

namespace nacre::wavelet {
namespace {

/// Whether the even rule at one end of `edge` looks along it.
bool counts(const LoopNeighbours& neighbours, const Edge& edge, std::uint32_t vertex) {
  return edge.is_boundary() || !neighbours.boundary[vertex];
}

}  // namespace

double loop_beta(std::uint32_t valence) {
  if (valence == 6) return 1.0 / 16;
  const double cosine = turn(1, valence).cos;
  const double a = 0.375 + 0.25 * cosine;
  return (0.625 - a * a) / static_cast<double>(valence);
}

LoopNeighbours loop_neighbours(const LevelTopology& level) {
  LoopNeighbours result;
  result.count.assign(level.vertex_count, 0);
  result.boundary.assign(level.vertex_count, false);
  for (const Edge& edge : level.edges) {
    if (!edge.is_boundary()) continue;
    for (const std::uint32_t v : edge.vertex) result.boundary[v] = true;
  }
  for (const Edge& edge : level.edges) {
    for (const std::uint32_t v : edge.vertex) {
      if (counts(result, edge, v)) ++result.count[v];
    }
  }
  return result;
}

double loop_share(const LoopNeighbours& neighbours, std::uint32_t vertex) {
  const std::uint32_t count = neighbours.count[vertex];
  if (count == 0) return 0.0;
  return neighbours.boundary[vertex] ? 0.25 / static_cast<double>(count) : loop_beta(count);
}

std::vector<Vec3> loop_subdivide(const LevelTopology& level, std::span<const Vec3> p) {
  const std::uint32_t kept = level.vertex_count;
  const LoopNeighbours neighbours = loop_neighbours(level);
  std::vector<Vec3> next(kept + level.edges.size());
  std::fill(next.begin(), next.begin() + kept, Vec3::Zero());
  for (std::uint32_t e = 0; e < level.edges.size(); ++e) {
    const Edge& edge = level.edges[e];
    const auto [a, b] = edge.vertex;
    if (counts(neighbours, edge, a)) next[a] += p[b] - p[a];
    if (counts(neighbours, edge, b)) next[b] += p[a] - p[b];
    if (edge.is_boundary()) {
      next[kept + e] = (p[a] + p[b]) * 0.5;
    } else {
      const Vec3& c = p[level.opposite_corner(edge.face[0], e)];
      const Vec3& d = p[level.opposite_corner(edge.face[1], e)];
      next[kept + e] = (p[a] + p[b]) * 0.375 + (c + d) * 0.125;
    }
  }
  for (std::uint32_t v = 0; v < kept; ++v) next[v] = p[v] + next[v] * loop_share(neighbours, v);
  return next;
}

}  // namespace nacre::wavelet
