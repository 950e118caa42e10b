// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/surface_weights.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"

namespace nacre::codec {
namespace {

/// Of more vertices than this, surface_error() takes every second one, and so on:
/// it compares files of one mesh, which differ by more than such a sample does.
constexpr std::size_t kEnoughVertices = 100'000;

/// One third of the area of a level's triangles at each vertex.
std::vector<double> vertex_areas(const LevelTopology& level, std::span<const Vec3> p) {
  std::vector<double> areas(level.vertex_count, 0.0);
  for (const Triangle& t : level.triangles) {
    const double area = norm(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]])) / 6;
    for (const std::uint32_t v : t) areas[v] += area;
  }
  return areas;
}

void scale_to_mean_one(std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  if (!(sum > 0)) {
    std::fill(values.begin(), values.end(), 1.0);
    return;
  }
  const double scale = static_cast<double>(values.size()) / sum;
  for (double& v : values) v = std::max(v * scale, 0.01);
}

/// Of the finest triangles.
void list_fans(const Topology& topology, SurfaceWeights& weights) {
  const std::size_t vertices = topology.vertex_count();
  const auto& triangles = topology.level(topology.level_count()).triangles;
  weights.fan_begin.assign(vertices + 1, 0);
  for (const Triangle& triangle : triangles)
    for (const std::uint32_t v : triangle) ++weights.fan_begin[v + 1];
  for (std::size_t v = 0; v < vertices; ++v) weights.fan_begin[v + 1] += weights.fan_begin[v];
  weights.fans.resize(3 * triangles.size());
  std::vector<std::uint32_t> next(weights.fan_begin.begin(), weights.fan_begin.end() - 1);
  for (std::uint32_t f = 0; f < triangles.size(); ++f)
    for (const std::uint32_t v : triangles[f]) weights.fans[next[v]++] = f;
}

/// Areas, on all levels.
void weigh(const Topology& topology, std::span<const Vec3> p, SurfaceWeights& weights) {
  const int finest = topology.level_count();
  for (int j = 0; j <= finest; ++j) {
    std::vector<double> areas =
        vertex_areas(topology.level(j), p.first(topology.level(j).vertex_count));
    scale_to_mean_one(areas);
    const std::size_t kept = j == 0 ? 0 : topology.level(j - 1).vertex_count;
    weights.level_areas.emplace_back(areas.begin() + static_cast<std::ptrdiff_t>(kept),
                                     areas.end());
    if (j == finest) weights.areas = std::move(areas);
  }
}

/// In the triangle's plane where the foot lies inside, else on its sides.
SurfaceFoot foot_on_triangle(const Vec3& p, const Triangle& t, std::span<const Vec3> points) {
  const Vec3 normal = cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]);
  const double square = dot(normal, normal);
  bool is_inside = square > 0;
  SurfaceFoot foot{p, std::numeric_limits<double>::infinity()};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 &a = points[t[k]], side = points[t[(k + 1) % 3]] - a, from = p - a;
    if (dot(cross(side, from), normal) < 0) is_inside = false;
    const double length = dot(side, side);
    const double along = length > 0 ? std::clamp(dot(from, side) / length, 0.0, 1.0) : 0.0;
    const Vec3 rest = from - along * side;
    const double rest2 = dot(rest, rest);
    if (rest2 < foot.squared_distance) foot = {p - rest, rest2};
  }
  if (!is_inside) return foot;
  const double height = dot(p - points[t[0]], normal);
  return {p - height / square * normal, height * height / square};
}

}  // namespace

std::vector<Vec3> surface_normals(const Topology& topology, std::span<const Vec3> p) {
  std::vector<Vec3> normals(p.size(), Vec3::Zero());
  for (const Triangle& t : topology.level(topology.level_count()).triangles) {
    const Vec3 normal = cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
    for (const std::uint32_t v : t) normals[v] += normal;
  }
  for (Vec3& n : normals) {
    const double length = norm(n);
    n = length > 0 ? Vec3(n / length) : Vec3(0, 0, 1);
  }
  return normals;
}

SurfaceWeights surface_weights(const Prepared& prepared) {
  const Topology& topology = prepared.topology;
  const auto& p = prepared.positions;
  SurfaceWeights weights;
  in_parallel(
      [&] {
        weights.normals = surface_normals(topology, p);
        list_fans(topology, weights);
      },
      [&] { weigh(topology, p, weights); });
  return weights;
}

SurfaceFoot foot_on_surface(const Prepared& prepared, const SurfaceWeights& weights,
                            const Vec3& place, std::uint32_t from) {
  const std::vector<Vec3>& positions = prepared.surface();
  const auto& triangles = prepared.topology.level(prepared.topology.level_count()).triangles;
  const auto squared_to = [&](std::uint32_t vertex) {
    const Vec3 offset = place - positions[vertex];
    return dot(offset, offset);
  };
  // Vertices drift along the surface, so the nearest original vertex comes first.
  std::uint32_t nearest = from;
  double least = squared_to(nearest);
  for (std::uint32_t before = kNone; before != nearest;) {
    before = nearest;
    for (std::uint32_t i = weights.fan_begin[before]; i < weights.fan_begin[before + 1]; ++i) {
      for (const std::uint32_t other : triangles[weights.fans[i]]) {
        const double square = squared_to(other);
        if (!(square < least)) continue;
        least = square;
        nearest = other;
      }
    }
  }
  SurfaceFoot best{positions[nearest], least};
  for (std::uint32_t i = weights.fan_begin[nearest]; i < weights.fan_begin[nearest + 1]; ++i) {
    const SurfaceFoot foot = foot_on_triangle(place, triangles[weights.fans[i]], positions);
    if (foot.squared_distance < best.squared_distance) best = foot;
  }
  return best;
}

double surface_error(const Prepared& prepared, const SurfaceWeights& weights,
                     std::span<const Vec3> positions) {
  const std::size_t stride = std::max<std::size_t>(1, positions.size() / kEnoughVertices);
  const std::size_t count = (positions.size() + stride - 1) / stride;
  const double sum = deterministic_sum<double>(count, [&](std::size_t i) {
    const auto v = static_cast<std::uint32_t>(i * stride);
    return weights.areas[v] * foot_on_surface(prepared, weights, positions[v], v).squared_distance;
  });
  return sum / static_cast<double>(count);
}

}  // namespace nacre::codec
