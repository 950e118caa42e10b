// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/pierce.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/parallel.h"
#include "remesh/adjacency.h"
#include "remesh/boundary_curves.h"

namespace nacre::remesh {
namespace {

enum Kind : std::uint8_t { kNormal = 0, kBoundary = 1, kVector = 2 };
constexpr int kUnfoldPasses = 3;

class Piercer {
 public:
  Piercer(const SurfaceMap& map, const Parameterisation& parameterisation, const LineTree& tree,
          const PierceOptions& options, const Topology& topology)
      : map_(map),
        scan_(map.scan()),
        base_(parameterisation.base),
        tree_(tree),
        options_(options),
        topology_(topology),
        curves_(map, parameterisation) {
    place_base();
  }

  void refine(int level, const LevelPrediction& prediction) {
    const LevelTopology& coarse = topology_.level(level);
    const std::size_t old = positions_.size(), count = coarse.edges.size();
    positions_.resize(old + count);
    surface_.resize(old + count);
    domain_.resize(old + count);
    kind_.resize(old + count);
    parallel_for_each_index(
        count, [&](std::size_t e) { place(level, e, old + e, prediction); }, 64);
    for (int pass = 0; pass < kUnfoldPasses; ++pass)
      if (!unfold(level, prediction)) break;
  }

  [[nodiscard]] BandReport report(int level) const {
    const LevelTopology& fine = topology_.level(level + 1);
    BandReport band;
    const std::uint32_t first = topology_.level(level).vertex_count;
    band.vertices = fine.vertex_count - first;
    for (std::uint32_t v = first; v < fine.vertex_count; ++v)
      band.normal_only += kind_[v] == kNormal;
    for (const Triangle& t : fine.triangles) band.folded_triangles += is_folded(t);
    return band;
  }

  void count_folds(int level, std::vector<std::uint32_t>& per_base_triangle) const {
    const LevelTopology& fine = topology_.level(level + 1);
    for (std::size_t t = 0; t < fine.triangles.size(); ++t)
      per_base_triangle[t >> (2 * (level + 1))] += is_folded(fine.triangles[t]);
  }

  [[nodiscard]] const std::vector<Vec3>& positions() const { return positions_; }
  std::vector<Vec3> take_positions() { return std::move(positions_); }
  std::vector<std::uint8_t> take_kinds() { return std::move(kind_); }

 private:
  [[nodiscard]] Vec3 scan_normal(std::uint32_t face) const {
    const Triangle& t = scan_.triangles[face];
    return (scan_.positions[t[1]] - scan_.positions[t[0]])
        .cross(scan_.positions[t[2]] - scan_.positions[t[0]])
        .stableNormalized();
  }

  [[nodiscard]] bool is_folded(const Triangle& t) const {
    const Vec3 n = (positions_[t[1]] - positions_[t[0]]).cross(positions_[t[2]] - positions_[t[0]]);
    const Vec3 under = scan_normal(surface_[t[0]].face) + scan_normal(surface_[t[1]].face) +
                       scan_normal(surface_[t[2]].face);
    return n.dot(under) < 0;
  }

  /// Base corners keep their place in the domain; the scan has slid under them. Those on the
  /// boundary stay at their scan vertex.
  void place_base() {
    const std::size_t n = base_.scan_vertex.size();
    positions_.resize(n);
    surface_.resize(n);
    domain_.resize(n);
    kind_.assign(n, kNormal);
    std::vector<char> boundary(n, 0);
    for (std::uint32_t f = 0; f < base_.triangles.size(); ++f) {
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t v = base_.triangles[f][k];
        domain_[v] = {f, {}};
        domain_[v].weight[k] = 1;
        if (base_.neighbors[f][k] == kNone)
          boundary[v] = boundary[base_.triangles[f][(k + 1) % 3]] = 1;
      }
    }
    for (std::uint32_t v = 0; v < n; ++v) {
      const std::uint32_t start = map_.start_triangle(v);
      if (boundary[v]) {
        surface_[v] = {start, {}};
        surface_[v].weight[corner_of(scan_.triangles[start], base_.scan_vertex[v])] = 1;
      } else {
        surface_[v] = map_.to_surface(domain_[v], start);
      }
      positions_[v] = position_of(surface_[v], scan_.triangles, scan_.positions);
    }
  }

