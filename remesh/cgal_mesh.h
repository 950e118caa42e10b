// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CGAL/Surface_mesh.h>

#include <vector>

#include "base/scan.h"

namespace nacre::remesh {

/// The vertices and faces, all of them triangles, that a CGAL mesh still has, in its order.
template <class Point>
[[nodiscard]] Scan scan_of(const CGAL::Surface_mesh<Point>& mesh) {
  Scan scan;
  std::vector<std::uint32_t> id(mesh.number_of_vertices() + mesh.number_of_removed_vertices());
  for (const auto v : mesh.vertices()) {
    id[v] = static_cast<std::uint32_t>(scan.positions.size());
    const Point& p = mesh.point(v);
    scan.positions.emplace_back(p.x(), p.y(), p.z());
  }
  for (const auto f : mesh.faces()) {
    Triangle t{};
    std::size_t k = 0;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(f))) t[k++] = id[v];
    scan.triangles.push_back(t);
  }
  return scan;
}

}  // namespace nacre::remesh
