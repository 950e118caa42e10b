// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/refinement.h"

#include <array>

#include "remesh/indices_where.h"

namespace nacre::remesh {

void Refinement::resize(std::size_t vertices) {
  positions.resize(vertices);
  surface.resize(vertices);
  domain.resize(vertices);
  kind.resize(vertices, kNormal);
}

void Refinement::put(std::size_t vertex, const Place& place) {
  if (journal != nullptr)
    journal->emplace_back(static_cast<std::uint32_t>(vertex), this->place(vertex));
  surface[vertex] = place.surface;
  domain[vertex] = place.domain;
  positions[vertex] = place.at;
  kind[vertex] = place.kind;
}

void Refinement::store(std::size_t vertex, const SurfacePoint& point, const Vec3& at, Kind k) {
  put(vertex, {point, map_.to_domain(point), at, k});
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
  const Vec3 under = scan_normal(surface[t[0]].face) + scan_normal(surface[t[1]].face) +
                     scan_normal(surface[t[2]].face);
  const double size = n.norm() * under.norm();
  return size > 0 ? n.dot(under) / size : 0;
}

bool Refinement::is_folded(const Triangle& t) const {
  const Vec3 n = (positions[t[1]] - positions[t[0]]).cross(positions[t[2]] - positions[t[0]]);
  const auto& p = scan().positions;
  // Nearly always the scan's normals all agree, and then their lengths do not matter.
  for (const std::uint32_t v : t) {
    const Triangle& under = scan().triangles[surface[v].face];
    if (!(n.dot((p[under[1]] - p[under[0]]).cross(p[under[2]] - p[under[0]])) > 0))
      return facing(t) < 0;
  }
  return false;
}

std::vector<std::uint32_t> Refinement::folded_triangles(int level) const {
  const auto& triangles = topology_.level(level).triangles;
  return indices_where(triangles.size(), [&](std::size_t i) { return is_folded(triangles[i]); });
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
  const DomainPoint& p = domain[vertex];
  return map_.atlas().seen_from(p, base_face).value_or(p);
}

SurfacePoint Refinement::expected_point(const Edge& edge, std::uint32_t base_face,
                                        const Vec3& otherwise) const {
  std::array<DomainPoint, 2> ends = {seen_from(edge.vertex[0], base_face),
                                     seen_from(edge.vertex[1], base_face)};
  const auto chart = map_.atlas().common_chart(ends);
  if (!chart) return tree_.nearest(otherwise);
  const DomainPoint middle = chart->unmap((*chart->map(ends[0]) + *chart->map(ends[1])) / 2);
  return map_.to_surface(middle, surface[edge.vertex[0]].face);
}

}  // namespace nacre::remesh
