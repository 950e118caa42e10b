// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "codec/geometry_coder.h"

/// The finest semi-regular mesh as a surface: what counts is how far a vertex is from it, not how
/// far from where it was.
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

/// Normals of the finest level with its vertices at `positions`, by area, unit length.
[[nodiscard]] std::vector<Vec3> surface_normals(const Topology& topology,
                                                std::span<const Vec3> positions);

/// A point of the finest mesh as it should be, near some place.
struct SurfaceFoot {
  Vec3 point = Vec3::Zero();
  double squared_distance = 0;
};
/// Found by descent from vertex `from` over the mesh, so it may be a local minimum.
[[nodiscard]] SurfaceFoot foot_on_surface(const Prepared& prepared, const SurfaceWeights& weights,
                                          const Vec3& place, std::uint32_t from);

/// Mean squared distance of vertices to the original, looked for around the same vertex, by area;
/// of every n-th vertex where there are hundreds of thousands.
[[nodiscard]] double surface_error(const Prepared& prepared, const SurfaceWeights& weights,
                                   std::span<const Vec3> positions);

}  // namespace nacre::codec
