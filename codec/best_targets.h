// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "codec/geometry_coder.h"

/// What the levels of a mesh should aim at when the finer ones will be coded coarsely or not at
/// all.
namespace nacre::codec {

/// How errors of the semi-regular mesh count as errors of its surface.
struct SurfaceWeights {
  std::vector<Vec3> normals;  ///< of the finest mesh, unit length, per vertex
  std::vector<double> areas;  ///< per vertex of the finest mesh, 1 in the mean
  /// areas[v] for a vertex's own level: the area around it there, 1 in the mean of each level.
  /// Entry j: of the vertices that level j adds; entry 0: the base.
  std::vector<std::vector<double>> level_areas;
  /// Triangles of the finest level around its vertex v: fans[fan_begin[v] .. fan_begin[v + 1]).
  std::vector<std::uint32_t> fans, fan_begin;
};

[[nodiscard]] SurfaceWeights surface_weights(const Prepared& prepared);

/// Mean squared distance of vertices to the original, looked for around the same vertex, by area.
[[nodiscard]] double surface_error(const Prepared& prepared, const SurfaceWeights& weights,
                                   std::span<const Vec3> positions);

/// Positions per level: entry 0 the base's, entry j those of the vertices that level j adds.
using Targets = std::vector<std::vector<Vec3>>;

/// The mesh itself: every level interpolates the finest.
[[nodiscard]] Targets interpolating_targets(const Prepared& prepared);

/// Details along the normals that make surface error + the cost of details least, by iterated
/// shrinkage [Beck2009]. `step` is the quantiser's on the finest level, `gains` of base and bands.
[[nodiscard]] Targets sparse_targets(const Prepared& prepared, const SurfaceWeights& weights,
                                     double step, const std::vector<double>& gains, int rounds);

}  // namespace nacre::codec
