// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "base/result.h"
#include "base/scan.h"
#include "metric/metric.h"

namespace nacre::app {

/// Finds folds of a remeshed surface by nothing but the two surfaces: it knows of no map, so it can
/// disagree with what a remesher says of itself.
class FoldCheck {
 public:
  /// `oriented` is the reference, as remesh::clean leaves it. Errors   as metric::Surface::build.
  static Result<FoldCheck> build(const Scan& oriented);

  struct Outcome {
    /// Per triangle: 1 if its normal opposes that of the reference's face nearest to its centroid,
    /// and those nearest to its three corners put together. The second holds back sheets thinner
    /// than the triangle is off the surface, whose nearest face is the other side's.
    std::vector<std::uint8_t> folded;
    std::vector<double> distance;  ///< per triangle: from its centroid to the reference
    std::size_t folds = 0;
    std::size_t opposed = 0;  ///< the first of the two conditions alone
  };
  [[nodiscard]] Outcome check(const Scan& mesh) const;

 private:
  FoldCheck(metric::Surface surface, const Scan& oriented);

  metric::Surface surface_;
  std::vector<Vec3> normals_;  // per triangle of the reference, unit length or zero
  Vec3 origin_;
};

}  // namespace nacre::app
