// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "base/result.h"
#include "base/run_context.h"
#include "base/scan.h"
#include "remesh/base_domain.h"

namespace nacre::remesh {

struct SimplifyOptions {
  /// Stop at this many vertices (topology may keep more). 0: where the root mean square distance of
  /// the scan's planes, as the quadrics know it, passes `rms_error`.
  int base_vertices = 0;
  double rms_error = 0.005;  ///< share of the bounding box diagonal
  /// Where rms_error decides: no fewer and no more vertices than this (0: as many as it likes).
  int least_vertices = 0, most_vertices = 0;
  double shape_weight = 0.3;  ///< weight of large and long triangles against the quadric error
  double normal_agreement =
      0.4;             ///< least cosine between a face and the scan normals it stands for
  bool chords = true;  ///< inner edges may come to join two boundary vertices
};

/// How much dearer it is than usual to remove each scan vertex (>= 1); empty: all alike. A survivor
/// inherits the importance of what collapses onto it.
using Importance = std::vector<double>;

/// Collapses half-edges of a clean scan, cheapest first, and keeps the map: with each collapse the
/// star is flattened before and after, and every scan vertex in it moves to the new triangles.
///
/// Ensures  (1) the base keeps pieces, genus and boundary loops; (2) every scan vertex has a point;
///          scan boundary vertices lie on base boundary edges; (3) the map of each flattened star
///          is one-to-one, so their composition is.
/// Source   [GarlandHeckbert1997] quadrics; [LeeEtAl1998] the map; README.md for the cost.
[[nodiscard]] Result<Parameterisation> simplify(const Scan& scan, const SimplifyOptions& options,
                                                const Importance& importance = {},
                                                const RunContext& context = {});

}  // namespace nacre::remesh
