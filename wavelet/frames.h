// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "base/topology.h"

namespace nacre::wavelet {

/// Normal of the midpoint of edge `e`, from the level + 1 mesh `predicted` (all its vertices, in
/// topology order): its triangles' area-weighted normal, of unit length.
///
/// Sum        with a → b the edge in its first face, and r, s the midpoints of that face's sides
///            after and before it: (s - b) × (a - r), plus the same with a and b exchanged for the
///            second face; on the boundary, plus (b - m) × (a - m) instead, m being the midpoint.
///            It is twice the vector area of the triangles around m.
/// Fallback   when the square of the sum's length is not within 2^-900 .. 2^900: the sum over the
///            edge's faces of (b - a) × (c - a), c the opposite corner; when that fails too: +z.
[[nodiscard]] Vec3 midpoint_normal(const LevelTopology& level, std::span<const Vec3> predicted,
                                   std::uint32_t e);

/// Edge `e` from its vertex 0 to its vertex 1 in the predicted mesh.
[[nodiscard]] inline Vec3 edge_vector(const LevelTopology& level, std::span<const Vec3> predicted,
                                      std::uint32_t e) {
  return predicted[level.edges[e].vertex[1]] - predicted[level.edges[e].vertex[0]];
}

/// The frame with the given unit normal at the midpoint of an edge along `edge`: tangent2 is the
/// edge less its part along the normal, of unit length; tangent1 = tangent2 × normal, across the
/// edge.
///
/// Fallback   when |tangential part|² is not above 2^-40 |edge|², or not within 2^-900 .. 2^900:
/// the
///            first coordinate axis of least |component| in the normal takes the edge's place.
[[nodiscard]] Frame frame_of(const Vec3& normal, const Vec3& edge);

}  // namespace nacre::wavelet
