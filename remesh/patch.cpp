// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/patch.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "remesh/adjacency.h"
#include "remesh/distance_to_triangle.h"
#include "remesh/indices_where.h"

namespace nacre::remesh {
namespace {

using Vec2 = Eigen::Vector2d;
/// Rings around a folded triangle that may move, attempt by attempt.
constexpr std::array<int, 4> kRings = {1, 2, 3, 5};
constexpr int kSweeps = 10;
/// Triangles at more than this cosine from the scan's normal are good; below it they are worse by
/// so much: next to folds, which count one and more.
constexpr double kGood = 0.3, kPerCosine = 0.1;
constexpr double kTurned = 0.5, kTorn = 4, kLeastGain = 0.4;
/// In edges: an older vertex may leave behind what lies no farther from the new triangles.
constexpr double kMostMissed = 0.25;

}  // namespace

const std::array<PatchUnfolder::Attempt, 3> PatchUnfolder::kAttempts = {
    {{false, Middle::kInSpace}, {false, Middle::kInDomain}, {true, Middle::kInSpace}}};

std::vector<std::uint32_t> PatchUnfolder::run(std::vector<std::uint32_t> folded,
                                              std::size_t most_moves) {
  moves_left_ = most_moves;
  const auto is_well = [&](std::uint32_t t) { return !mesh_.is_folded(mesh_.triangle(level_, t)); };
  for (const int rings : kRings) {
    std::vector<std::uint32_t> touched;
    for (const std::uint32_t t : folded) {
      if (moves_left_ == 0) break;
      if (is_well(t)) continue;
      mend(t, rings);
      touched.insert(touched.end(), triangles_.begin(), triangles_.end());
    }
    folded.insert(folded.end(), touched.begin(), touched.end());
    make_unique(folded);
    std::erase_if(folded, is_well);
  }
  return folded;
}

void PatchUnfolder::mend(std::uint32_t folded_triangle, int rings) {
  collect(folded_triangle, rings);
  if (vertices_.empty()) return;
  const std::vector<Refinement::Place> before = places();
  best_ = before;
  least_ = badness(triangles_);
  const double first = least_;
  for (const Attempt& attempt : kAttempts) {
    restore(before);
    if (attempt.from_edges) go_to_edges();
    smooth(attempt.middle);
    if (least_ < kPerCosine * kGood) break;
  }
  restore(best_);
  give_back(before, [&](std::size_t i) { return badness(around(i)); });
  if (movable_ == Movable::kAll) give_back_missed(before, kMostMissed);
  if (badness(triangles_) > first - kLeastGain) restore(before);
}

/// The triangles around a vertex, one of which is given. False: it may not move.
bool PatchUnfolder::collect_around(std::uint32_t vertex, std::uint32_t triangle,
                                   std::vector<std::uint32_t>& triangles) {
  const std::uint32_t older = level_ > 0 ? topology_.level(level_ - 1).vertex_count : 0;
  const LevelTopology& coarse = topology_.level(std::max(level_ - 1, 0));
  if (level_ > 0 && vertex >= older) {
    const Edge& edge = coarse.edges[vertex - older];
    if (edge.is_boundary()) return false;
    for (const std::uint32_t face : edge.face) {
      for (std::uint32_t child = 4 * face; child < 4 * face + 4; ++child) {
        const Triangle t = mesh_.triangle(level_, child);
        if (t[0] == vertex || t[1] == vertex || t[2] == vertex) triangles.push_back(child);
      }
    }
    return true;
  }
  if (level_ > 0 && movable_ == Movable::kNewest) return false;
  if (level_ > 0 && vertex < topology_.level(0).vertex_count) return false;
  // An older vertex has one triangle in each of its triangles a level down.
  const std::size_t begin = triangles.size();
  const std::uint32_t first = level_ > 0 ? triangle / 4 : triangle;
  for (std::uint32_t face = first;;) {
    const std::uint32_t corner = corner_of(coarse.triangles[face], vertex);
    triangles.push_back(level_ > 0 ? 4 * face + corner : face);
    const Edge& edge = coarse.edges[coarse.triangle_edges[face][corner]];
    face = edge.face[0] == face ? edge.face[1] : edge.face[0];
    if (face == first) return true;
    if (face == kNone) break;
  }
  triangles.resize(begin);
  return false;
}

void PatchUnfolder::collect(std::uint32_t folded_triangle, int rings) {
  triangles_.assign(1, folded_triangle);
  for (int r = 0; r < rings; ++r) {
    vertices_.clear();
    around_.clear();
    start_.assign(1, 0);
    std::vector<std::array<std::uint32_t, 2>> corners;  // vertex, a triangle that has it
    for (const std::uint32_t t : triangles_)
      for (const std::uint32_t v : mesh_.triangle(level_, t)) corners.push_back({v, t});
    std::sort(corners.begin(), corners.end());
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const auto [v, t] = corners[i];
      if ((i > 0 && corners[i - 1][0] == v) || !collect_around(v, t, around_)) continue;
      vertices_.push_back(v);
      start_.push_back(around_.size());
    }
    triangles_.insert(triangles_.end(), around_.begin(), around_.end());
    make_unique(triangles_);
  }
  // Around an inner vertex each neighbour follows it in exactly one triangle.
  ring_.clear();
  for (std::size_t i = 0; i < vertices_.size(); ++i)
    for (const std::uint32_t t : around(i)) {
      const Triangle c = mesh_.triangle(level_, t);
      ring_.push_back(c[(corner_of(c, vertices_[i]) + 1) % 3]);
    }
}

