// SPDX-License-Identifier: Apache-2.0
#include "wavelet/frames.h"

#include <cmath>

#include "wavelet/normal_at_midpoint.h"

namespace nacre::wavelet {
namespace {

// An edge this steep on its tangent plane (squared) gives no direction worth having.
constexpr double kLeastTangent = 0x1p-40;

}  // namespace

Vec3 midpoint_normal(const LevelTopology& level, std::span<const Vec3> p, std::uint32_t e) {
  return normal_at_midpoint(level, p, e);
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
