// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "remesh/clean_steps.h"

namespace nacre::remesh {

/// The sides along each boundary loop, each loop in the order in which its faces run.
[[nodiscard]] std::vector<std::vector<std::uint32_t>> boundary_loops(
    std::span<const std::uint32_t> partner);

/// Closes the loops with triangles between their vertices (CGAL's hole filling), or around a new
/// vertex in the middle where these would meet edges that are there already. New triangles take
/// piece and source from the first face of their loop.
void fill_loops(CleanScan& cleaned, std::vector<std::uint32_t>& source,
                std::span<const std::vector<std::uint32_t>> loops);

}  // namespace nacre::remesh
