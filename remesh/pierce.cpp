// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/pierce.h"

#include <algorithm>
#include <utility>

#include "base/parallel.h"
#include "remesh/adjacency.h"
#include "remesh/boundary_curves.h"
#include "remesh/clean_steps.h"
#include "remesh/indices_where.h"
#include "remesh/patch.h"
#include "remesh/refinement.h"

namespace nacre::remesh {
namespace {

/// In edges: how far the expected point of a fine level may be from the middle of its edge.
constexpr double kMostOffEdge = 4;
constexpr int kRounds = 3;
constexpr std::size_t kMovesOfOlder = 20'000;
/// With more folds than these a level is not worth the time.
constexpr std::size_t kMostFolded = 20, kEdgesPerFolded = 1000;
/// Farther from its line than this share of its coordinates, a vertex is off it.
constexpr double kOffLine = 1e-12;

class Piercer {
 public:
  Piercer(const SurfaceMap& map, const Parameterisation& parameterisation, const LineTree& tree,
          const LevelPredictor& predict, const PierceOptions& options, const Topology& topology)
      : mesh_(map, parameterisation.base, tree, topology),
        predict_(predict),
        options_(options),
        curves_(map, parameterisation) {
    Box box;
    for (const Vec3& p : map.scan().positions) box.add(p);
    near_boundary_ = options.near_boundary * box.extent();
    place_base();
  }

  void refine(int level) {
    const std::size_t old = mesh_.positions.size();
    const std::size_t count = mesh_.topology().level(level).edges.size();
    mesh_.resize(old + count);
    {
      const PredictedLevel prediction = predict_(mesh_.topology(), level, coarse(level));
      parallel_for_each_index(
          count, [&](std::size_t e) { place(level, e, old + e, prediction); }, 64);
      folded_.push_back(unfold(mesh_, level, prediction, options_.reach, options_.move_older));
    }
    if (!options_.move_older) return;
    for (int round = 0; round < kRounds; ++round)
      if (!has_few_folds(level) || !move_older(level, How::kSmoothing)) break;
    search(level);
    if (has_few_folds(level)) move_older(level, How::kSearching);
  }

  /// What the level above `level` has become; its folds are added to those of its base triangles.
  [[nodiscard]] BandReport report(int level, std::vector<std::uint32_t>& folds) const {
    const LevelTopology& fine = mesh_.topology().level(level + 1);
    const std::vector<std::uint32_t>& folded = folded_[static_cast<std::size_t>(level)];
    BandReport band;
    const std::uint32_t first = mesh_.topology().level(level).vertex_count;
    band.vertices = fine.vertex_count - first;
    for (std::uint32_t v = first; v < fine.vertex_count; ++v)
      band.normal_only += Refinement::is_normal(mesh_.kind[v]);
    // All that may seem folded has been mended as well as could be; what is told is.
    for (const std::uint32_t t : folded) {
      const Triangle triangle = mesh_.triangle(level + 1, t);
      if (mesh_.has_tips() && !mesh_.is_folded(triangle) &&
          !mesh_.is_opposed(triangle, Refinement::Ties::kAll))
        continue;
      ++band.folded_triangles;
      ++folds[t >> (2 * (level + 1))];
    }
    return band;
  }

  std::vector<Vec3> take_positions() { return std::move(mesh_.positions); }
  std::vector<std::uint8_t> take_kinds() {
    std::replace(mesh_.kind.begin(), mesh_.kind.end(),
                 static_cast<std::uint8_t>(Refinement::kNearBoundary),
                 static_cast<std::uint8_t>(Refinement::kNormal));
    return std::move(mesh_.kind);
  }

 private:
  enum class How : std::uint8_t { kSmoothing, kSearching };

  [[nodiscard]] std::span<const Vec3> coarse(int level) const {
    return std::span(mesh_.positions).first(mesh_.topology().level(level).vertex_count);
  }

  /// Some, but not too many for one by one.
  [[nodiscard]] bool has_few_folds(int level) const {
    return !folded_[static_cast<std::size_t>(level)].empty() && !has_many_folds(level);
  }
  [[nodiscard]] bool has_many_folds(int level) const {
    return folded_[static_cast<std::size_t>(level)].size() >
           kMostFolded + mesh_.topology().level(level).edges.size() / kEdgesPerFolded;
  }

