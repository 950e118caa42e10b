// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/surface_map.h"

#include <algorithm>
#include <cmath>

#include "remesh/adjacency.h"

namespace nacre::remesh {
namespace {

using Vec2 = Eigen::Vector2d;
constexpr int kMaxSteps = 500;
constexpr int kMostNets = 12;  // in one walk: where it needs more it goes astray
/// A weight above this counts as inside: far below what a step of the walk could mend.
constexpr double kInside = -1e-9;
/// Chart triangles of less area, in unit triangles, are rounding: a scan triangle with all corners
/// on one boundary curve is one.
constexpr double kFlatArea = 1e-13;
/// Charts differ by less than this share of a triangle about where its sides are.
constexpr double kGap = 0.25;

double cross2(const Vec2& a, const Vec2& b) { return a[0] * b[1] - a[1] * b[0]; }

SurfacePoint clamped(std::uint32_t face, std::array<double, 3> w) {
  double sum = 0;
  for (double& x : w) {
    x = std::max(x, 0.0);
    sum += x;
  }
  for (double& x : w) x /= sum;
  return {face, w};
}

}  // namespace

SurfaceMap::SurfaceMap(const Scan& scan, const Parameterisation& parameterisation)
    : scan_(scan),
      map_(parameterisation),
      atlas_(parameterisation.base),
      neighbors_(side_neighbors(scan.triangles, static_cast<std::uint32_t>(scan.positions.size()))),
      face_of_vertex_(
          face_of_vertex(scan.triangles, static_cast<std::uint32_t>(scan.positions.size()))) {
  vertex_start_.assign(map_.base.triangles.size() + 1, 0);
  for (const DomainPoint& p : map_.point) ++vertex_start_[p.face + 1];
  for (std::size_t f = 0; f + 1 < vertex_start_.size(); ++f)
    vertex_start_[f + 1] += vertex_start_[f];
  vertices_.resize(map_.point.size());
  std::vector<std::uint32_t> fill(vertex_start_.begin(), vertex_start_.end() - 1);
  for (std::uint32_t v = 0; v < map_.point.size(); ++v) vertices_[fill[map_.point[v].face]++] = v;
}

std::uint32_t SurfaceMap::start_triangle(std::uint32_t base_vertex) const {
  return face_of_vertex_[map_.base.scan_vertex[base_vertex]];
}

DomainPoint SurfaceMap::to_domain(const SurfacePoint& point) const {
  const Triangle& t = scan_.triangles[point.face];
  // A point of a side depends on that side's ends only: a boundary curve stays exactly itself.
  std::array<DomainPoint, 3> corners{};
  std::array<double, 3> weight{};
  std::size_t count = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    if (point.weight[k] == 0) continue;
    corners[count] = map_.point[t[k]];
    weight[count++] = point.weight[k];
  }
  const auto chart = atlas_.common_chart({corners.data(), count});
  if (!chart) {
    const auto most = std::max_element(point.weight.begin(), point.weight.end());
    return map_.point[t[static_cast<std::size_t>(most - point.weight.begin())]];
  }
  Vec2 sum = Vec2::Zero();
  for (std::size_t i = 0; i < count; ++i) sum += weight[i] * *chart->map(corners[i]);
  return chart->unmap(sum);
}

std::optional<SurfacePoint> SurfaceMap::walk(const DomainPoint& target, std::uint32_t start) const {
  std::uint32_t face = start, previous = kNone;
  int nets = 0;
  for (int step = 0; step < kMaxSteps; ++step) {
    const Triangle& t = scan_.triangles[face];
    std::array<DomainPoint, 4> points = {target, map_.point[t[0]], map_.point[t[1]],
                                         map_.point[t[2]]};
    const auto chart = atlas_.common_chart(points);
    if (!chart || (chart->is_net() && ++nets > kMostNets)) return std::nullopt;
    const Vec2 p = *chart->map(points[0]);
    const std::array<Vec2, 3> c = {*chart->map(points[1]), *chart->map(points[2]),
                                   *chart->map(points[3])};
    const double area = cross2(c[1] - c[0], c[2] - c[0]);
    std::array<double, 3> w{};
    for (std::size_t k = 0; k < 3; ++k) {
      const double part = cross2(c[(k + 1) % 3] - p, c[(k + 2) % 3] - p);
      // In a triangle that is turned over, or flat, the signs still say which side to leave by.
      w[k] = area > kFlatArea ? part / area : part;
    }
    if (area > kFlatArea && std::min({w[0], w[1], w[2]}) >= kInside) return clamped(face, w);
    // Leave by the side with the most negative weight.
    std::uint32_t leave = kNone;
    double least = 0;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t side = (k + 1) % 3;  // opposite to corner k
      if (w[k] < least) {
        least = w[k];
        leave = side;
      }
    }
    if (leave == kNone) return std::nullopt;
    const std::uint32_t next = neighbors_[face][leave];
    // Two charts may put the target just outside of both triangles, each on the other's side.
    if (next == previous && next != kNone && area > kFlatArea && least > -kGap)
      return clamped(face, w);
    if (next == kNone) {
      // Over the boundary: the nearest point of this triangle, if the target is as good as on it.
      if (area > kFlatArea && least > -0.5) return clamped(face, w);
      return std::nullopt;
    }
    previous = face;
    face = next;
  }
  return std::nullopt;
}

SurfacePoint SurfaceMap::to_surface(const DomainPoint& point, std::uint32_t hint) const {
  if (hint != kNone) {
    if (const auto found = walk(point, hint)) return *found;
  }
  // From the scan vertex of the same base triangle that is nearest in the domain.
  std::uint32_t nearest = kNone;
  double best = 1e300;
  for (std::uint32_t i = vertex_start_[point.face]; i < vertex_start_[point.face + 1]; ++i) {
    const auto& w = map_.point[vertices_[i]].weight;
    double distance = 0;
    for (std::size_t k = 0; k < 3; ++k)
      distance += (w[k] - point.weight[k]) * (w[k] - point.weight[k]);
    if (distance < best) {
      best = distance;
      nearest = vertices_[i];
    }
  }
  if (nearest == kNone) {
    // No scan vertex in this base triangle: its heaviest corner's own scan vertex.
    const auto most = std::max_element(point.weight.begin(), point.weight.end());
    const auto corner = static_cast<std::size_t>(most - point.weight.begin());
    nearest = map_.base.scan_vertex[map_.base.triangles[point.face][corner]];
  }
  if (const auto found = walk(point, face_of_vertex_[nearest])) return *found;
  SurfacePoint vertex{face_of_vertex_[nearest], {}};
  vertex.weight[corner_of(scan_.triangles[vertex.face], nearest)] = 1;
  return vertex;
}

}  // namespace nacre::remesh
