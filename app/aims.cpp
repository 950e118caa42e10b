// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/aims.h"

#include <cmath>

#include "base/parallel.h"
#include "base/topology.h"

namespace nacre::app {
namespace {

/// Of a bulge c (λ1 λ2 + λ2 λ3 + λ3 λ1) over a triangle: its mean, over its height in the middle.
constexpr double kMeanOfBulge = 0.75;
/// A nearest point farther from a triangle than this share of its size is none that it cuts off.
constexpr double kFarthest = 0.25;

/// Sums over the triangles around a vertex.
struct Around {
  Vec3 normal = Vec3::Zero();  ///< by area
  double area = 0, volume = 0;
};

std::vector<char> boundary_of(const Topology& topology) {
  std::vector<char> on_boundary(topology.vertex_count(), 0);
  for (int j = 0; j < topology.level_count(); ++j) {
    const LevelTopology& level = topology.level(j);
    for (std::size_t e = 0; e < level.edges.size(); ++e) {
      if (!level.edges[e].is_boundary()) continue;
      on_boundary[level.vertex_count + e] = 1;
      for (const std::uint32_t v : level.edges[e].vertex) on_boundary[v] = 1;
    }
  }
  return on_boundary;
}

/// Heights of the scan above the middles of the finest triangles, 4 f + k, over their normals.
std::vector<double> heights(const LevelTopology& parents, const SemiRegularMesh& mesh,
                            const Reference& reference) {
  const std::vector<Vec3>& p = mesh.positions;
  const Vec3 shift = mesh.origin - reference.scan.origin;
  std::vector<double> out(4 * parents.triangles.size(), 0.0);
  parallel_for_each_index(parents.triangles.size(), [&](std::size_t f) {
    metric::Surface::Nearest nearest;
    for (std::size_t k = 0; k < 4; ++k) {
      const Triangle t = parents.child(f, k);
      const Vec3 normal = cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
      const double size2 = norm(normal);
      if (!(size2 > 0)) continue;
      const Vec3 middle = (p[t[0]] + p[t[1]] + p[t[2]]) / 3 + shift;
      nearest = nearest.triangle == kNone ? reference.surface.nearest(middle)
                                          : reference.surface.nearest(middle, nearest);
      const double height = dot(nearest.point - middle, normal) / size2;
      if (std::abs(height) <= kFarthest * std::sqrt(size2)) out[4 * f + k] = height;
    }
  });
  return out;
}

}  // namespace

std::vector<Vec3> aims_between(const SemiRegularMesh& mesh, const Reference& reference) {
  if (mesh.level_count == 0) return {};
  const auto topology =
      Topology::build_for_decoding(mesh.base_triangles, mesh.base_vertex_count, mesh.level_count);
  if (!topology) return {};
  const LevelTopology& parents = topology->level(mesh.level_count - 1);
  const std::vector<double> height = heights(parents, mesh, reference);
  std::vector<Vec3> aims = mesh.positions;
  std::vector<Around> around(aims.size());
  for (std::size_t f = 0; f < height.size(); ++f) {
    const Triangle t = parents.child(f / 4, f % 4);
    const Vec3 normal = cross(aims[t[1]] - aims[t[0]], aims[t[2]] - aims[t[0]]);
    const double area = norm(normal);
    for (const std::uint32_t v : t) {
      around[v].normal += normal;
      around[v].area += area;
      around[v].volume += area * height[f];
    }
  }
  const std::vector<char> on_boundary = boundary_of(*topology);
  parallel_for_each_index(aims.size(), [&](std::size_t v) {
    const double length = norm(around[v].normal);
    if (on_boundary[v] || !(length > 0)) return;
    aims[v] += kMeanOfBulge * around[v].volume / around[v].area / length * around[v].normal;
  });
  return aims;
}

}  // namespace nacre::app
