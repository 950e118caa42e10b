// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/adjacency.h"

#include "remesh/side_groups.h"

namespace nacre::remesh {

std::vector<Triangle> side_neighbors(std::span<const Triangle> triangles,
                                     std::uint32_t vertex_count) {
  std::vector<Triangle> neighbors(triangles.size(), Triangle{kNone, kNone, kNone});
  for_each_edge(triangles, vertex_count, [&](std::span<const std::uint32_t> sides) {
    if (sides.size() != 2) return;
    const std::uint32_t s = sides[0], other = sides[1];
    if (triangles[s / 3][s % 3] == triangles[other / 3][other % 3]) return;  // no opposite winding
    neighbors[s / 3][s % 3] = other / 3;
    neighbors[other / 3][other % 3] = s / 3;
  });
  return neighbors;
}

void collect_star(std::span<const Triangle> triangles, std::span<const Triangle> neighbors,
                  std::uint32_t vertex, std::uint32_t start_face, Star& star) {
  star.faces.clear();
  star.ring.clear();
  star.boundary = false;
  // Clockwise to the boundary, if there is one, so that the faces come in one sweep.
  std::uint32_t first = start_face;
  while (true) {
    const std::uint32_t previous = neighbors[first][corner_of(triangles[first], vertex)];
    if (previous == kNone) star.boundary = true;
    if (previous == kNone || previous == start_face) break;
    first = previous;
  }
  if (!star.boundary) first = start_face;
  std::uint32_t face = first;
  while (true) {
    const std::uint32_t c = corner_of(triangles[face], vertex);
    star.faces.push_back(face);
    star.ring.push_back(triangles[face][(c + 1) % 3]);
    const std::uint32_t next = neighbors[face][(c + 2) % 3];
    if (next == kNone) star.ring.push_back(triangles[face][(c + 2) % 3]);
    if (next == kNone || next == first) break;
    face = next;
  }
}

std::vector<std::uint32_t> face_of_vertex(std::span<const Triangle> triangles,
                                          std::uint32_t vertex_count) {
  std::vector<std::uint32_t> face(vertex_count, kNone);
  for (std::uint32_t f = 0; f < triangles.size(); ++f)
    for (const std::uint32_t v : triangles[f]) face[v] = f;
  return face;
}

}  // namespace nacre::remesh
