// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "remesh/surface_map.h"

namespace nacre::remesh {

/// The scan's boundary, cut at the base corners: one polyline for each base boundary edge, with
/// points addressed by arc length, 0 at the edge's first corner and 1 at its second.
class BoundaryCurves {
 public:
  explicit BoundaryCurves(const SurfaceMap& map, const Parameterisation& parameterisation);

  struct Hit {
    double parameter = 0.5;
    SurfacePoint point;
  };
  /// The point of the curve of `side` of base triangle `face` that lies in the plane through
  /// `through` across `direction`, between the two parameters; the middle one if no such point is
  /// well inside.
  [[nodiscard]] Hit pierce(std::uint32_t face, std::uint32_t side, double from, double to,
                           const Vec3& through, const Vec3& direction) const;

 private:
  struct Curve {
    std::vector<std::uint32_t> vertex;  // scan vertices from corner to corner
    std::vector<double> parameter;
  };
  [[nodiscard]] SurfacePoint point_at(const Curve& curve, std::size_t segment, double share) const;

  const Scan& scan_;
  std::vector<std::uint32_t> curve_of_side_;  // per base side 3f + k, or kNone
  std::vector<Curve> curves_;
  std::vector<std::uint32_t> face_before_;  // per scan vertex: face whose border starts there
};

}  // namespace nacre::remesh
