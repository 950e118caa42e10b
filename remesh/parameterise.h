// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "base/run_context.h"
#include "base/scan.h"
#include "remesh/base_domain.h"

namespace nacre::remesh {

struct ParameteriseOptions {
  /// What is solved at a time: the inside of each base triangle, or that of all base triangles
  /// around a base vertex, which also smooths across their borders. Stars cost three times as much.
  enum class Patches : std::uint8_t { kTriangles, kStars };
  Patches patches = Patches::kTriangles;
  int passes = 1;        ///< over all patches; 0 .. any
  bool stretch = false;  ///< divide weights by the square root of the neighbour's area stretch
};

/// What became of the patches, summed over the passes.
struct ParameteriseReport {
  std::size_t solved = 0;
  std::size_t not_disks = 0;  ///< left alone: not connected by one border
  std::size_t refused = 0;  ///< left alone: no solution, or more triangles turned over than before
  std::size_t empty = 0;    ///< nothing inside to solve for
};

/// Solves for the map inside patches of the scan: mean-value coordinates, the patch's border fixed
/// where it is. This takes the kinks out of the map that simplification leaves, one linear system
/// per patch, by CGAL's surface mesh parameterisation.
///
/// A patch is the largest connected part of the scan triangles that have all corners in one base
/// triangle, or in one star. Ensures  no triangle inside a patch is turned over that was not
/// before; patch borders and scan boundaries stay; the same result at any thread count. Source
/// [Floater2003]; README.md.
ParameteriseReport parameterise(const Scan& scan, Parameterisation& parameterisation,
                                const ParameteriseOptions& options, const RunContext& context = {});

}  // namespace nacre::remesh
