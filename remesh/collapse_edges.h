// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "base/result.h"
#include "base/run_context.h"
#include "remesh/remesh.h"

namespace nacre::remesh {

/// A clean scan with about `vertices` vertices (more where topology needs them), placed wherever
/// they serve the surface best: a mesh to be coded as it is, onto which nothing is mapped. Pieces,
/// genus and boundary loops stay.
///
/// Errors   kNoConvergence: CGAL failed; kCancelled.
/// Source   [LindstromTurk1998], as in CGAL.
[[nodiscard]] Result<CleanScan> collapse_edges(CleanScan cleaned, int vertices,
                                               const RunContext& context);

/// The same in a fraction of the time and some tenths of a decibel worse: most vertices of a large
/// scan go by simplify(), which is cheap, and the rest by collapse_edges().
[[nodiscard]] Result<CleanScan> collapse_edges_quickly(CleanScan cleaned, int vertices,
                                                       const RunContext& context);

}  // namespace nacre::remesh
