// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "base/topology.h"

/// frames.h's normals, of points from wherever `p[id]` has them: an array, or made one by one.
namespace nacre::wavelet {

// Squares of lengths in this range have full relative precision; NaN is in no range.
inline constexpr double kLeastSquare = 0x1p-900;
inline constexpr double kMostSquare = 0x1p900;

inline bool usable(double square) { return square >= kLeastSquare && square <= kMostSquare; }

/// A face's side k with its ends and the other two midpoints, as ids into the predicted mesh.
struct Corner {
  std::uint32_t from, to, opposite;  // side k, directed as in the face
  std::uint32_t after, before;       // midpoints of sides k + 1 and k + 2
};

inline Corner look_from(const LevelTopology& level, std::uint32_t face, std::uint32_t e) {
  const Triangle& t = level.triangles[face];
  const Triangle& s = level.triangle_edges[face];
  const std::uint32_t k = s[0] == e ? 0 : (s[1] == e ? 1 : 2);
  const std::uint32_t k1 = k == 2 ? 0 : k + 1, k2 = k1 == 2 ? 0 : k1 + 1;
  return {t[k], t[k1], t[k2], level.vertex_count + s[k1], level.vertex_count + s[k2]};
}

/// Twice the vector area of (to, after, before, from): a quadrilateral's is its diagonals' product.
template <class Points>
Vec3 half_ring_area(const Points& p, const Corner& c) {
  return cross(p[c.before] - p[c.to], p[c.from] - p[c.after]);
}

template <class Points>
Vec3 coarse_normal(const LevelTopology& level, const Points& p, std::uint32_t e) {
  Vec3 sum = Vec3::Zero();
  for (const std::uint32_t face : level.edges[e].face) {
    if (face == kNone) continue;
    const Corner c = look_from(level, face, e);
    sum += cross(p[c.to] - p[c.from], p[c.opposite] - p[c.from]);
  }
  const double square = dot(sum, sum);
  if (usable(square)) return sum / std::sqrt(square);
  return {0, 0, 1};
}

/// See midpoint_normal().
template <class Points>
Vec3 normal_at_midpoint(const LevelTopology& level, const Points& p, std::uint32_t e) {
  const Edge& edge = level.edges[e];
  const Corner left = look_from(level, edge.face[0], e);
  Vec3 sum = half_ring_area(p, left);
  if (edge.is_boundary()) {
    const Vec3& m = p[level.vertex_count + e];
    sum += cross(p[left.to] - m, p[left.from] - m);
  } else {
    sum += half_ring_area(p, look_from(level, edge.face[1], e));
  }
  const double square = dot(sum, sum);
  if (usable(square)) return sum / std::sqrt(square);
  return coarse_normal(level, p, e);
}

}  // namespace nacre::wavelet
