// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "base/run_context.h"
#include "base/scan.h"

namespace nacre::remesh {

/// Moves the vertices of a simplified mesh to where the two surfaces are nearest in the least
/// squares of their distances, both ways. A collapse knows planes only, and no more of them than it
/// took away. Triangles stay as they are; none turns by more than 45 degrees in a round.
///
/// `mesh` is relative to the scan's origin; either without triangles: nothing is done.
/// Source   [HoppeEtAl1993] the fit of one connectivity, but to tangent planes.
void fit_surface(const Scan& scan, Scan& mesh, const RunContext& context = {});

}  // namespace nacre::remesh
