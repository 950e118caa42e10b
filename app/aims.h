// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "app/goal_search.h"
#include "base/semi_regular_mesh.h"

namespace nacre::app {

/// Where the vertices of a normal mesh should be for its *triangles* to be nearest the scan. A
/// normal mesh has its vertices on the scan, so where that bulges all triangles lie on its inner
/// side; here each vertex is moved along its normal by about what the triangles around it miss in
/// the mean. Vertices of the boundary stay.
///
/// Shapes   as `mesh.positions`, relative to the same origin; empty: the mesh has no levels.
/// Cost     one nearest point for each finest triangle.
/// Ensures  the same at any thread count.
[[nodiscard]] std::vector<Vec3> aims_between(const SemiRegularMesh& mesh,
                                             const Reference& reference);

}  // namespace nacre::app
