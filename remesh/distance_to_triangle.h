// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>

#include "base/geometry.h"

namespace nacre::remesh {

[[nodiscard]] inline double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const double length2 = (b - a).squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(b - a) / length2, 0.0, 1.0) : 0;
  return (a + t * (b - a) - p).norm();
}

[[nodiscard]] inline double distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b,
                                                 const Vec3& c) {
  const Vec3 n = (b - a).cross(c - a);
  if (n.dot((b - a).cross(p - a)) >= 0 && n.dot((c - b).cross(p - b)) >= 0 &&
      n.dot((a - c).cross(p - c)) >= 0 && n.norm() > 0)
    return std::abs(n.dot(p - a)) / n.norm();
  return std::min(
      {distance_to_segment(p, a, b), distance_to_segment(p, b, c), distance_to_segment(p, c, a)});
}

}  // namespace nacre::remesh
