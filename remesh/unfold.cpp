// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include "remesh/distance_to_triangle.h"
#include "remesh/indices_where.h"
#include "remesh/patch.h"
#include "remesh/refinement.h"
#include "remesh/tips.h"

namespace nacre::remesh {
namespace {

constexpr int kRetractPasses = 6, kGiveBackPasses = 2, kUnfoldPasses = 6;
/// In mean edges: what is left behind must be no farther from the triangles than this, and they by
/// no more than this farther from the scan.
constexpr double kMostMissed = 0.01;
/// On level 1 it is retracted vertices that reach into pits. Only where those have their tips in
/// the base they may go back, and where that takes the triangles no farther from the scan.
constexpr double kMostMissedFirst = 0.03;
/// In edges: how far a new place may be from the middle of its edge.
constexpr double kMostOffEdge = 1;
/// Moves in patches: bounded, so that what is folded all over does not take longer than piercing.
constexpr std::size_t kLeastMoves = 20'000, kEdgesPerMove = 10;

/// Works on the vertices that `level` + 1 adds; the older ones stay.
class Unfolder {
 public:
  Unfolder(Refinement& mesh, int level, const PredictedLevel& prediction, double reach,
           bool gives_back)
      : mesh_(mesh),
        prediction_(prediction),
        coarse_(mesh.topology().level(level)),
        level_(level),
        gives_back_(gives_back),
        is_finest_(gives_back && level + 1 == mesh.topology().level_count()),
        reach_(reach) {}

  /// New vertices of turned triangles go to where their parents say. The parents' triangles are not
  /// turned, so their middles cannot be, but for what charts disagree about.
  void retract() {
    const auto is_turned = [&](std::size_t i) { return mesh_.is_turned(fine(i), base_face(i)); };
    auto turned = mesh_.turned_triangles(level_ + 1);
    std::vector<std::pair<std::uint32_t, Refinement::Place>> before;
    for (int pass = 0; pass < kRetractPasses && !turned.empty(); ++pass) {
      std::vector<std::uint32_t> touched;
      for (const std::uint32_t v : new_vertices_of(turned)) {
        if (mesh_.kind[v] != Refinement::kNormal) continue;
        const SurfacePoint point = expected(v);
        const Vec3 at = position_of(point, mesh_.scan().triangles, mesh_.scan().positions);
        if (!is_near_edge(at, v)) continue;
        before.emplace_back(v, mesh_.place(v));
        mesh_.store(v, point, at, Refinement::kVector);
        for_triangles_at(v, [&](std::uint32_t t) { touched.push_back(t); });
      }
      make_unique(touched);
      std::erase_if(touched, [&](std::uint32_t t) { return !is_turned(t); });
      turned = std::move(touched);
    }
    if (gives_back_ && !before.empty() && (level_ > 0 || !tips_of(mesh_.scan()).empty()))
      give_back(before);
  }

  /// New vertices of folded triangles move to whichever other place of theirs is the least bad;
  /// what is left is mended patch by patch. Returns what stays folded.
  std::vector<std::uint32_t> unfold() {
    auto folded = mesh_.folded_triangles(level_ + 1);
    for (int pass = 0; pass < kUnfoldPasses && !folded.empty(); ++pass) {
      std::vector<std::uint32_t> touched;
      for (const std::uint32_t v : new_vertices_of(folded))
        if (replace(v)) for_triangles_at(v, [&](std::uint32_t t) { touched.push_back(t); });
      if (touched.empty()) break;
      folded.insert(folded.end(), touched.begin(), touched.end());
      make_unique(folded);
      std::erase_if(folded, [&](std::uint32_t t) { return !mesh_.is_folded(fine(t)); });
    }
    if (folded.empty()) return folded;
    return PatchUnfolder(mesh_, level_ + 1, PatchUnfolder::Movable::kNewest)
        .run(std::move(folded), kLeastMoves + coarse_.edges.size() / kEdgesPerMove);
  }

 private:
  struct Place {
    SurfacePoint point;
    Vec3 at;
    Refinement::Kind kind;
  };

