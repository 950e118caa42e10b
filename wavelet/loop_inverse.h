// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "base/topology.h"

namespace nacre::wavelet {

/// The positions of `level` whose image under Loop's even rule is `moved` (one per vertex).
///
/// Cost     linear: some 40 conjugate-gradient steps per pass, two passes, at any size
/// Errors   kNoConvergence
[[nodiscard]] Result<std::vector<Vec3>> invert_loop_even_rule(const LevelTopology& level,
                                                              std::span<const Vec3> moved);

}  // namespace nacre::wavelet
