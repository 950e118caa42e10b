// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/base_domain.h"

namespace nacre::remesh {
namespace {

/// Closed pieces of fewer triangles hold on to their corners: around those of an octahedron a third
/// of the plane is missing already, and a map slides to where it needs the least of it.
constexpr std::size_t kFewTriangles = 10;

}  // namespace

std::vector<char> pinned_vertices(const Parameterisation& map) {
  const BaseMesh& base = map.base;
  std::vector<char> pinned(map.point.size(), 0), seen(base.triangles.size(), 0);
  std::vector<std::uint32_t> piece;
  for (std::uint32_t seed = 0; seed < base.triangles.size(); ++seed) {
    if (seen[seed]) continue;
    seen[seed] = 1;
    piece.assign(1, seed);
    bool closed = true;
    for (std::size_t i = 0; i < piece.size(); ++i) {
      for (const std::uint32_t next : base.neighbors[piece[i]]) {
        closed &= next != kNone;
        if (next == kNone || seen[next]) continue;
        seen[next] = 1;
        piece.push_back(next);
      }
    }
    if (!closed || piece.size() >= kFewTriangles) continue;
    for (const std::uint32_t f : piece)
      for (const std::uint32_t v : base.triangles[f]) pinned[base.scan_vertex[v]] = 1;
  }
  return pinned;
}

}  // namespace nacre::remesh
