// SPDX-License-Identifier: Apache-2.0
#include "entropy/closed_mesh.h"

#include <algorithm>
#include <string>
#include <utility>

namespace nacre::entropy {
namespace {

Error bad_triangle(std::size_t triangle, const std::string& what) {
  return {ErrorCode::kBadInput, "triangle " + std::to_string(triangle) + " " + what, triangle};
}

Error bad_vertex(std::size_t vertex, const std::string& what) {
  return {ErrorCode::kBadInput, "vertex " + std::to_string(vertex) + " " + what, vertex};
}

Result<void> check_corners(std::span<const Triangle> triangles, std::uint32_t vertex_count) {
  for (std::size_t f = 0; f < triangles.size(); ++f) {
    const auto& [a, b, c] = triangles[f];
    if (std::max({a, b, c}) >= vertex_count) return bad_triangle(f, "names a vertex out of range");
    if (a == b || b == c || c == a) return bad_triangle(f, "repeats a vertex");
  }
  return {};
}

/// Pairs the half-edges; those on the boundary keep kNone.
Result<void> pair_half_edges(ClosedMesh& mesh) {
  // Sorted by (lower end, upper end, id), the two sides of an edge become neighbours.
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keyed;
  keyed.reserve(3 * mesh.triangles.size());
  for (std::uint32_t h = 0; h < 3 * mesh.triangles.size(); ++h) {
    const std::uint64_t a = mesh.from(h), b = mesh.from(next_side(h));
    keyed.emplace_back((std::min(a, b) << 32) | std::max(a, b), h);
  }
  std::sort(keyed.begin(), keyed.end());
  mesh.twins.assign(keyed.size(), kNone);
  for (std::size_t i = 0, end = 0; i < keyed.size(); i = end) {
    for (end = i + 1; end < keyed.size() && keyed[end].first == keyed[i].first;) ++end;
    if (end - i > 2) return bad_triangle(keyed[i + 2].second / 3, "is a third one on an edge");
    if (end - i < 2) continue;
    const std::uint32_t g = keyed[i].second, h = keyed[i + 1].second;
    if (mesh.from(g) == mesh.from(h))
      return bad_triangle(h / 3, "is oriented against its neighbour");
    mesh.twins[g] = h;
    mesh.twins[h] = g;
  }
  return {};
}

/// Fills each boundary loop with a fan around a new vertex. The triangle across boundary half-edge
/// a → b is (b, a, dummy).
Result<void> close_boundaries(ClosedMesh& mesh) {
  const auto half_edge_count = static_cast<std::uint32_t>(mesh.twins.size());
  std::vector<std::uint32_t> boundary_from(mesh.vertex_count, kNone);
  for (std::uint32_t h = 0; h < half_edge_count; ++h) {
    if (mesh.twins[h] != kNone) continue;
    std::uint32_t& slot = boundary_from[mesh.from(h)];
    if (slot != kNone) return bad_vertex(mesh.from(h), "joins several boundary loops");
    slot = h;
  }
  std::uint32_t dummy = mesh.vertex_count;
  for (std::uint32_t start = 0; start < half_edge_count; ++start) {
    if (mesh.twins[start] != kNone) continue;
    const auto first = static_cast<std::uint32_t>(mesh.triangles.size());
    // As many boundary half-edges end at a vertex as start there, so the walk returns to `start`.
    for (std::uint32_t h = start; mesh.twins[h] == kNone;) {
      const auto fan = static_cast<std::uint32_t>(mesh.triangles.size());
      const std::uint32_t b = mesh.from(next_side(h));
      mesh.triangles.push_back({b, mesh.from(h), dummy});
      mesh.twins[h] = 3 * fan;
      const std::uint32_t before = fan == first ? kNone : 3 * (fan - 1) + 2;
      mesh.twins.insert(mesh.twins.end(), {h, before, kNone});
      if (before != kNone) mesh.twins[before] = 3 * fan + 1;
      h = boundary_from[b];
    }
    const auto last = static_cast<std::uint32_t>(mesh.triangles.size()) - 1;
    mesh.twins[3 * first + 1] = 3 * last + 2;
    mesh.twins[3 * last + 2] = 3 * first + 1;
    ++dummy;
  }
  mesh.valences.assign(dummy, 0);
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t) ++mesh.valences[v];
  return {};
}

Result<void> check_fans(const ClosedMesh& mesh) {
  std::vector<bool> seen(mesh.valences.size(), false);
  for (std::uint32_t h = 0; h < mesh.twins.size(); ++h) {
    const std::uint32_t v = mesh.from(h);
    if (seen[v]) continue;
    seen[v] = true;
    std::uint32_t fan = 0, at = h;
    do {
      ++fan;
      at = mesh.twins[previous_side(at)];
    } while (at != h);
    if (fan != mesh.valences[v]) return bad_vertex(v, "has several fans of triangles");
  }
  const auto unused = std::find(seen.begin(), seen.end(), false);
  if (unused != seen.end())
    return bad_vertex(static_cast<std::size_t>(unused - seen.begin()), "has no triangle");
  return {};
}

}  // namespace

Result<ClosedMesh> close_mesh(std::span<const Triangle> triangles, std::uint32_t vertex_count) {
  // Four times the half-edges is the most that the dummies' fans can make of them.
  if (triangles.size() > kNone / 16 || vertex_count > 3 * triangles.size())
    return Error{ErrorCode::kBadInput, "too many triangles, or vertices without one", 0};
  if (const auto ok = check_corners(triangles, vertex_count); !ok) return ok.error();
  ClosedMesh mesh;
  mesh.vertex_count = vertex_count;
  mesh.triangles.assign(triangles.begin(), triangles.end());
  if (const auto ok = pair_half_edges(mesh); !ok) return ok.error();
  if (const auto ok = close_boundaries(mesh); !ok) return ok.error();
  if (const auto ok = check_fans(mesh); !ok) return ok.error();
  return mesh;
}

}  // namespace nacre::entropy
