// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/adjacency.h"

#include <algorithm>

namespace nacre::remesh {

std::vector<Triangle> side_neighbors(std::span<const Triangle> triangles,
                                     std::uint32_t vertex_count) {
  // Sides in buckets by their lower vertex: a bucket holds about three, so searching it is cheap.
  std::vector<std::uint32_t> start(static_cast<std::size_t>(vertex_count) + 1, 0);
  const auto low = [&](std::size_t f, std::uint32_t k) {
    return std::min(triangles[f][k], triangles[f][(k + 1) % 3]);
  };
  for (std::size_t f = 0; f < triangles.size(); ++f)
    for (std::uint32_t k = 0; k < 3; ++k) ++start[low(f, k) + 1];
  for (std::size_t v = 0; v < vertex_count; ++v) start[v + 1] += start[v];
  std::vector<std::uint32_t> sides(3 * triangles.size());
  std::vector<std::uint32_t> fill(start.begin(), start.end() - 1);
  for (std::uint32_t f = 0; f < triangles.size(); ++f)
    for (std::uint32_t k = 0; k < 3; ++k) sides[fill[low(f, k)]++] = 3 * f + k;

  std::vector<Triangle> neighbors(triangles.size(), Triangle{kNone, kNone, kNone});
  for (std::size_t v = 0; v < vertex_count; ++v) {
    for (std::uint32_t i = start[v]; i < start[v + 1]; ++i) {
      const std::uint32_t f = sides[i] / 3, k = sides[i] % 3;
      const std::uint32_t a = triangles[f][k], b = triangles[f][(k + 1) % 3];
      std::uint32_t found = kNone, matches = 0, twins = 0;
      for (std::uint32_t m = start[v]; m < start[v + 1]; ++m) {
        const Triangle& t = triangles[sides[m] / 3];
        const std::uint32_t s = sides[m] % 3;
        if (t[s] == b && t[(s + 1) % 3] == a) found = sides[m] / 3, ++matches;
        if (t[s] == a && t[(s + 1) % 3] == b) ++twins;
      }
      if (matches == 1 && twins == 1) neighbors[f][k] = found;
    }
  }
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
