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

/// The frame with the given unit normal: tangent1 is the first coordinate axis of least |component|
/// in the normal, minus its part along it, normalised; tangent2 = normal × tangent1.
[[nodiscard]] Frame frame_of(const Vec3& normal);

}  // namespace nacre::wavelet
