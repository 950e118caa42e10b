// SPDX-License-Identifier: GPL-3.0-or-later
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/alpha_wrap_3.h>

#include <cmath>
#include <exception>

#include "remesh/cgal_mesh.h"
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
  Scan out = scan_of(mesh);
  out.origin = piece.origin;
  if (out.triangles.empty()) return Error{ErrorCode::kNoConvergence, "the wrap came out empty", 0};
  return out;
}

}  // namespace nacre::remesh