  /// A base corner belongs to every triangle around it: seen from the one that is asked for.
  [[nodiscard]] DomainPoint seen_from(std::uint32_t vertex, std::uint32_t face) const {
    const DomainPoint& p = domain_[vertex];
    if (vertex >= base_.scan_vertex.size()) return p;
    DomainPoint corner{face, {}};
    const std::uint32_t k = corner_of(base_.triangles[face], vertex);
    if (base_.triangles[face][k] != vertex) return p;
    corner.weight[k] = 1;
    return corner;
  }

  void place(int level, std::size_t e, std::size_t vertex, const LevelPrediction& prediction) {
    const Edge& edge = topology_.level(level).edges[e];
    const std::uint32_t base_face = edge.face[0] >> (2 * level);
    if (edge.is_boundary() && place_on_boundary(edge, base_face, vertex, prediction.points[e],
                                                prediction.frames[e].tangent2))
      return;

    const Vec3& predicted = prediction.points[e];
    const Vec3& normal = prediction.frames[e].normal;
    const double length = (positions_[edge.vertex[0]] - positions_[edge.vertex[1]]).norm();
    const SurfacePoint expected = expected_point(edge, base_face, predicted);
    const Vec3 expected_at = position_of(expected, scan_.triangles, scan_.positions);
    const double aperture = (level == 0 ? options_.first_aperture : options_.aperture) * length;
    for (const LineTree::Hit& hit : tree_.hits(predicted, normal, options_.reach * length)) {
      if (scan_normal(hit.point.face).dot(normal) < options_.least_facing) continue;
      const Vec3 at = predicted + hit.t * normal;
      if ((at - expected_at).norm() > aperture) continue;
      store(vertex, hit.point, at, kNormal);
      return;
    }
    store(vertex, expected, expected_at, kVector);
  }

  struct Place {
    SurfacePoint point;
    Vec3 at;
    Kind kind;
  };

  /// Triangles of the level being made that are folded and have `vertex`, the midpoint of `edge`.
  [[nodiscard]] int folds_around(const LevelTopology& fine, const Edge& edge,
                                 std::uint32_t vertex) const {
    int folds = 0;
    for (const std::uint32_t face : edge.face) {
      if (face == kNone) continue;
      for (std::uint32_t child = 4 * face; child < 4 * face + 4; ++child) {
        const Triangle& t = fine.triangles[child];
        if (t[0] == vertex || t[1] == vertex || t[2] == vertex) folds += is_folded(t);
      }
    }
    return folds;
  }

  /// Moves new vertices of folded triangles to whichever other place of theirs folds least: further
  /// hits, the expected point, the scan nearest to the edge's middle. True if any moved.
  bool unfold(int level, const LevelPrediction& prediction) {
    const LevelTopology& coarse = topology_.level(level);
    const LevelTopology& fine = topology_.level(level + 1);
    std::vector<std::uint32_t> suspects;
    for (const Triangle& t : fine.triangles) {
      if (!is_folded(t)) continue;
      for (const std::uint32_t v : t)
        if (v >= coarse.vertex_count) suspects.push_back(v);
    }
    std::sort(suspects.begin(), suspects.end());
    suspects.erase(std::unique(suspects.begin(), suspects.end()), suspects.end());
    bool any = false;
    for (const std::uint32_t v : suspects) any |= replace(level, v, prediction);
    return any;
  }

  bool replace(int level, std::uint32_t vertex, const LevelPrediction& prediction) {
    const LevelTopology& coarse = topology_.level(level);
    const LevelTopology& fine = topology_.level(level + 1);
    const std::uint32_t e = vertex - coarse.vertex_count;
    const Edge& edge = coarse.edges[e];
    if (edge.is_boundary()) return false;
    int fewest = folds_around(fine, edge, vertex);
    if (fewest == 0) return false;
    const Place kept{surface_[vertex], positions_[vertex], static_cast<Kind>(kind_[vertex])};
    Place best = kept;
    for (const Place& place :
         other_places(level, edge, prediction.points[e], prediction.frames[e].normal)) {
      surface_[vertex] = place.point;
      positions_[vertex] = place.at;
      const int folds = folds_around(fine, edge, vertex);
      if (folds >= fewest) continue;
      fewest = folds;
      best = place;
    }
    store(vertex, best.point, best.at, best.kind);
    return best.at != kept.at;
  }