  /// Mends what is folded on level + 1, or seems so from outside, by trying places for its newest
  /// vertices.
  void search(int level) {
    auto& folded = folded_[static_cast<std::size_t>(level)];
    if (has_many_folds(level)) return;
    folded = mesh_.opposed_triangles(level + 1);
    for (int round = 0; round < kRounds && has_few_folds(level); ++round) {
      const std::size_t before = folded.size();
      PatchUnfolder(mesh_, level + 1, PatchUnfolder::Movable::kNewest).search(std::move(folded));
      folded = mesh_.opposed_triangles(level + 1);
      if (folded.size() >= before) break;
    }
  }

  /// Mends what is folded on level + 1 by moving vertices of the levels below as well: all that is
  /// predicted from these is placed anew. False, and all is as it was, if that leaves no fewer
  /// folds.
  bool move_older(int level, How how) {
    Refinement::Journal journal;
    const auto before = folded_;
    mesh_.journal = &journal;
    PatchUnfolder unfolder(mesh_, level + 1, PatchUnfolder::Movable::kAll);
    if (how == How::kSearching) {
      unfolder.search(std::move(folded_.back()));
      folded_.back() = mesh_.opposed_triangles(level + 1);
    } else {
      folded_.back() =
          unfolder.run(std::move(folded_.back()),
                       kMovesOfOlder + mesh_.topology().level(level).edges.size() / 10);
    }
    const int first = first_band_after(journal);
    for (int band = first; band <= level; ++band) {
      place_again(band);
      if (band < level || how == How::kSearching) search(band);
    }
    mesh_.journal = nullptr;
    const auto sum = [](const std::vector<std::vector<std::uint32_t>>& folded) {
      std::size_t count = 0;
      for (const auto& of_level : folded) count += of_level.size();
      return count;
    };
    if (sum(folded_) < sum(before)) return true;
    for (const auto& [vertex, earlier] : journal) mesh_.put(vertex, earlier.place);
    folded_ = before;
    return false;
  }

  /// The coarsest band that is predicted from a vertex which has moved.
  [[nodiscard]] int first_band_after(const Refinement::Journal& journal) const {
    std::uint32_t oldest = kNone;
    for (const auto& [vertex, earlier] : journal)
      if (earlier.has_strayed || mesh_.positions[vertex] != earlier.place.at)
        oldest = std::min(oldest, vertex);
    int band = 0;
    while (band < mesh_.topology().level_count() &&
           oldest >= mesh_.topology().level(band).vertex_count)
      ++band;
    return band;
  }

