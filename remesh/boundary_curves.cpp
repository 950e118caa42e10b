// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/boundary_curves.h"

#include <algorithm>
#include <cmath>

#include "remesh/adjacency.h"

namespace nacre::remesh {

BoundaryCurves::BoundaryCurves(const SurfaceMap& map, const Parameterisation& parameterisation)
    : scan_(map.scan()) {
  const BaseMesh& base = parameterisation.base;
  const auto neighbors = map.neighbors();
  std::vector<std::uint32_t> next(scan_.positions.size(), kNone);
  face_before_.assign(scan_.positions.size(), kNone);
  for (std::uint32_t f = 0; f < scan_.triangles.size(); ++f) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      if (neighbors[f][k] != kNone) continue;
      next[scan_.triangles[f][k]] = scan_.triangles[f][(k + 1) % 3];
      face_before_[scan_.triangles[f][k]] = f;
    }
  }
  curve_of_side_.assign(3 * base.triangles.size(), kNone);
  for (std::uint32_t f = 0; f < base.triangles.size(); ++f) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      if (base.neighbors[f][k] != kNone) continue;
      curve_of_side_[3 * f + k] = static_cast<std::uint32_t>(curves_.size());
      Curve curve;
      std::uint32_t v = base.scan_vertex[base.triangles[f][k]];
      const std::uint32_t end = base.scan_vertex[base.triangles[f][(k + 1) % 3]];
      curve.vertex.push_back(v);
      curve.parameter.push_back(0);
      while (v != end) {
        const double step = (scan_.positions[next[v]] - scan_.positions[v]).norm();
        curve.parameter.push_back(curve.parameter.back() + step);
        v = next[v];
        curve.vertex.push_back(v);
      }
      const double total = std::max(curve.parameter.back(), 1e-300);
      for (double& t : curve.parameter) t /= total;
      curve.parameter.back() = 1;
      curves_.push_back(std::move(curve));
    }
  }
}

SurfacePoint BoundaryCurves::point_at(const Curve& curve, std::size_t segment, double share) const {
  const std::uint32_t v = curve.vertex[segment];
  SurfacePoint p{face_before_[v], {}};
  const std::uint32_t c = corner_of(scan_.triangles[p.face], v);
  p.weight[c] = 1 - share;
  p.weight[(c + 1) % 3] = share;
  return p;
}

BoundaryCurves::Hit BoundaryCurves::pierce(std::uint32_t face, std::uint32_t side, double from,
                                           double to, const Vec3& through,
                                           const Vec3& direction) const {
  const Curve& curve = curves_[curve_of_side_[3 * face + side]];
  const double middle = (from + to) / 2;
  // "Well inside": further from both ends than a fifth of the way, so that no edge collapses.
  const double low = from + 0.2 * (to - from), high = to - 0.2 * (to - from);
  std::optional<Hit> best, centre;
  for (std::size_t i = 0; i + 1 < curve.vertex.size(); ++i) {
    const double t0 = curve.parameter[i], t1 = curve.parameter[i + 1];
    if (t1 < low || t0 > high) continue;
    if (!centre && middle <= t1)
      centre = Hit{middle, point_at(curve, i, t1 > t0 ? (middle - t0) / (t1 - t0) : 0)};
    const double d0 = (scan_.positions[curve.vertex[i]] - through).dot(direction);
    const double d1 = (scan_.positions[curve.vertex[i + 1]] - through).dot(direction);
    if ((d0 > 0) == (d1 > 0)) continue;
    const double share = d0 / (d0 - d1);
    const double t = t0 + share * (t1 - t0);
    if (t < low || t > high) continue;
    if (!best || std::abs(t - middle) < std::abs(best->parameter - middle))
      best = Hit{t, point_at(curve, i, share)};
  }
  if (best) return *best;
  if (centre) return *centre;
  return {middle, point_at(curve, 0, middle)};
}

}  // namespace nacre::remesh