void PatchUnfolder::smooth(Middle middle) {
  for (int sweep = 0; sweep < kSweeps && moves_left_ > 0; ++sweep) {
    for (std::size_t i = 0; i < vertices_.size(); ++i) move(i, middle);
    moves_left_ -= std::min(moves_left_, vertices_.size());
    if (note_if_better()) return;
  }
}

/// True: nothing is left to do.
bool PatchUnfolder::note_if_better() {
  const double bad = badness(triangles_);
  if (bad < least_) {
    least_ = bad;
    best_ = places();
  }
  return least_ < kPerCosine * kGood;
}

void PatchUnfolder::go_to_edges() {
  if (level_ == 0) return;
  const LevelTopology& coarse = topology_.level(level_ - 1);
  for (const std::uint32_t v : vertices_) {
    if (v < coarse.vertex_count) continue;
    const Edge& edge = coarse.edges[v - coarse.vertex_count];
    const Vec3 &a = mesh_.positions[edge.vertex[0]], &b = mesh_.positions[edge.vertex[1]];
    move_to(v, mesh_.tree().nearest((a + b) / 2), (a + b) / 2, (a - b).norm());
  }
  note_if_better();
}

void PatchUnfolder::move(std::size_t i, Middle middle) {
  const std::uint32_t v = vertices_[i];
  Vec3 normal = mesh_.scan_normal(mesh_.surface_face(v));
  for (const std::uint32_t w : ring(i)) normal += mesh_.scan_normal(mesh_.surface_face(w));
  const Vec3 centre = middle_of_ring(i);
  const double radius = radius_around(i, centre);
  if (middle == Middle::kInSpace) {
    const SurfacePoint place = mesh_.tree().nearest(centre);
    if (mesh_.scan_normal(place.face).dot(normal) > 0) move_to(v, place, centre, radius);
  } else if (const auto place = middle_in_domain(i)) {
    move_to(v, *place, centre, radius);
  }
}

Vec3 PatchUnfolder::middle_of_ring(std::size_t i) const {
  Vec3 sum = Vec3::Zero();
  for (const std::uint32_t w : ring(i)) sum += mesh_.positions[w];
  return sum / static_cast<double>(ring(i).size());
}

/// Of the vertex's neighbours.
double PatchUnfolder::radius_around(std::size_t i, const Vec3& middle) const {
  double radius = 0;
  for (const std::uint32_t w : ring(i))
    radius = std::max(radius, (mesh_.positions[w] - middle).norm());
  return radius;
}

std::optional<SurfacePoint> PatchUnfolder::middle_in_domain(std::size_t i) {
  const std::uint32_t v = vertices_[i];
  faces_.assign(1, mesh_.domain(v).face);
  for (const std::uint32_t w : ring(i)) faces_.push_back(mesh_.domain(w).face);
  const auto chart = mesh_.map().atlas().common_chart(faces_);
  if (!chart) return std::nullopt;
  Vec2 sum = Vec2::Zero();
  for (const std::uint32_t w : ring(i)) sum += *chart->map(mesh_.domain(w));
  const DomainPoint middle = chart->unmap(sum / static_cast<double>(ring(i).size()));
  return mesh_.map().to_surface(middle, mesh_.surface_face(v));
}

/// Unless that is not between the neighbours at all.
void PatchUnfolder::move_to(std::uint32_t vertex, const SurfacePoint& point, const Vec3& middle,
                            double radius) {
  const Vec3 at = position_of(point, mesh_.scan().triangles, mesh_.scan().positions);
  if ((at - middle).norm() <= radius) mesh_.store(vertex, point, at, Refinement::kVector);
}

/// Older vertices go back to what no triangle comes near any more, by `most` edges: to a tip, or
/// the end of a pit. And so do those that have gone farther than an edge.
void PatchUnfolder::give_back_missed(const std::vector<Refinement::Place>& before, double most) {
  const std::uint32_t older = level_ > 0 ? topology_.level(level_ - 1).vertex_count : kNone;
  const auto& p = mesh_.positions;
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    const Vec3& left = before[i].at;
    if (vertices_[i] >= older || p[vertices_[i]] == left) continue;
    double length = 0, nearest = std::numeric_limits<double>::infinity();
    for (const std::uint32_t w : ring(i)) length += (p[w] - left).norm();
    length /= static_cast<double>(ring(i).size());
    for (const std::uint32_t t : triangles_) {
      const Triangle c = mesh_.triangle(level_, t);
      nearest = std::min(nearest, distance_to_triangle(left, p[c[0]], p[c[1]], p[c[2]]));
    }
    if (nearest > most * length || (p[vertices_[i]] - left).norm() > length)
      mesh_.put(vertices_[i], before[i]);
  }
}

double PatchUnfolder::badness(std::span<const std::uint32_t> triangles) const {
  double sum = 0;
  for (const std::uint32_t t : triangles) {
    const Triangle triangle = mesh_.triangle(level_, t);
    const double facing = mesh_.facing(triangle);
    sum += (facing < 0 ? 1 - facing : 0) + kPerCosine * std::max(0.0, kGood - facing);
    const auto area = mesh_.domain_area(triangle, t >> (2 * level_));
    sum += !area ? kTorn : *area <= 0 ? kTurned : 0;
  }
  return sum;
}

std::vector<Refinement::Place> PatchUnfolder::places() const {
  std::vector<Refinement::Place> out;
  for (const std::uint32_t v : vertices_) out.push_back(mesh_.place(v));
  return out;
}

void PatchUnfolder::restore(const std::vector<Refinement::Place>& places) {
  for (std::size_t i = 0; i < vertices_.size(); ++i) mesh_.put(vertices_[i], places[i]);
}

}  // namespace nacre::remesh
