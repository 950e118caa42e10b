// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "base/topology.h"

namespace nacre::wavelet {

/// Loop's share of each of the `valence` neighbours of an interior vertex,
/// (5/8 - (3/8 + cos(2π/K)/4)^2) / K, in libm-free arithmetic; the vertex keeps 1 - K times it.
[[nodiscard]] double loop_beta(std::uint32_t valence);

/// What each vertex of a level averages in Loop's even rule, and how it is weighted.
struct LoopNeighbours {
  std::vector<std::uint32_t> count;  ///< edges; at a boundary vertex, boundary edges only
  std::vector<bool> boundary;
};
[[nodiscard]] LoopNeighbours loop_neighbours(const LevelTopology& level);

/// Share of each counted neighbour of a vertex: loop_beta, or 1/4 split over the boundary
/// neighbours (1/8 each, cubic B-spline), or nothing for a vertex without edges.
[[nodiscard]] double loop_share(const LoopNeighbours& neighbours, std::uint32_t vertex);

/// All vertices of the next level by Loop's rules: V moved ones, then one per edge.
///
/// Even     v + share Σ (q - v), over the counted neighbours in edge order
/// Odd      (a + b) 3/8 + (c + d) / 8; on the boundary (a + b) / 2
/// Source   [Loop1987]; boundary curve rules as in [Hoppe1994] and OpenSubdiv
[[nodiscard]] std::vector<Vec3> loop_subdivide(const LevelTopology& level,
                                               std::span<const Vec3> coarse);

}  // namespace nacre::wavelet
