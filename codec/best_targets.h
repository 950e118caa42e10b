// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "codec/geometry_coder.h"
#include "codec/surface_weights.h"

/// What the levels of a mesh should aim at when the finer ones will be coded coarsely or not at
/// all.
namespace nacre::codec {

/// Positions per level: entry 0 the base's, entry j those of the vertices that level j adds.
using Targets = std::vector<std::vector<Vec3>>;

/// The mesh itself: every level interpolates the finest.
[[nodiscard]] Targets interpolating_targets(const Prepared& prepared);

/// Of the surface that the targets are; what SurfaceWeights::normals are to be with targets.
[[nodiscard]] std::vector<Vec3> target_normals(const Topology& topology, const Targets& targets);

/// Details along the normals that make surface error + the cost of details least, by iterated
/// shrinkage [Beck2009]; the base stays. `step` is the quantiser's on the finest level, `gains` of
/// base and bands.
[[nodiscard]] Targets sparse_targets(const Prepared& prepared, const SurfaceWeights& weights,
                                     double step, const std::vector<double>& gains, int rounds);

}  // namespace nacre::codec
