// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "base/scan.h"
#include "remesh/base_domain.h"

namespace nacre::remesh {

/// Turns scan triangles that lie upside down in the domain the right way round: the vertices around
/// them move to the plain mean of their neighbours, in regions that grow until it helps. A convex
/// region with its border fixed comes out without any such triangle [Tutte1963]; relaxation's own
/// weights promise that only in one plane, and the domain is flat only chart by chart.
///
/// Returns  how many triangles are still turned over, or have corners in no common chart.
std::size_t untangle(const Scan& scan, Parameterisation& parameterisation);

}  // namespace nacre::remesh