  [[nodiscard]] std::vector<Place> other_places(int level, const Edge& edge, const Vec3& predicted,
                                                const Vec3& normal) const {
    std::vector<Place> places;
    const Vec3 middle = (positions_[edge.vertex[0]] + positions_[edge.vertex[1]]) / 2;
    const double length = (positions_[edge.vertex[0]] - positions_[edge.vertex[1]]).norm();
    for (const LineTree::Hit& hit : tree_.hits(predicted, normal, options_.reach * length))
      places.push_back({hit.point, predicted + hit.t * normal, kNormal});
    for (const SurfacePoint& p : {expected_point(edge, edge.face[0] >> (2 * level), predicted),
                                  tree_.nearest(predicted), tree_.nearest(middle)})
      places.push_back({p, position_of(p, scan_.triangles, scan_.positions), kVector});
    return places;
  }

  void store(std::size_t vertex, const SurfacePoint& point, const Vec3& at, Kind kind) {
    surface_[vertex] = point;
    domain_[vertex] = map_.to_domain(point);
    positions_[vertex] = at;
    kind_[vertex] = kind;
  }

  /// The scan's point at the middle, in the domain, of the edge's two ends as they really are.
  [[nodiscard]] SurfacePoint expected_point(const Edge& edge, std::uint32_t base_face,
                                            const Vec3& predicted) const {
    const DomainPoint a = seen_from(edge.vertex[0], base_face);
    const DomainPoint b = seen_from(edge.vertex[1], base_face);
    const std::array<std::uint32_t, 2> faces = {a.face, b.face};
    const auto chart = map_.atlas().common_chart(faces);
    if (!chart) return tree_.nearest(predicted);
    const DomainPoint middle = chart->unmap((*chart->map(a) + *chart->map(b)) / 2);
    return map_.to_surface(middle, surface_[edge.vertex[0]].face);
  }

  /// False if the edge's ends are not both on the curve of one base boundary edge.
  bool place_on_boundary(const Edge& edge, std::uint32_t base_face, std::size_t vertex,
                         const Vec3& predicted, const Vec3& along) {
    const DomainPoint a = seen_from(edge.vertex[0], base_face);
    const DomainPoint b = seen_from(edge.vertex[1], base_face);
    if (a.face != base_face || b.face != base_face) return false;
    for (std::uint32_t side = 0; side < 3; ++side) {
      const std::uint32_t apex = (side + 2) % 3, next = (side + 1) % 3;
      if (base_.neighbors[base_face][side] != kNone || a.weight[apex] != 0 || b.weight[apex] != 0)
        continue;
      const auto hit =
          curves_.pierce(base_face, side, a.weight[next], b.weight[next], predicted, along);
      surface_[vertex] = hit.point;
      positions_[vertex] = position_of(hit.point, scan_.triangles, scan_.positions);
      domain_[vertex] = {base_face, {}};
      domain_[vertex].weight[side] = 1 - hit.parameter;
      domain_[vertex].weight[next] = hit.parameter;
      kind_[vertex] = kBoundary;
      return true;
    }
    return false;
  }

  const SurfaceMap& map_;
  const Scan& scan_;
  const BaseMesh& base_;
  const LineTree& tree_;
  const PierceOptions& options_;
  const Topology& topology_;
  BoundaryCurves curves_;
  std::vector<Vec3> positions_;
  std::vector<SurfacePoint> surface_;
  std::vector<DomainPoint> domain_;
  std::vector<std::uint8_t> kind_;
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
    out.bands.push_back(piercer.report(level));
    piercer.count_folds(level, out.folds);
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
