// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "base/result.h"
#include "base/scan.h"
#include "base/semi_regular_mesh.h"

namespace nacre::app {

/// Finds out how a mesh was made by 1 → 4 splits, whatever the order of its vertices and triangles,
/// and undoes them: as often as every component allows, or `levels` times if that is not 0. Corners
/// in the same place are welded if the mesh is no manifold without that (STL).
///
/// Ensures  (1) the result has the mesh's vertices, each once and to the bit, and its triangles
///          (2) as many levels as there are, or the one that allows fewest has
/// Cost     linear, a few hash lookups for each vertex.
/// Errors   kGeometryRefused: no oriented manifold; a component that no split can have made; fewer
///          splits than `levels`.
/// Source   [Taubin2002]: triangles in fours around a middle one, grown from a seed and checked.
[[nodiscard]] Result<SemiRegularMesh> recognise_subdivision(const Scan& mesh, int levels = 0);

}  // namespace nacre::app
