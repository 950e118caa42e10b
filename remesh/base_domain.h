// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "base/geometry.h"

namespace nacre::remesh {

/// A point of the base domain: barycentric weights in one base triangle, each made of unit sides.
struct DomainPoint {
  std::uint32_t face = kNone;
  std::array<double, 3> weight{};
};

/// A point of the scan: barycentric weights in one of its triangles.
struct SurfacePoint {
  std::uint32_t face = kNone;
  std::array<double, 3> weight{};
};

[[nodiscard]] inline Vec3 position_of(const SurfacePoint& p, std::span<const Triangle> triangles,
                                      std::span<const Vec3> positions) {
  const Triangle& t = triangles[p.face];
  return p.weight[0] * positions[t[0]] + p.weight[1] * positions[t[1]] +
         p.weight[2] * positions[t[2]];
}

/// The point of a triangle that is nearest to `p` in its plane, if that is inside.
[[nodiscard]] inline SurfacePoint point_below(const Vec3& p, std::uint32_t face,
                                              std::span<const Triangle> triangles,
                                              std::span<const Vec3> positions) {
  const Triangle& t = triangles[face];
  const Vec3 &a = positions[t[0]], &b = positions[t[1]], &c = positions[t[2]];
  const Vec3 n = (b - a).cross(c - a);
  const double area2 = n.squaredNorm();
  const double wb = std::clamp((p - a).cross(c - a).dot(n) / area2, 0.0, 1.0);
  const double wc = std::clamp((b - a).cross(p - a).dot(n) / area2, 0.0, 1.0 - wb);
  return {face, {1 - wb - wc, wb, wc}};
}

/// The base mesh, and where it came from: base vertex i started at scan vertex scan_vertex[i].
struct BaseMesh {
  std::vector<Triangle> triangles;
  std::vector<Triangle> neighbors;
  std::vector<std::uint32_t> scan_vertex;
  /// Where vertices are instead of where the map has their corners (face kNone: there); empty:
  /// none.
  std::vector<SurfacePoint> moved = {};
};

/// A one-to-one map of the scan onto the base mesh, linear on each scan triangle: where in the base
/// domain each scan vertex lies.
struct Parameterisation {
  BaseMesh base;
  std::vector<DomainPoint> point;  ///< per scan vertex
};

/// Per scan vertex: 1 for the base corners of small pieces without a boundary, which have to stay
/// at their corners. On so few triangles a map whose corners slide shrinks to nothing.
[[nodiscard]] std::vector<char> pinned_vertices(const Parameterisation& map);

}  // namespace nacre::remesh
