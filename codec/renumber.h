// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/topology.h"

namespace nacre::codec {

/// Maps a semi-regular mesh onto the numbering its decoder will have: entry i is the vertex of
/// `input` that is vertex i of `canonical`. The two base meshes are the same up to the order of
/// vertices (`base_order`, same meaning as the result), of triangles, and of each one's corners.
///
/// Errors   kBadInput if they are not; `where` is the triangle of `canonical`.
[[nodiscard]] Result<std::vector<std::uint32_t>> canonical_order(
    const Topology& input, const Topology& canonical, std::span<const std::uint32_t> base_order);

}  // namespace nacre::codec
