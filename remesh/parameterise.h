// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "base/run_context.h"
#include "base/scan.h"
#include "remesh/base_domain.h"

namespace nacre::remesh {

/// What became of the base triangles' patches.
struct ParameteriseReport {
  std::size_t solved = 0;
  std::size_t not_disks = 0;  ///< left alone: not one piece with one border
  std::size_t refused = 0;    ///< left alone: the linear system has no solution
  std::size_t empty = 0;      ///< nothing inside to solve for
};

/// Solves for the map inside each base triangle: mean-value coordinates with the border of the
/// triangle's patch fixed where it is. This takes out the kinks that simplification leaves inside
/// patches; relaxation does so across them.
///
/// A patch is the largest connected part of the scan triangles that have all corners in the base
/// triangle.
///
/// Ensures  (1) every point stays in its base triangle; (2) no triangle of a patch is turned over
///          that was not before; (3) the borders of patches, and so the scan's boundary, stay;
///          (4) the same result at any thread count.
/// Cost     about 3 µs per scan vertex on one thread.
/// Source   [Floater2003]; docs/decisions/0002-parameterisation.md.
ParameteriseReport parameterise(const Scan& scan, Parameterisation& parameterisation,
                                const RunContext& context = {});

}  // namespace nacre::remesh
