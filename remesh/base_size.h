// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "remesh/choose_base.h"
#include "remesh/remesh.h"

/// How many base vertices and how many levels, where options leave that open.
namespace nacre::remesh {

/// Base and levels are chosen by the scan alone.
[[nodiscard]] bool is_free(const Options& options);

/// Enough splits for the semi-regular mesh to have about four triangles for each one of the scan,
/// or `asked`: from there on the remeshing error is below what any rate of interest leaves.
[[nodiscard]] int default_levels(std::size_t scan_triangles, std::size_t base_triangles,
                                 std::size_t asked);

/// Of these pieces together.
[[nodiscard]] BaseSize base_size(const Options& options, const std::vector<PieceReport>& pieces,
                                 std::size_t scan_vertices);

/// Base vertices instead of the `now` ones of a mesh that will be `error` (a share of its extent)
/// away from the scan, for its creases; 0: these will do, or the scan has too few vertices.
[[nodiscard]] int denser_base(std::size_t now, std::size_t scan_vertices, double error);

}  // namespace nacre::remesh
