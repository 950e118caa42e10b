// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "base/result.h"
#include "base/scan.h"

/// What every measurement does first with its two surfaces.
namespace nacre::metric {

/// `b` relative to the origin of `a`. Errors   kBadInput if an origin is not finite.
[[nodiscard]] Result<Scan> moved_beside(const Scan& a, const Scan& b);

/// What Surface::build() asks of a scan, for work that goes on beside it. Errors   as there.
[[nodiscard]] Result<void> check_surface(const Scan& scan);

/// Largest absolute coordinate of a vertex that lies on a face.
[[nodiscard]] double largest_coordinate(const Scan& scan);

}  // namespace nacre::metric
