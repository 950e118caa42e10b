// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "base/run_context.h"
#include "base/semi_regular_mesh.h"
#include "remesh/remesh.h"
#include "remesh/surface_map.h"

namespace nacre::remesh {

/// Lines against the scan; immutable, safe to share between threads.
class LineTree {
 public:
  explicit LineTree(const Scan& scan);
  struct Hit {
    double t = 0;  ///< along the direction from the origin
    SurfacePoint point;
  };
  /// All hits of origin + t direction with |t| <= reach, nearest first.
  [[nodiscard]] std::vector<Hit> hits(const Vec3& origin, const Vec3& direction,
                                      double reach) const;
  /// The nearest point of the scan.
  [[nodiscard]] SurfacePoint nearest(const Vec3& query) const;

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

struct PierceOptions {
  int levels = 5;
  /// A hit counts if it lies within this many edge lengths of the expected point: on level 1, where
  /// the expected point is the less certain of the two, and on all others.
  double first_aperture = 2.0, aperture = 1.0;
  double reach = 0.75;        ///< and within this many edge lengths of the prediction
  double least_facing = 0.2;  ///< and its normal agrees with the line by this cosine
  /// Where the boundary curve is no farther than this share of the scan's extent from the line of a
  /// boundary vertex, the vertex is on its line. 0: boundary vertices are on the curve.
  double near_boundary = 3e-5;
  /// Folds that stay are mended by moving vertices of coarser levels as well.
  bool move_older = true;
};

struct Pierced {
  SemiRegularMesh mesh;
  std::vector<BandReport> bands;
  /// Per vertex: 0 the detail is normal only, 1 on a boundary curve with a vector detail, 2 vector
  /// detail elsewhere.
  std::vector<std::uint8_t> kind;
  /// Per base triangle: how many folded triangles it has on all levels together.
  std::vector<std::uint32_t> folds;
};

/// Refines the base mesh level by level: each new vertex is where the line through its predicted
/// point, along the predicted normal, meets the scan near the expected point.
///
/// Source   [GuskovNormalMeshes2000] section 4; README.md.
[[nodiscard]] Result<Pierced> pierce(const SurfaceMap& map,
                                     const Parameterisation& parameterisation, const LineTree& tree,
                                     const LevelPredictor& predict, const PierceOptions& options,
                                     const RunContext& context = {});

}  // namespace nacre::remesh
