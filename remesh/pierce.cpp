// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/pierce.h"

#include "base/parallel.h"
#include "remesh/adjacency.h"
#include "remesh/boundary_curves.h"
#include "remesh/refinement.h"

namespace nacre::remesh {
namespace {

class Piercer {
 public:
  Piercer(const SurfaceMap& map, const Parameterisation& parameterisation, const LineTree& tree,
          const PierceOptions& options, const Topology& topology)
      : mesh_(map, parameterisation.base, tree, topology),
        options_(options),
        curves_(map, parameterisation) {
    place_base();
  }

  void refine(int level, const LevelPrediction& prediction) {
    const std::size_t old = mesh_.positions.size();
    const std::size_t count = mesh_.topology().level(level).edges.size();
    mesh_.resize(old + count);
    parallel_for_each_index(
        count, [&](std::size_t e) { place(level, e, old + e, prediction); }, 64);
    unfold(mesh_, level, prediction, options_.reach);
  }

  /// What the level above `level` has become; its folds are added to those of its base triangles.
  [[nodiscard]] BandReport report(int level, std::vector<std::uint32_t>& folds) const {
    const LevelTopology& fine = mesh_.topology().level(level + 1);
    BandReport band;
    const std::uint32_t first = mesh_.topology().level(level).vertex_count;
    band.vertices = fine.vertex_count - first;
    for (std::uint32_t v = first; v < fine.vertex_count; ++v)
      band.normal_only += mesh_.kind[v] == Refinement::kNormal;
    for (std::size_t t = 0; t < fine.triangles.size(); ++t) {
      if (!mesh_.is_folded(fine.triangles[t])) continue;
      ++band.folded_triangles;
      ++folds[t >> (2 * (level + 1))];
    }
    return band;
  }

  [[nodiscard]] const std::vector<Vec3>& positions() const { return mesh_.positions; }
  std::vector<Vec3> take_positions() { return std::move(mesh_.positions); }
  std::vector<std::uint8_t> take_kinds() { return std::move(mesh_.kind); }

 private:
  /// Base corners keep their place in the domain; the scan has slid under them. Those on the
  /// boundary stay at their scan vertex.
  void place_base() {
    const BaseMesh& base = mesh_.base();
    const Scan& scan = mesh_.scan();
    const std::size_t n = base.scan_vertex.size();
    mesh_.resize(n);
    std::vector<char> boundary(n, 0);
    for (std::uint32_t f = 0; f < base.triangles.size(); ++f) {
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t v = base.triangles[f][k];
        mesh_.domain[v] = {f, {}};
        mesh_.domain[v].weight[k] = 1;
        if (base.neighbors[f][k] == kNone)
          boundary[v] = boundary[base.triangles[f][(k + 1) % 3]] = 1;
      }
    }
    for (std::uint32_t v = 0; v < n; ++v) {
      const std::uint32_t start = mesh_.map().start_triangle(v);
      SurfacePoint& point = mesh_.surface[v];
      if (boundary[v]) {
        point = {start, {}};
        point.weight[corner_of(scan.triangles[start], base.scan_vertex[v])] = 1;
      } else if (!base.moved.empty() && base.moved[v].face != kNone) {
        point = base.moved[v];
      } else {
        point = mesh_.map().to_surface(mesh_.domain[v], start);
      }
      mesh_.positions[v] = position_of(point, scan.triangles, scan.positions);
    }
  }

  void place(int level, std::size_t e, std::size_t vertex, const LevelPrediction& prediction) {
    const Edge& edge = mesh_.topology().level(level).edges[e];
    const std::uint32_t base_face = edge.face[0] >> (2 * level);
    if (edge.is_boundary() && place_on_boundary(edge, base_face, vertex, prediction.points[e],
                                                prediction.frames[e].tangent2))
      return;

    const Vec3& predicted = prediction.points[e];
    const Vec3& normal = prediction.frames[e].normal;
    const double length =
        (mesh_.positions[edge.vertex[0]] - mesh_.positions[edge.vertex[1]]).norm();
    const SurfacePoint expected = mesh_.expected_point(edge, base_face, predicted);
    const Vec3 expected_at = position_of(expected, mesh_.scan().triangles, mesh_.scan().positions);
    const double aperture = (level == 0 ? options_.first_aperture : options_.aperture) * length;
    for (const LineTree::Hit& hit : mesh_.tree().hits(predicted, normal, options_.reach * length)) {
      if (mesh_.scan_normal(hit.point.face).dot(normal) < options_.least_facing) continue;
      const Vec3 at = predicted + hit.t * normal;
      if ((at - expected_at).norm() > aperture) continue;
      mesh_.store(vertex, hit.point, at, Refinement::kNormal);
      return;
    }
    mesh_.store(vertex, expected, expected_at, Refinement::kVector);
  }

  /// False if the edge's ends are not both on the curve of one base boundary edge.
  bool place_on_boundary(const Edge& edge, std::uint32_t base_face, std::size_t vertex,
                         const Vec3& predicted, const Vec3& along) {
    const DomainPoint a = mesh_.seen_from(edge.vertex[0], base_face);
    const DomainPoint b = mesh_.seen_from(edge.vertex[1], base_face);
    if (a.face != base_face || b.face != base_face) return false;
    for (std::uint32_t side = 0; side < 3; ++side) {
      const std::uint32_t apex = (side + 2) % 3, next = (side + 1) % 3;
      if (mesh_.base().neighbors[base_face][side] != kNone || a.weight[apex] != 0 ||
          b.weight[apex] != 0)
        continue;
      const auto hit =
          curves_.pierce(base_face, side, a.weight[next], b.weight[next], predicted, along);
      mesh_.store(vertex, hit.point, Refinement::kBoundary);
      // Exactly on the side, whatever the chart of the scan's triangle makes of it.
      mesh_.domain[vertex] = {base_face, {}};
      mesh_.domain[vertex].weight[side] = 1 - hit.parameter;
      mesh_.domain[vertex].weight[next] = hit.parameter;
      return true;
    }
    return false;
  }

  Refinement mesh_;
  const PierceOptions& options_;
  BoundaryCurves curves_;
};

}  // namespace

Result<Pierced> pierce(const SurfaceMap& map, const Parameterisation& parameterisation,
                       const LineTree& tree, const LevelPredictor& predict,
                       const PierceOptions& options, const RunContext& context) {
  const BaseMesh& base = parameterisation.base;
  const auto base_vertices = static_cast<std::uint32_t>(base.scan_vertex.size());
  const auto topology = Topology::build(base.triangles, base_vertices, options.levels);
  if (!topology) return topology.error();
  Piercer piercer(map, parameterisation, tree, options, *topology);
  Pierced out;
  out.folds.assign(base.triangles.size(), 0);
  for (int level = 0; level < options.levels; ++level) {
    if (context.cancelled()) return Error{ErrorCode::kCancelled, "interrupted", 0};
    piercer.refine(level, predict(*topology, level, piercer.positions()));
    out.bands.push_back(piercer.report(level, out.folds));
    context.report("piercing", (level + 1.0) / options.levels);
  }
  out.mesh.base_triangles = base.triangles;
  out.mesh.base_vertex_count = base_vertices;
  out.mesh.level_count = options.levels;
  out.mesh.positions = piercer.take_positions();
  out.mesh.origin = map.scan().origin;
  out.kind = piercer.take_kinds();
  return out;
}

}  // namespace nacre::remesh