  [[nodiscard]] std::uint32_t base_face(std::size_t fine_triangle) const {
    return static_cast<std::uint32_t>(fine_triangle >> (2 * (level_ + 1)));
  }
  [[nodiscard]] Triangle fine(std::size_t i) const { return mesh_.triangle(level_ + 1, i); }
  [[nodiscard]] const Edge& edge_of(std::uint32_t vertex) const {
    return coarse_.edges[vertex - coarse_.vertex_count];
  }
  [[nodiscard]] SurfacePoint expected(std::uint32_t vertex) const {
    const Edge& edge = edge_of(vertex);
    return mesh_.expected_point(edge, edge.face[0] >> (2 * level_),
                                prediction_.point(vertex - coarse_.vertex_count));
  }

  [[nodiscard]] std::vector<std::uint32_t> new_vertices_of(
      std::span<const std::uint32_t> triangles) const {
    std::vector<std::uint32_t> vertices;
    for (const std::uint32_t i : triangles)
      for (const std::uint32_t v : fine(i))
        if (v >= coarse_.vertex_count && !edge_of(v).is_boundary()) vertices.push_back(v);
    make_unique(vertices);
    return vertices;
  }

  /// Calls visit(i) for each fine triangle that has the vertex.
  template <class Visit>
  void for_triangles_at(std::uint32_t vertex, const Visit& visit) const {
    for (const std::uint32_t face : edge_of(vertex).face) {
      if (face == kNone) continue;
      for (std::uint32_t child = 4 * face; child < 4 * face + 4; ++child) {
        const Triangle t = fine(child);
        if (t[0] == vertex || t[1] == vertex || t[2] == vertex) visit(child);
      }
    }
  }

  /// 0: all is well around the vertex. A fold counts 1 and more, a turned triangle 1.
  [[nodiscard]] double badness(std::uint32_t vertex) const {
    double sum = 0;
    for_triangles_at(vertex, [&](std::uint32_t i) {
      const double facing = mesh_.facing(fine(i));
      sum += facing < 0 ? 1 - facing : 0;
      sum += mesh_.is_turned(fine(i), base_face(i)) ? 1 : 0;
    });
    return sum;
  }

  /// Not all that were retracted had to be: some go back to where their detail is one number. On
  /// the finest level, whose middles nobody asks for, triangles may be turned by that.
  void give_back(const std::vector<std::pair<std::uint32_t, Refinement::Place>>& before) {
    double length = 0;
    for (const Edge& e : coarse_.edges)
      length += (mesh_.positions[e.vertex[0]] - mesh_.positions[e.vertex[1]]).norm();
    length /= 2 * static_cast<double>(coarse_.edges.size());
    const auto bad_at = [&](std::uint32_t v) { return is_finest_ ? folds_at(v) : badness(v); };
    const double most_missed = (level_ == 0 ? kMostMissedFirst : kMostMissed) * length;
    const double most_strayed = (level_ == 0 ? 0 : kMostMissed) * length;
    for (int pass = 0; pass < kGiveBackPasses; ++pass) {
      for (const auto& [v, place] : before) {
        if (mesh_.kind[v] == Refinement::kNormal) continue;
        const Refinement::Place now = mesh_.place(v);
        const double bad = bad_at(v), strayed = strayed_at(v);
        mesh_.put(v, place);
        if (bad_at(v) > bad || distance_at(v, now.at) > most_missed ||
            strayed_at(v) > strayed + most_strayed)
          mesh_.put(v, now);
      }
    }
  }

  [[nodiscard]] double folds_at(std::uint32_t vertex) const {
    double count = 0;
    for_triangles_at(vertex, [&](std::uint32_t i) { count += mesh_.is_folded(fine(i)); });
    return count;
  }

  /// How far the middle of a triangle around the vertex is from the scan, at most.
  [[nodiscard]] double strayed_at(std::uint32_t vertex) const {
    double farthest = 0;
    for_triangles_at(vertex, [&](std::uint32_t i) {
      const Triangle t = fine(i);
      const Vec3 middle =
          (mesh_.positions[t[0]] + mesh_.positions[t[1]] + mesh_.positions[t[2]]) / 3;
      const Vec3 under =
          position_of(mesh_.tree().nearest(middle), mesh_.scan().triangles, mesh_.scan().positions);
      farthest = std::max(farthest, (middle - under).norm());
    });
    return farthest;
  }

