// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/result.h"
#include "entropy/connectivity.h"

namespace nacre::entropy {

/// Positions that PlanePositionWriter wrote; `bits` as there.
///
/// Errors   kCorruptStream.
[[nodiscard]] Result<std::vector<GridPoint>> decode_positions_by_planes(
    std::span<const std::uint8_t> bytes, const Connectivity& connectivity, int bits);

}  // namespace nacre::entropy
