// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/refinement.h"

#include <algorithm>
#include <array>
#include <limits>

#include "base/parallel.h"
#include "remesh/adjacency.h"
#include "remesh/indices_where.h"
#include "remesh/tips.h"

namespace nacre::remesh {
namespace {

/// A cosine from the scan's normal.
constexpr double kNearlyFolded = 0.3;
/// A point of the scan with a smaller weight is on a side of its triangle.
constexpr double kOnSide = 1e-9;

bool is_on_side(const SurfacePoint& p) {
  return *std::min_element(p.weight.begin(), p.weight.end()) < kOnSide;
}

/// Visits every triangle of the scan that has the point, which may be on a side or at a vertex.
template <class Visit>
void for_triangles_at(const SurfaceMap& map, const SurfacePoint& point, const Visit& visit) {
  visit(point.face);
  if (!is_on_side(point)) return;
  const auto& triangles = map.scan().triangles;
  const auto most = static_cast<std::uint32_t>(
      std::max_element(point.weight.begin(), point.weight.end()) - point.weight.begin());
  const std::uint32_t next = (most + 1) % 3, last = (most + 2) % 3;
  if (point.weight[next] < kOnSide && point.weight[last] < kOnSide) {
    Star star;
    collect_star(triangles, map.neighbors(), triangles[point.face][most], point.face, star);
    for (const std::uint32_t f : star.faces) visit(f);
    return;
  }
  // Side k goes from corner k to the next one.
  const std::uint32_t side = point.weight[next] < kOnSide ? last : most;
  const std::uint32_t other = map.neighbors()[point.face][side];
  if (other != kNone) visit(other);
}

}  // namespace

Refinement::Refinement(const SurfaceMap& map, const BaseMesh& base, const LineTree& tree,
                       const Topology& topology)
    : map_(map),
      has_tips_(!tips_of(map.scan()).empty()),
      base_(base),
      tree_(tree),
      topology_(topology),
      coarser_(topology.level(std::max(topology.level_count() - 1, 0)).vertex_count),
      base_domain_(topology.level(0).vertex_count) {
  for (int level = 0; level < topology.level_count(); ++level) {
    const LevelTopology& coarse = topology.level(level);
    for (std::size_t e = 0; e < coarse.edges.size(); ++e)
      if (coarse.edges[e].is_boundary())
        boundary_.push_back(static_cast<std::uint32_t>(coarse.vertex_count + e));
  }
  boundary_domain_.resize(boundary_.size());
}

void Refinement::resize(std::size_t vertices) {
  positions.resize(vertices);
  surface_.resize(std::min(vertices, coarser_));
  face_.resize(vertices - surface_.size(), 0);
  kind.resize(vertices, kNormal);
}

std::size_t Refinement::on_boundary(std::size_t vertex) const {
  return static_cast<std::size_t>(std::lower_bound(boundary_.begin(), boundary_.end(), vertex) -
                                  boundary_.begin());
}

SurfacePoint Refinement::surface(std::size_t vertex) const {
  if (vertex < coarser_) return surface_[vertex];
  const std::uint32_t face = face_[vertex - coarser_];
  return (face & kExact) == 0
             ? point_below(positions[vertex], face, scan().triangles, scan().positions)
             : exact_[face & ~kExact];
}

/// After its position and its kind.
void Refinement::set_surface(std::size_t vertex, const SurfacePoint& point) {
  if (vertex < coarser_) {
    surface_[vertex] = point;
    return;
  }
  std::uint32_t& face = face_[vertex - coarser_];
  if (kind[vertex] == kNormal && (face & kExact) == 0) {
    face = point.face;
    return;
  }
  const std::lock_guard lock(exact_in_use_);
  if (kind[vertex] == kNormal) {
    free_.push_back(face & ~kExact);
    face = point.face;
    return;
  }
  if ((face & kExact) == 0) {
    if (free_.empty()) {
      free_.push_back(static_cast<std::uint32_t>(exact_.size()));
      exact_.emplace_back();
    }
    face = kExact | free_.back();
    free_.pop_back();
  }
  exact_[face & ~kExact] = point;
}

DomainPoint Refinement::domain(std::size_t vertex) const {
  if (vertex < base_domain_.size()) return base_domain_[vertex];
  if (is_boundary(kind[vertex])) return boundary_domain_[on_boundary(vertex)];
  return map_.to_domain(surface(vertex));
}

void Refinement::set_domain(std::size_t vertex, const DomainPoint& point) {
  if (vertex < base_domain_.size())
    base_domain_[vertex] = point;
  else if (is_boundary(kind[vertex]))
    boundary_domain_[on_boundary(vertex)] = point;
}

void Refinement::note(std::uint32_t vertex) {
  const auto known = journal->lower_bound(vertex);
  if (known == journal->end() || known->first != vertex)
    journal->emplace_hint(known, vertex, Earlier{place(vertex)});
  else if (positions[vertex] != known->second.place.at)
    known->second.has_strayed = true;
}

void Refinement::put(std::size_t vertex, const Place& place) {
  if (journal != nullptr) note(static_cast<std::uint32_t>(vertex));
  positions[vertex] = place.at;
  kind[vertex] = place.kind;
  set_surface(vertex, place.surface);
  set_domain(vertex, place.domain);
}

void Refinement::store(std::size_t vertex, const SurfacePoint& point, const Vec3& at, Kind k) {
  const bool is_kept = vertex < base_domain_.size();
  put(vertex, {point, is_kept ? map_.to_domain(point) : DomainPoint{}, at, k});
}

void Refinement::store(std::size_t vertex, const SurfacePoint& point, Kind k) {
  store(vertex, point, position_of(point, scan().triangles, scan().positions), k);
}

Vec3 Refinement::scan_normal(std::uint32_t face) const {
  const Triangle& t = scan().triangles[face];
  const auto& p = scan().positions;
  return (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).stableNormalized();
}

double Refinement::facing(const Triangle& t) const {
  const Vec3 n = (positions[t[1]] - positions[t[0]]).cross(positions[t[2]] - positions[t[0]]);
  const Vec3 under = scan_normal(surface_face(t[0])) + scan_normal(surface_face(t[1])) +
                     scan_normal(surface_face(t[2]));
  const double size = n.norm() * under.norm();
  const double cosine = size > 0 ? n.dot(under) / size : 0;
  if (!has_tips_ || cosine >= 0 || !(n.norm() > 0)) return cosine;
  // On a crease it is arbitrary whose normal counts: there the scan under the middle counts as
  // well.
  if (std::none_of(t.begin(), t.end(), [&](std::uint32_t v) { return is_on_side(surface(v)); }))
    return cosine;
  const Vec3 middle = (positions[t[0]] + positions[t[1]] + positions[t[2]]) / 3;
  return std::max(cosine, n.dot(scan_normal(tree_.nearest(middle).face)) / n.norm());
}

bool Refinement::is_folded(const Triangle& t) const {
  const Vec3 n = (positions[t[1]] - positions[t[0]]).cross(positions[t[2]] - positions[t[0]]);
  const auto& p = scan().positions;
  // Nearly always the scan's normals all agree, and then their lengths do not matter.
  for (const std::uint32_t v : t) {
    const Triangle& under = scan().triangles[surface_face(v)];
    if (!(n.dot((p[under[1]] - p[under[0]]).cross(p[under[2]] - p[under[0]])) > 0))
      return facing(t) < 0;
  }
  return false;
}

bool Refinement::is_opposed(const Triangle& t, Ties ties) const {
  const Vec3 &a = positions[t[0]], &b = positions[t[1]], &c = positions[t[2]];
  const Vec3 n = (b - a).cross(c - a);
  const double sign = ties == Ties::kAny ? 1 : -1;
  const auto along = [&](const Vec3& p) {
    const SurfacePoint nearest = tree_.nearest(p);
    if (!has_tips_) return n.dot(scan_normal(nearest.face));
    double least = std::numeric_limits<double>::infinity();
    for_triangles_at(map_, nearest, [&](std::uint32_t face) {
      least = std::min(least, sign * n.dot(scan_normal(face)));
    });
    return sign * least;
  };
  return along((a + b + c) / 3) < 0 && along(a) + along(b) + along(c) < 0;
}

bool Refinement::is_suspect(const Triangle& t, double facing) const {
  const bool is_asked =
      facing < kNearlyFolded || std::any_of(t.begin(), t.end(), [&](std::uint32_t v) {
        return (has_tips_ || kind[v] == kVector) && is_on_side(surface(v));
      });
  return is_asked && is_opposed(t);
}

std::vector<std::uint32_t> Refinement::opposed_triangles(int level) const {
  return indices_where(topology_.triangle_count(level), [&](std::size_t i) {
    const Triangle t = triangle(level, i);
    const bool is_plain = std::all_of(t.begin(), t.end(), [&](std::uint32_t v) {
      return kind[v] != kVector && !(has_tips_ && is_on_side(surface(v)));
    });
    if (is_plain) return is_folded(t);
    const double facing = this->facing(t);
    return facing < 0 || is_suspect(t, facing);
  });
}

std::vector<std::uint32_t> Refinement::folded_triangles(int level) const {
  return indices_where(topology_.triangle_count(level),
                       [&](std::size_t i) { return is_folded(triangle(level, i)); });
}

std::vector<std::uint32_t> Refinement::turned_triangles(int level) const {
  const LevelTopology& coarse = topology_.level(level - 1);
  std::vector<std::uint8_t> turned(coarse.triangles.size());  // a bit for each of four
  parallel_for_each_index(turned.size(), [&](std::size_t f) {
    const auto base_face = static_cast<std::uint32_t>(f >> (2 * (level - 1)));
    std::array<DomainPoint, 6> at;  // of the corners, then of the sides' middles
    for (std::size_t k = 0; k < 3; ++k) {
      at[k] = seen_from(coarse.triangles[f][k], base_face);
      at[3 + k] = seen_from(coarse.vertex_count + coarse.triangle_edges[f][k], base_face);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      const auto area =
          map_.atlas().doubled_area(k == 3 ? std::array{at[3], at[4], at[5]}
                                           : std::array{at[k], at[3 + k], at[3 + (k + 2) % 3]});
      if (!area || *area <= 0) turned[f] |= static_cast<std::uint8_t>(1u << k);
    }
  });
  std::vector<std::uint32_t> out;
  for (std::uint32_t i = 0; i < 4 * turned.size(); ++i)
    if ((turned[i / 4] >> (i % 4) & 1) != 0) out.push_back(i);
  return out;
}

std::optional<double> Refinement::domain_area(const Triangle& t, std::uint32_t base_face) const {
  return map_.atlas().doubled_area(
      {seen_from(t[0], base_face), seen_from(t[1], base_face), seen_from(t[2], base_face)});
}

bool Refinement::is_turned(const Triangle& t, std::uint32_t base_face) const {
  const auto area = domain_area(t, base_face);
  return !area || *area <= 0;
}

DomainPoint Refinement::seen_from(std::uint32_t vertex, std::uint32_t base_face) const {
  const DomainPoint p = domain(vertex);
  return map_.atlas().seen_from(p, base_face).value_or(p);
}

SurfacePoint Refinement::expected_point(const Edge& edge, std::uint32_t base_face,
                                        const Vec3& otherwise) const {
  std::array<DomainPoint, 2> ends = {seen_from(edge.vertex[0], base_face),
                                     seen_from(edge.vertex[1], base_face)};
  const auto chart = map_.atlas().common_chart(ends);
  if (!chart) return tree_.nearest(otherwise);
  const DomainPoint middle = chart->unmap((*chart->map(ends[0]) + *chart->map(ends[1])) / 2);
  return map_.to_surface(middle, surface_face(edge.vertex[0]));
}

}  // namespace nacre::remesh
