// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/fill_loops.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>

#include <exception>
#include <set>

#include "remesh/side_groups.h"

namespace nacre::remesh {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

/// A pin hole has at most so many edges, and is no wider than either of these: a share of its
/// piece's extent, and so many of its own edges (what a few lost triangles leave). What is wide
/// beside its piece is the piece's outline, whatever else it is.
constexpr std::size_t kMostEdges = 12;
constexpr double kPinHole = 0.01, kPinHoleEdges = 3, kOutline = 0.2;

/// Triangles over the corners 0 .. n - 1 of a closed polygon, each side i → i + 1 in one of them.
/// Empty if CGAL finds none.
std::vector<Triangle> fill_polygon(const std::vector<Vec3>& polygon) {
  const auto n = static_cast<std::uint32_t>(polygon.size());
  if (n == 3) return {{0, 1, 2}};
  std::vector<Kernel::Point_3> points;
  for (const Vec3& p : polygon) points.emplace_back(p[0], p[1], p[2]);
  std::vector<CGAL::Triple<int, int, int>> found;
  try {
    CGAL::Polygon_mesh_processing::triangulate_hole_polyline(points, std::back_inserter(found));
  } catch (const std::exception&) {
    return {};
  }
  if (found.size() + 2 != n) return {};
  std::vector<Triangle> out;
  bool reversed = true;
  for (const auto& t : found) {
    out.push_back({static_cast<std::uint32_t>(t.first), static_cast<std::uint32_t>(t.second),
                   static_cast<std::uint32_t>(t.third)});
    for (std::size_t k = 0; k < 3; ++k)
      reversed &= !(out.back()[k] == 0 && out.back()[(k + 1) % 3] == 1);
  }
  if (reversed)
    for (Triangle& t : out) std::swap(t[1], t[2]);
  return out;
}

using Ends = std::pair<std::uint32_t, std::uint32_t>;

/// Edges of the mesh between any two vertices of the loops.
std::set<Ends> edges_between(std::span<const Triangle> triangles,
                             const std::vector<char>& on_loop) {
  std::set<Ends> edges;
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k)
      if (on_loop[t[k]] && on_loop[t[(k + 1) % 3]])
        edges.insert(std::minmax({t[k], t[(k + 1) % 3]}));
  return edges;
}

/// Whether an inner edge of the filling is there already; if not, all of them are noted.
bool collides(const std::vector<Triangle>& filling, const std::vector<std::uint32_t>& corners,
              std::set<Ends>& edges) {
  const auto n = static_cast<std::uint32_t>(corners.size());
  std::set<Ends> inner;
  for (const Triangle& t : filling) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax({t[k], t[(k + 1) % 3]});
      if (high - low != 1 && high - low != n - 1)
        inner.insert(std::minmax({corners[low], corners[high]}));
    }
  }
  for (const Ends& edge : inner)
    if (edges.count(edge) > 0) return true;
  edges.insert(inner.begin(), inner.end());
  return false;
}

}  // namespace

std::vector<std::vector<std::uint32_t>> boundary_loops(std::span<const std::uint32_t> partner) {
  std::vector<char> seen(partner.size(), 0);
  std::vector<std::vector<std::uint32_t>> loops;
  for (std::uint32_t first = 0; first < partner.size(); ++first) {
    if (partner[first] != kNone || seen[first]) continue;
    loops.emplace_back();
    for (std::uint32_t s = first; !seen[s];) {
      seen[s] = 1;
      loops.back().push_back(s);
      s = s - s % 3 + (s % 3 + 1) % 3;  // from its end, through the faces there, to the boundary
      while (partner[s] != kNone) s = partner[s] - partner[s] % 3 + (partner[s] % 3 + 1) % 3;
    }
  }
  return loops;
}

void fill_loops(CleanScan& cleaned, std::vector<std::uint32_t>& source,
                std::span<const std::vector<std::uint32_t>> loops) {
  auto& [positions, triangles, origin] = cleaned.scan;
  std::vector<char> on_loop(positions.size(), 0);
  for (const auto& loop : loops)
    for (const std::uint32_t s : loop) on_loop[triangles[s / 3][s % 3]] = 1;
  std::set<Ends> edges = edges_between(triangles, on_loop);
  for (const auto& loop : loops) {
    std::vector<std::uint32_t> corners;  // against the faces, so that the filling runs with them
    std::vector<Vec3> polygon;
    Vec3 middle = Vec3::Zero();
    for (auto s = loop.rbegin(); s != loop.rend(); ++s) {
      corners.push_back(triangles[*s / 3][(*s % 3 + 1) % 3]);
      polygon.push_back(positions[corners.back()]);
      middle += polygon.back() / static_cast<double>(loop.size());
    }
    std::vector<Triangle> filling = fill_polygon(polygon);
    if (filling.empty() || collides(filling, corners, edges)) {
      filling.clear();
      const auto n = static_cast<std::uint32_t>(corners.size());
      for (std::uint32_t i = 0; i < n; ++i) filling.push_back({i, (i + 1) % n, n});
      corners.push_back(static_cast<std::uint32_t>(positions.size()));
      positions.push_back(middle);
    }
    for (const Triangle& t : filling) {
      triangles.push_back({corners[t[0]], corners[t[1]], corners[t[2]]});
      cleaned.piece.push_back(cleaned.piece[loop[0] / 3]);
      source.push_back(source[loop[0] / 3]);
    }
  }
}

void fill_pin_holes(CleanScan& cleaned, std::vector<std::uint32_t>& source, CleanCounts& counts) {
  const auto& [positions, triangles, origin] = cleaned.scan;
  const auto partner = side_partners(triangles, positions.size());
  const std::vector<double> extents = piece_extents(cleaned);
  std::vector<std::vector<std::uint32_t>> holes;
  for (auto& loop : boundary_loops(partner)) {
    if (loop.size() > kMostEdges) continue;
    Box box;
    double length = 0;
    for (const std::uint32_t s : loop) {
      const Vec3 &a = positions[triangles[s / 3][s % 3]],
                 &b = positions[triangles[s / 3][(s % 3 + 1) % 3]];
      box.add(a);
      length += (b - a).norm();
    }
    const double whole = extents[cleaned.piece[loop[0] / 3]];
    const double edge = length / static_cast<double>(loop.size());
    if (box.extent() > std::max(kPinHole * whole, kPinHoleEdges * edge) ||
        box.extent() > kOutline * whole)
      continue;
    std::uint32_t first = kNone;
    for (const std::uint32_t s : loop) first = std::min(first, source[s / 3]);
    counts.holes.add(first);
    counts.holes.measure(0, box.extent());
    holes.push_back(std::move(loop));
  }
  if (!holes.empty()) fill_loops(cleaned, source, holes);
}

}  // namespace nacre::remesh
