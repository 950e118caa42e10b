// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "base/geometry.h"

namespace nacre::remesh {

/// Calls visit(sides) for every edge of the triangles with the sides that lie on it, ascending;
/// side k of triangle f is 3 f + k. Edges come by their lower vertex, then by their higher one.
template <class Visit>
void for_each_edge(std::span<const Triangle> triangles, std::uint32_t vertex_count,
                   const Visit& visit) {
  // Sides in buckets by their lower vertex, each sorted by the other: no vertex can be so crowded
  // that this takes more than n log n.
  std::vector<std::uint32_t> start(static_cast<std::size_t>(vertex_count) + 2, 0);
  const auto low = [](const Triangle& t, std::uint32_t k) {
    return std::min(t[k], t[(k + 1) % 3]);
  };
  for (const Triangle& t : triangles)
    for (std::uint32_t k = 0; k < 3; ++k) ++start[low(t, k) + 2];
  for (std::size_t v = 2; v < start.size(); ++v) start[v] += start[v - 1];
  std::vector<std::uint64_t> sides(3 * triangles.size());  // the higher vertex, then the side
  for (std::uint32_t f = 0; f < triangles.size(); ++f) {
    const Triangle& t = triangles[f];
    for (std::uint32_t k = 0; k < 3; ++k)
      sides[start[low(t, k) + 1]++] =
          std::uint64_t{std::max(t[k], t[(k + 1) % 3])} << 32 | (3 * f + k);
  }
  std::vector<std::uint32_t> group;
  for (std::size_t v = 0; v < vertex_count; ++v) {
    const std::span bucket(sides.begin() + start[v], sides.begin() + start[v + 1]);
    std::sort(bucket.begin(), bucket.end());
    for (std::size_t i = 0; i < bucket.size();) {
      const std::uint64_t other = bucket[i] >> 32;
      group.clear();
      for (; i < bucket.size() && bucket[i] >> 32 == other; ++i)
        group.push_back(static_cast<std::uint32_t>(bucket[i]));
      visit(std::span<const std::uint32_t>(group));
    }
  }
}

/// Per side: the other one on its edge, or kNone where an edge has not two.
[[nodiscard]] inline std::vector<std::uint32_t> side_partners(std::span<const Triangle> triangles,
                                                              std::size_t vertex_count) {
  std::vector<std::uint32_t> partner(3 * triangles.size(), kNone);
  for_each_edge(triangles, static_cast<std::uint32_t>(vertex_count),
                [&](std::span<const std::uint32_t> sides) {
                  if (sides.size() != 2) return;
                  partner[sides[0]] = sides[1];
                  partner[sides[1]] = sides[0];
                });
  return partner;
}

}  // namespace nacre::remesh
