// SPDX-License-Identifier: GPL-3.0-or-later
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include <cmath>
#include <exception>

#include "remesh/remesh.h"

namespace nacre::remesh {

Result<Scan> wrap(const Scan& piece, double alpha, double offset) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  if (!(alpha > 0 && std::isfinite(alpha) && offset > 0 && std::isfinite(offset)))
    return Error{ErrorCode::kBadInput, "alpha and offset of a wrap must be positive", 0};
  if (piece.triangles.empty()) return Error{ErrorCode::kGeometryRefused, "nothing to wrap", 0};
  std::vector<Kernel::Point_3> points;
  for (const Vec3& p : piece.positions) points.emplace_back(p[0], p[1], p[2]);
  std::vector<std::array<std::size_t, 3>> faces;
  for (const Triangle& t : piece.triangles) faces.push_back({t[0], t[1], t[2]});
  CGAL::Surface_mesh<Kernel::Point_3> mesh;
  try {
    CGAL::alpha_wrap_3(points, faces, alpha, offset, mesh);
  } catch (const std::exception& e) {
    return Error{ErrorCode::kNoConvergence, std::string("wrapping failed: ") + e.what(), 0};
  }
  Scan out;
  out.origin = piece.origin;
  for (const auto v : mesh.vertices()) {
    const Kernel::Point_3& p = mesh.point(v);
    out.positions.emplace_back(p.x(), p.y(), p.z());
  }
  for (const auto f : mesh.faces()) {
    Triangle t{};
    std::size_t k = 0;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(f)))
      t[k++] = static_cast<std::uint32_t>(v.idx());
    out.triangles.push_back(t);
  }
  if (out.triangles.empty()) return Error{ErrorCode::kNoConvergence, "the wrap came out empty", 0};
  return out;
}

}  // namespace nacre::remesh
