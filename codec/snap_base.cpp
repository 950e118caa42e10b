// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/snap_base.h"

#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "wavelet/butterfly_mask.h"

namespace nacre::codec {
namespace {

/// Grid points this many steps away are looked at.
constexpr double kReach = 1.8;
/// What squared distance along the surface counts, beside that from it: far slides cost detail.
constexpr double kSlideWeight = 0.01;

std::vector<char> base_boundary(const Topology& topology) {
  std::vector<char> on_boundary(topology.level(0).vertex_count, 0);
  for (const Edge& e : topology.level(0).edges)
    if (e.is_boundary()) on_boundary[e.vertex[0]] = on_boundary[e.vertex[1]] = 1;
  return on_boundary;
}

/// The grid point that a base vertex goes to.
Vec3 best_grid_point(const Prepared& prepared, const SurfaceWeights& weights, std::uint32_t vertex,
                     double step) {
  const Vec3& p = prepared.surface()[vertex];
  constexpr int kRange = static_cast<int>(kReach) + 1;
  double least = std::numeric_limits<double>::infinity();
  Vec3 best = p;
  for (int i = -kRange; i <= kRange; ++i) {
    for (int j = -kRange; j <= kRange; ++j) {
      for (int k = -kRange; k <= kRange; ++k) {
        const Vec3 q((std::round(p[0] / step) + i) * step, (std::round(p[1] / step) + j) * step,
                     (std::round(p[2] / step) + k) * step);
        const double slide = (q - p).squaredNorm();
        if (slide > kReach * kReach * step * step) continue;
        const double loss =
            foot_on_surface(prepared, weights, q, vertex).squared_distance + kSlideWeight * slide;
        if (loss >= least) continue;
        least = loss;
        best = q;
      }
    }
  }
  return best;
}

}  // namespace

Prepared snap_base(const Prepared& prepared, const SurfaceWeights& weights, double grid_step) {
  const Topology& topology = prepared.topology;
  const std::vector<char> on_boundary = base_boundary(topology);
  const std::vector<Vec3>& surface = prepared.surface();
  Prepared out = prepared;
  out.positions = surface;
  out.aims.clear();
  std::vector<Vec3> slide(prepared.positions.size(), Vec3::Zero());
  parallel_for_each_index(on_boundary.size(), [&](std::size_t v) {
    const auto vertex = static_cast<std::uint32_t>(v);
    const Vec3& p = surface[v];
    for (int k = 0; k < 3; ++k) out.positions[v][k] = std::round(p[k] / grid_step) * grid_step;
    if (on_boundary[v]) return;
    out.positions[v] = best_grid_point(prepared, weights, vertex, grid_step);
    slide[v] = out.positions[v] - p;
  });
  const wavelet::ButterflyMask mask(topology);
  for (int j = 0; j < topology.level_count(); ++j) {
    const LevelTopology& level = topology.level(j);
    const std::size_t kept = level.vertex_count, added = level.edges.size();
    mask.predict(j, std::span<const Vec3>(slide).first(kept),
                 std::span(slide).subspan(kept, added));
    parallel_for_each_index(added, [&](std::size_t e) {
      const std::size_t v = kept + e;
      if (level.edges[e].is_boundary()) {
        slide[v] = Vec3::Zero();
        return;
      }
      const Vec3 place = surface[v] + slide[v];
      out.positions[v] =
          foot_on_surface(prepared, weights, place, static_cast<std::uint32_t>(v)).point;
    });
  }
  out.pyramid.base_positions.assign(
      out.positions.begin(),
      out.positions.begin() + static_cast<std::ptrdiff_t>(on_boundary.size()));
  out.vectors = detail_vectors(topology, out.positions);
  return out;
}

}  // namespace nacre::codec
