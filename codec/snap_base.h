// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "codec/surface_weights.h"

namespace nacre::codec {

/// The mesh, slid along its own surface so that its base vertices come to lie on points of the
/// base's grid that happen to be near the surface. Where a base vertex lies along the surface does
/// not matter, how far from it does; and among the grid points around there is one several times
/// nearer than rounding comes. So the grid can be coarser.
///
/// Finer vertices follow as the butterfly carries the base's slide to them. Base vertices on the
/// boundary are rounded; finer ones there stay.
[[nodiscard]] Prepared snap_base(const Prepared& prepared, const SurfaceWeights& weights,
                                 double grid_step);

}  // namespace nacre::codec