  /// Places those normal vertices anew that are off the line along which they are predicted now.
  void place_again(int band) {
    const PredictedLevel prediction = predict_(mesh_.topology(), band, coarse(band));
    const std::uint32_t first = mesh_.topology().level(band).vertex_count;
    const auto off = indices_where(prediction.size(), [&](std::size_t e) {
      if (!Refinement::is_normal(mesh_.kind[first + e])) return false;
      const Vec3 offset = mesh_.positions[first + e] - prediction.point(e);
      const Vec3 normal = prediction.frame(e).normal;
      const double length = kOffLine * (offset.norm() + prediction.point(e).norm());
      return (offset - normal.dot(offset) * normal).norm() > length;
    });
    for (const std::uint32_t e : off) place(band, e, first + e, prediction);
    folded_[static_cast<std::size_t>(band)] =
        unfold(mesh_, band, prediction, options_.reach, options_.move_older);
  }

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
        DomainPoint corner{f, {}};
        corner.weight[k] = 1;
        mesh_.set_domain(v, corner);
        if (base.neighbors[f][k] == kNone)
          boundary[v] = boundary[base.triangles[f][(k + 1) % 3]] = 1;
      }
    }
    for (std::uint32_t v = 0; v < n; ++v) {
      const std::uint32_t start = mesh_.map().start_triangle(v);
      SurfacePoint point;
      if (boundary[v]) {
        point = {start, {}};
        point.weight[corner_of(scan.triangles[start], base.scan_vertex[v])] = 1;
      } else if (!base.moved.empty() && base.moved[v].face != kNone) {
        point = base.moved[v];
      } else {
        point = mesh_.map().to_surface(mesh_.domain(v), start);
      }
      const DomainPoint corner = mesh_.domain(v);
      mesh_.put(v, {point, corner, position_of(point, scan.triangles, scan.positions),
                    Refinement::kNormal});
    }
    PatchUnfolder(mesh_, 0, PatchUnfolder::Movable::kAll)
        .run(mesh_.folded_triangles(0), kMovesOfOlder);
    std::fill(mesh_.kind.begin(), mesh_.kind.end(), Refinement::kNormal);
  }

  void place(int level, std::size_t e, std::size_t vertex, const PredictedLevel& prediction) {
    const Edge& edge = mesh_.topology().level(level).edges[e];
    const std::uint32_t base_face = edge.face[0] >> (2 * level);
    const Vec3& predicted = prediction.point(e);
    const Frame frame = prediction.frame(e);
    if (edge.is_boundary() && place_on_boundary(edge, base_face, vertex, predicted, frame)) return;

    const Vec3& normal = frame.normal;
    const Vec3 &a = mesh_.positions[edge.vertex[0]], &b = mesh_.positions[edge.vertex[1]];
    const double length = (a - b).norm();
    const auto at_of = [&](const SurfacePoint& p) {
      return position_of(p, mesh_.scan().triangles, mesh_.scan().positions);
    };
    SurfacePoint expected = mesh_.expected_point(edge, base_face, predicted);
    // Where the map is torn, its middle may be anywhere.
    if (level > 0 && (at_of(expected) - (a + b) / 2).norm() > kMostOffEdge * length)
      expected = mesh_.tree().nearest(predicted);
    const Vec3 expected_at = at_of(expected);
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
                         const Vec3& predicted, const Frame& frame) {
    const DomainPoint a = mesh_.seen_from(edge.vertex[0], base_face);
    const DomainPoint b = mesh_.seen_from(edge.vertex[1], base_face);
    if (a.face != base_face || b.face != base_face) return false;
    for (std::uint32_t side = 0; side < 3; ++side) {
      const std::uint32_t apex = (side + 2) % 3, next = (side + 1) % 3;
      if (mesh_.base().neighbors[base_face][side] != kNone || a.weight[apex] != 0 ||
          b.weight[apex] != 0)
        continue;
      const auto hit = curves_.pierce(base_face, side, a.weight[next], b.weight[next], predicted,
                                      frame.tangent2);
      // Exactly on the side, whatever the chart of the scan's triangle makes of it.
      DomainPoint domain{base_face, {}};
      domain.weight[side] = 1 - hit.parameter;
      domain.weight[next] = hit.parameter;
      const Vec3 at = position_of(hit.point, mesh_.scan().triangles, mesh_.scan().positions);
      const Vec3 on_line = predicted + frame.normal.dot(at - predicted) * frame.normal;
      const bool is_near = (at - on_line).norm() < near_boundary_;
      mesh_.put(vertex, {hit.point, domain, is_near ? on_line : at,
                         is_near ? Refinement::kNearBoundary : Refinement::kBoundary});
      return true;
    }
    return false;
  }

  Refinement mesh_;
  const LevelPredictor& predict_;
  const PierceOptions& options_;
  BoundaryCurves curves_;
  double near_boundary_ = 0;                        ///< a distance
  std::vector<std::vector<std::uint32_t>> folded_;  ///< triangles of each level that was added
};

}  // namespace

Result<Pierced> pierce(const SurfaceMap& map, const Parameterisation& parameterisation,
                       const LineTree& tree, const LevelPredictor& predict,
                       const PierceOptions& options, const RunContext& context) {
  const BaseMesh& base = parameterisation.base;
  const auto base_vertices = static_cast<std::uint32_t>(base.scan_vertex.size());
  const auto topology = Topology::build_for_decoding(base.triangles, base_vertices, options.levels);
  if (!topology) return topology.error();
  Piercer piercer(map, parameterisation, tree, predict, options, *topology);
  Pierced out;
  out.folds.assign(base.triangles.size(), 0);
  for (int level = 0; level < options.levels; ++level) {
    if (context.cancelled()) return Error{ErrorCode::kCancelled, "interrupted", 0};
    piercer.refine(level);
    context.report("piercing", (level + 1.0) / options.levels);
  }
  for (int level = 0; level < options.levels; ++level)
    out.bands.push_back(piercer.report(level, out.folds));
  out.mesh.base_triangles = base.triangles;
  out.mesh.base_vertex_count = base_vertices;
  out.mesh.level_count = options.levels;
  out.mesh.positions = piercer.take_positions();
  out.mesh.origin = map.scan().origin;
  out.kind = piercer.take_kinds();
  return out;
}

}  // namespace nacre::remesh
