// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "remesh/remesh.h"

namespace nacre::remesh {

/// Maps all pieces onto one base mesh together; those that come out unhealthy once more, each on
/// its own: onto denser bases, and in the end onto its own triangles. No piece stops the others.
///
/// `useful`: see BaseSize.
/// Errors   kGeometryRefused: no area; kNoConvergence: no base was useful; kCancelled.
[[nodiscard]] Result<MappedScan> map_pieces(const CleanScan& cleaned, const Options& options,
                                            int useful, const RunContext& context);

/// The scan mapped onto itself.
[[nodiscard]] MappedScan keep(CleanScan cleaned, int levels, const char* why);

}  // namespace nacre::remesh
