// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "base/scan.h"
#include "remesh/base_domain.h"

/// Deep pits and high spikes of one vertex, as scanners and hole fillers leave them. Nothing smooth
/// goes through their walls, so each wall is best one triangle of the base.
namespace nacre::remesh {

/// Inner vertices at which the surface comes to a point, outward or inward: all angles there
/// together are less than 120° (a cone 39° wide), and every edge there is longer than two of the
/// scan's mean edges. Ascending.
[[nodiscard]] std::vector<std::uint32_t> tips_of(const Scan& scan);

/// Per vertex: 1 for tips and their neighbours.
[[nodiscard]] std::vector<char> vertices_at_tips(const Scan& scan);

/// Per scan vertex: 1 for base corners that have to stay at their corners: pinned_vertices(), and
/// those at tips and around them. A map slides off a tip, and what reaches for it then folds.
[[nodiscard]] std::vector<char> held_vertices(const Scan& scan, const Parameterisation& map);

}  // namespace nacre::remesh
