// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "alloc/alloc.h"

namespace nacre::alloc {

/// The samples on the lower convex hull of (bits, distortion), from the fewest bits to the least
/// distortion: bits strictly increase, distortion strictly decreases, slopes strictly increase.
/// Of samples at the same point the one with the larger step is kept.
std::vector<Sample> lower_hull(std::span<const Sample> samples);

}  // namespace nacre::alloc
