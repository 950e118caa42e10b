// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "base/geometry.h"

/// The sculpture that the simulated scanner looks at.
namespace nacre::data {

/// Negative inside an ammonite on a piece of rock, positive outside: a hollow logarithmic spiral
/// with ribs, nodes, a keel and growth lines. About 2.4 units wide, `y` up, the coil's axis along
/// `z`; the shell's centre is the origin.
///
/// Ensures  outside, no surface is nearer to p than ammonite(p) / kLipschitz, so that a ray can
/// step
///          that far.
[[nodiscard]] double ammonite(const Vec3& p);

inline constexpr double kLipschitz = 1.8;

/// The sculpture lies in the ball of this radius around the origin.
inline constexpr double kBoundingRadius = 2.0;

}  // namespace nacre::data
