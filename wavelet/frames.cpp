// SPDX-License-Identifier: Apache-2.0
#include "wavelet/frames.h"

#include <cmath>

namespace nacre::wavelet {
namespace {

// Squares of lengths in this range have full relative precision; NaN is in no range.
constexpr double kLeastSquare = 0x1p-900;
constexpr double kMostSquare = 0x1p900;
// An edge this steep on its tangent plane (squared) gives no direction worth having.
constexpr double kLeastTangent = 0x1p-40;

bool usable(double square) { return square >= kLeastSquare && square <= kMostSquare; }

/// A face's side k with its ends and the other two midpoints, as ids into the predicted mesh.
struct Corner {
  std::uint32_t from, to, opposite;  // side k, directed as in the face
  std::uint32_t after, before;       // midpoints of sides k + 1 and k + 2
};

Corner look_from(const LevelTopology& level, std::uint32_t face, std::uint32_t e) {
  const Triangle& t = level.triangles[face];
  const Triangle& s = level.triangle_edges[face];
  const std::uint32_t k = s[0] == e ? 0 : (s[1] == e ? 1 : 2);
  const std::uint32_t k1 = k == 2 ? 0 : k + 1, k2 = k1 == 2 ? 0 : k1 + 1;
  return {t[k], t[k1], t[k2], level.vertex_count + s[k1], level.vertex_count + s[k2]};
}

/// Twice the vector area of (to, after, before, from): a quadrilateral's is its diagonals' product.
Vec3 half_ring_area(std::span<const Vec3> p, const Corner& c) {
  return cross(p[c.before] - p[c.to], p[c.from] - p[c.after]);
}

Vec3 coarse_normal(const LevelTopology& level, std::span<const Vec3> p, std::uint32_t e) {
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

}  // namespace

Vec3 midpoint_normal(const LevelTopology& level, std::span<const Vec3> p, std::uint32_t e) {
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

Frame frame_of(const Vec3& n, const Vec3& edge) {
  Vec3 along = edge - n * dot(n, edge);
  const double square = dot(along, along);
  if (usable(square) && square > kLeastTangent * dot(edge, edge)) {
    along /= std::sqrt(square);
  } else {
    const double x = std::abs(n[0]), y = std::abs(n[1]), z = std::abs(n[2]);
    const int axis = x <= y && x <= z ? 0 : (y <= z ? 1 : 2);
    along = n * -n[axis];
    along[axis] += 1.0;
    along /= norm(along);
  }
  return {n, cross(along, n), along};
}

}  // namespace nacre::wavelet
