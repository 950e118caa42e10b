// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>

#include "base/geometry.h"

namespace nacre::metric {

inline double twice_area(const Vec3& a, const Vec3& b, const Vec3& c) {
  return norm(cross(b - a, c - a));
}

// With g = Gram determinant / product of the two squared edge lengths (about the squared thinness),
// barycentric coordinates lose a factor 1 / g of their digits, and the sides alone miss a foot
// point by at most sqrt(g) of the length.
/// Below this g the sides answer: 1e-6 of the length is less than what barycentric coordinates
/// lose.
inline constexpr double kSidesOnly = 1e-12;
/// Below this g one step of iterative refinement restores the digits of the foot point.
inline constexpr double kRefine = 1e-2;

inline Vec3 closest_on_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double length2 = dot(ab, ab);
  if (!(length2 > 0)) return a;
  return a + std::clamp(dot(p - a, ab) / length2, 0.0, 1.0) * ab;
}

/// For thin triangles: the nearest of the three sides' nearest points.
inline Vec3 closest_on_sides(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  Vec3 best = closest_on_segment(p, a, b);
  for (const Vec3& q : {closest_on_segment(p, b, c), closest_on_segment(p, c, a)})
    if (dot(p - q, p - q) < dot(p - best, p - best)) best = q;
  return best;
}

/// Point of triangle abc nearest to p, by Voronoi region of the triangle's features.
/// Source   [Ericson2005] section 5.1.5.
inline Vec3 closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double ab_ab = dot(ab, ab), ac_ac = dot(ac, ac), ab_ac = dot(ab, ac);
  const double gram = ab_ab * ac_ac - ab_ac * ab_ac;
  if (!(gram > kSidesOnly * ab_ab * ac_ac)) return closest_on_sides(p, a, b, c);

  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const double d3 = d1 - ab_ab, d4 = d2 - ab_ac;
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + (d1 / (d1 - d3)) * ab;
  const double d5 = d1 - ab_ac, d6 = d2 - ac_ac;
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + (d2 / (d2 - d6)) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b);
  const double scale = 1 / (va + vb + vc);
  double v = vb * scale, w = vc * scale;
  if (gram <= kRefine * ab_ab * ac_ac) {
    const Vec3 away = p - (a + v * ab + w * ac);
    const double r1 = dot(away, ab), r2 = dot(away, ac);  // zero but for rounding
    v += (r1 * ac_ac - r2 * ab_ac) / gram;
    w += (r2 * ab_ab - r1 * ab_ac) / gram;
  }
  // Rounding may have left the triangle; certified bounds need a point of it.
  v = std::max(v, 0.0);
  w = std::max(w, 0.0);
  const double sum = v + w;
  if (sum > 1) {
    v /= sum;
    w /= sum;
  }
  return a + v * ab + w * ac;
}

}  // namespace nacre::metric
