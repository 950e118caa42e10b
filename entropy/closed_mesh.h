// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/geometry.h"
#include "base/result.h"

namespace nacre::entropy {

/// An oriented 2-manifold, closed by one dummy vertex per boundary loop.
///
/// Half-edge 3 f + k runs from corner k of triangle f to corner (k + 1) % 3.
struct ClosedMesh {
  std::uint32_t vertex_count = 0;    ///< given vertices; dummies are numbered from here on
  std::vector<Triangle> triangles;   ///< the given ones, then the dummies' fans
  std::vector<std::uint32_t> twins;  ///< per half-edge, the one that runs the other way
  /// Triangles around each vertex, dummies included; also the number of its edges.
  std::vector<std::uint32_t> valences;

  [[nodiscard]] bool is_dummy(std::uint32_t vertex) const { return vertex >= vertex_count; }
  [[nodiscard]] std::uint32_t from(std::uint32_t half_edge) const {
    return triangles[half_edge / 3][half_edge % 3];
  }
};

[[nodiscard]] constexpr std::uint32_t next_side(std::uint32_t half_edge) {
  return half_edge % 3 == 2 ? half_edge - 2 : half_edge + 1;
}
[[nodiscard]] constexpr std::uint32_t previous_side(std::uint32_t half_edge) {
  return half_edge % 3 == 0 ? half_edge + 2 : half_edge - 1;
}

/// Errors   kBadInput unless the triangles are an oriented 2-manifold, with or without boundary,
/// that
///          uses every vertex: ids in range, no repeated corner, each edge in one or two triangles
///          that run along it in opposite directions, the triangles at a vertex one fan. `where` is
///          the triangle, or the vertex when the message names one.
[[nodiscard]] Result<ClosedMesh> close_mesh(std::span<const Triangle> triangles,
                                            std::uint32_t vertex_count);

}  // namespace nacre::entropy