  /// From the triangles around the vertex.
  [[nodiscard]] double distance_at(std::uint32_t vertex, const Vec3& p) const {
    double nearest = std::numeric_limits<double>::infinity();
    const auto& at = mesh_.positions;
    for_triangles_at(vertex, [&](std::uint32_t i) {
      const Triangle t = fine(i);
      nearest = std::min(nearest, distance_to_triangle(p, at[t[0]], at[t[1]], at[t[2]]));
    });
    return nearest;
  }

  bool replace(std::uint32_t vertex) {
    double least = badness(vertex);
    if (least == 0) return false;
    const Place kept{mesh_.surface(vertex), mesh_.positions[vertex],
                     static_cast<Refinement::Kind>(mesh_.kind[vertex])};
    Place best = kept;
    for (const Place& place : other_places(vertex)) {
      if (!is_near_edge(place.at, vertex)) continue;
      mesh_.store(vertex, place.point, place.at, place.kind);
      const double bad = badness(vertex);
      if (bad >= least) continue;
      least = bad;
      best = place;
    }
    mesh_.store(vertex, best.point, best.at, best.kind);
    return best.at != kept.at;
  }

  /// Not on another sheet far away, from where no triangle around would ever come back.
  [[nodiscard]] bool is_near_edge(const Vec3& place, std::uint32_t vertex) const {
    const Edge& edge = edge_of(vertex);
    const Vec3 &a = mesh_.positions[edge.vertex[0]], &b = mesh_.positions[edge.vertex[1]];
    return (place - (a + b) / 2).norm() <= kMostOffEdge * (a - b).norm();
  }

  /// All hits of the line, the expected point, the scan nearest to the prediction, to the edge's
  /// middle and to the middle of the vertices around.
  [[nodiscard]] std::vector<Place> other_places(std::uint32_t vertex) const {
    const std::uint32_t e = vertex - coarse_.vertex_count;
    const Edge& edge = coarse_.edges[e];
    const Vec3& predicted = prediction_.point(e);
    const Vec3 normal = prediction_.frame(e).normal;
    const Vec3 &a = mesh_.positions[edge.vertex[0]], &b = mesh_.positions[edge.vertex[1]];
    const LineTree& tree = mesh_.tree();
    std::vector<Place> places;
    for (const LineTree::Hit& hit : tree.hits(predicted, normal, reach_ * (a - b).norm()))
      places.push_back({hit.point, predicted + hit.t * normal, Refinement::kNormal});
    for (const SurfacePoint& p : {expected(vertex), tree.nearest(predicted),
                                  tree.nearest((a + b) / 2), tree.nearest(middle_around(vertex))})
      places.push_back(
          {p, position_of(p, mesh_.scan().triangles, mesh_.scan().positions), Refinement::kVector});
    return places;
  }

  [[nodiscard]] Vec3 middle_around(std::uint32_t vertex) const {
    Vec3 sum = Vec3::Zero();
    double count = 0;
    for_triangles_at(vertex, [&](std::uint32_t i) {
      for (const std::uint32_t v : fine(i)) {
        if (v == vertex) continue;
        sum += mesh_.positions[v];
        ++count;
      }
    });
    return sum / count;
  }

  Refinement& mesh_;
  const PredictedLevel& prediction_;
  const LevelTopology& coarse_;
  int level_;
  bool gives_back_;
  bool is_finest_;  // and what lies upside down in the domain may stay so
  double reach_;
};

}  // namespace

std::vector<std::uint32_t> unfold(Refinement& mesh, int level, const PredictedLevel& prediction,
                                  double reach, bool give_back) {
  Unfolder unfolder(mesh, level, prediction, reach, give_back);
  unfolder.retract();
  return unfolder.unfold();
}

}  // namespace nacre::remesh
