// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "base/scan.h"
#include "data/range_view.h"

namespace nacre::data {

/// Averages the views' signed distances on a grid, weighted by how squarely each saw the surface
/// (Curless and Levoy's volumetric merging), and extracts the zero surface with marching
/// tetrahedra. Where no view measured anything there is no weight and the mesh has a hole; before
/// that, voxels among measured ones take their mean, `pinhole_rounds` times, which closes the
/// smallest holes.
[[nodiscard]] Scan merge_views(std::span<const RangeView> views, const Target& target,
                               const SimulationOptions& options);

/// Collapses short edges until at most `faces` are left. CGAL.
[[nodiscard]] Scan simplify(const Scan& scan, std::size_t faces);

/// Drops components with fewer faces and vertices on no face; keeps the order of the others.
[[nodiscard]] Scan drop_islands(const Scan& scan, std::size_t smallest_island);

/// Faces of each component, largest first.
[[nodiscard]] std::vector<std::size_t> component_sizes(const Scan& scan);

}  // namespace nacre::data
