// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "base/geometry.h"

/// Neighbour relations of an oriented 2-manifold given as triangles.
namespace nacre::remesh {

/// Entry [f][k]: the triangle across side k (corner k → corner k + 1) of triangle f, or kNone.
///
/// Where a side has no partner of opposite direction, or more than one candidate, it is a boundary.
[[nodiscard]] std::vector<Triangle> side_neighbors(std::span<const Triangle> triangles,
                                                   std::uint32_t vertex_count);

/// The corner (0 .. 2) at which `triangle` has `vertex`.
inline std::uint32_t corner_of(const Triangle& triangle, std::uint32_t vertex) {
  return triangle[0] == vertex ? 0u : (triangle[1] == vertex ? 1u : 2u);
}

/// The faces around a vertex, counter-clockwise, and the vertices that they span with it:
/// face m is (vertex, ring[m], ring[m + 1]). ring is cyclic for an interior vertex; on the boundary
/// it has one more entry than faces.
struct Star {
  std::vector<std::uint32_t> faces;
  std::vector<std::uint32_t> ring;
  bool boundary = false;

  [[nodiscard]] std::uint32_t ring_at(std::size_t m) const {
    return ring[m < ring.size() ? m : m - ring.size()];
  }
};

/// Collects the star of `vertex` into `star`, starting from any face that has it.
void collect_star(std::span<const Triangle> triangles, std::span<const Triangle> neighbors,
                  std::uint32_t vertex, std::uint32_t start_face, Star& star);

/// One face per vertex; kNone for a vertex without one.
[[nodiscard]] std::vector<std::uint32_t> face_of_vertex(std::span<const Triangle> triangles,
                                                        std::uint32_t vertex_count);

}  // namespace nacre::remesh
