// SPDX-License-Identifier: GPL-3.0-or-later
//
// What smoothing a patch cannot unfold is mended by trying places one by one, vertex by vertex. It
// weighs folds alone, and how far a vertex goes, so that what is well stays where it is.
#include <algorithm>

#include "remesh/indices_where.h"
#include "remesh/patch.h"

namespace nacre::remesh {
namespace {

using Vec2 = Eigen::Vector2d;
constexpr std::array<int, 3> kRings = {1, 2, 3};
constexpr int kStarts = 5, kSweeps = 10;
constexpr std::size_t kMostTries = 60'000;
/// A triangle below this cosine from the scan's normal counts as folded.
constexpr double kMargin = 0.02;
constexpr double kTurned = 0.5, kLeastGain = 0.4;
/// What going as far as the farthest neighbour costs, next to folds, which count one and more.
constexpr double kPerRadius = 0.2;
/// A vertex comes no nearer to a neighbour than this share of the farthest one's distance.
constexpr double kNearest = 0.05;
constexpr double kMostMissed = 0.1;  // as in patch.cpp
/// Shares of the way to each neighbour.
constexpr std::array<double, 4> kWays = {0.1, 0.3, 0.6, 0.85};
constexpr double kAway = -0.2;
/// Off the sides of the scan's triangles, whose normals differ, by so much of their size.
constexpr double kInside = 1e-3;

SurfacePoint inside(SurfacePoint p) {
  for (double& w : p.weight) w = (w + kInside) / (1 + 3 * kInside);
  return p;
}

}  // namespace

void PatchUnfolder::search(std::vector<std::uint32_t> folded) {
  tries_left_ = kMostTries;
  const auto is_well = [&](std::uint32_t t) {
    const Triangle c = mesh_.triangle(level_, t);
    return !mesh_.is_folded(c) && !mesh_.is_opposed(c);
  };
  for (const int rings : kRings) {
    std::vector<std::uint32_t> touched;
    for (const std::uint32_t t : folded) {
      if (tries_left_ == 0) return;
      if (is_well(t)) continue;
      mend_by_search(t, rings);
      touched.insert(touched.end(), triangles_.begin(), triangles_.end());
    }
    folded.insert(folded.end(), touched.begin(), touched.end());
    make_unique(folded);
    std::erase_if(folded, is_well);
  }
}

void PatchUnfolder::mend_by_search(std::uint32_t folded_triangle, int rings) {
  collect(folded_triangle, rings);
  if (vertices_.empty()) return;
  const std::vector<Refinement::Place> before = places();
  const double first = harm(triangles_);
  best_ = before;
  least_ = first;
  for (int start = 0; start < kStarts && tries_left_ > 0; ++start) {
    restore(before);
    if (start + 1 == kStarts) {
      if (!flatten()) break;
    } else {
      for (int sweep = 0; sweep < (start + 1) / 2; ++sweep)
        for (std::size_t i = 0; i < vertices_.size(); ++i)
          move(i, start % 2 == 0 ? Middle::kInSpace : Middle::kInDomain);
    }
    descend(before);
    const double bad = harm(triangles_);
    if (bad >= least_) continue;
    least_ = bad;
    best_ = places();
    if (bad == 0) break;
  }
  restore(best_);
  give_back(before, [&](std::size_t i) { return harm(around(i)); });
  if (movable_ == Movable::kAll) give_back_missed(before, kMostMissed);
  if (harm(triangles_) > first - kLeastGain) restore(before);
}

/// The patch becomes the coarser level's, off the scan where that is. False: it would be older
/// vertices that move.
bool PatchUnfolder::flatten() {
  if (level_ == 0 || movable_ == Movable::kAll) return false;
  const LevelTopology& coarse = topology_.level(level_ - 1);
  const auto& p = mesh_.positions;
  for (const std::uint32_t v : vertices_) {
    const Edge& edge = coarse.edges[v - coarse.vertex_count];
    const Vec3 middle = (p[edge.vertex[0]] + p[edge.vertex[1]]) / 2;
    Vec3 normal = Vec3::Zero();
    for (const std::uint32_t f : edge.face) {
      const Triangle& t = coarse.triangles[f];
      normal += (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).stableNormalized();
    }
    SurfacePoint best = inside(mesh_.tree().nearest(middle));
    for (const std::uint32_t end : edge.vertex)
      if (mesh_.scan_normal(mesh_.surface_face(end)).dot(normal) >
          mesh_.scan_normal(best.face).dot(normal))
        best = mesh_.surface(end);
    mesh_.store(v, best, middle, Refinement::kVector);
  }
  return true;
}

void PatchUnfolder::descend(const std::vector<Refinement::Place>& before) {
  for (int sweep = 0; sweep < kSweeps && tries_left_ > 0; ++sweep) {
    bool any = false;
    for (std::size_t i = 0; i < vertices_.size(); ++i) any |= improve(i, before[i].at);
    if (!any || harm(triangles_) == 0) return;
  }
}

double PatchUnfolder::harm(std::span<const std::uint32_t> triangles) const {
  double sum = 0;
  for (const std::uint32_t t : triangles) {
    const Triangle triangle = mesh_.triangle(level_, t);
    const double facing = mesh_.facing(triangle);
    if (facing < kMargin || mesh_.is_suspect(triangle, facing)) sum += 1 + kMargin - facing;
    if (level_ == topology_.level_count()) continue;  // no finer level asks for the domain
    const auto area = mesh_.domain_area(triangle, t >> (2 * level_));
    if (!area || *area <= 0) sum += kTurned;
  }
  return sum;
}

bool PatchUnfolder::improve(std::size_t i, const Vec3& before) {
  const std::uint32_t v = vertices_[i];
  const double bad = harm(around(i));
  if (bad == 0) return false;
  const Refinement::Place kept = mesh_.place(v);
  Refinement::Place best = kept;
  const Vec3 middle = middle_of_ring(i);
  const double radius = radius_around(i, middle);
  const auto way = [&] { return kPerRadius * (mesh_.positions[v] - before).norm() / radius; };
  double least = bad + way();
  collect_places(i, middle);
  tries_left_ -= std::min(tries_left_, places_.size());
  for (const SurfacePoint& point : places_) {
    move_to(v, inside(point), middle, radius);
    double nearest = radius;
    for (const std::uint32_t w : ring(i))
      nearest = std::min(nearest, (mesh_.positions[v] - mesh_.positions[w]).norm());
    if (nearest < kNearest * radius) continue;
    const double now = harm(around(i)) + way();
    if (now >= least - 1e-6) continue;
    least = now;
    best = mesh_.place(v);
  }
  mesh_.put(v, best);
  return best.at != kept.at;
}

/// On the way from where the vertex is, and from the middle of its neighbours, to each of these: in
/// space, and in the domain, which tells sheets apart that are close.
void PatchUnfolder::collect_places(std::size_t i, const Vec3& middle) {
  const std::uint32_t v = vertices_[i];
  const Vec3 at = mesh_.positions[v];
  const LineTree& tree = mesh_.tree();
  places_.assign(1, tree.nearest(middle));
  faces_.assign(1, mesh_.domain(v).face);
  for (const std::uint32_t w : ring(i)) {
    const Vec3& p = mesh_.positions[w];
    for (const double way : kWays) {
      places_.push_back(tree.nearest(at + way * (p - at)));
      places_.push_back(tree.nearest(middle + way * (p - middle)));
    }
    places_.push_back(tree.nearest(at + kAway * (p - at)));
    faces_.push_back(mesh_.domain(w).face);
  }
  const auto chart = mesh_.map().atlas().common_chart(faces_);
  if (!chart) return;
  const auto add = [&](const Vec2& p) {
    places_.push_back(mesh_.map().to_surface(chart->unmap(p), mesh_.surface_face(v)));
  };
  const Vec2 here = *chart->map(mesh_.domain(v));
  Vec2 centre = Vec2::Zero();
  for (const std::uint32_t w : ring(i)) centre += *chart->map(mesh_.domain(w));
  centre /= static_cast<double>(ring(i).size());
  add(centre);
  for (const std::uint32_t w : ring(i)) {
    const Vec2 p = *chart->map(mesh_.domain(w));
    for (const double way : kWays) {
      add(here + way * (p - here));
      add(centre + way * (p - centre));
    }
  }
}

}  // namespace nacre::remesh
