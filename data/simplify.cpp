// SPDX-License-Identifier: GPL-3.0-or-later
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_ratio_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Edge_length_cost.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Midpoint_placement.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include "data/merge.h"

namespace nacre::data {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

}  // namespace

Scan simplify(const Scan& scan, std::size_t faces) {
  namespace sms = CGAL::Surface_mesh_simplification;
  Mesh mesh;
  for (const Vec3& p : scan.positions) mesh.add_vertex({p[0], p[1], p[2]});
  for (const Triangle& t : scan.triangles)  // a face that would not be manifold is refused: dropped
    mesh.add_face(Mesh::Vertex_index(t[0]), Mesh::Vertex_index(t[1]), Mesh::Vertex_index(t[2]));
  if (mesh.number_of_faces() > faces) {
    const double ratio = static_cast<double>(faces) / static_cast<double>(mesh.number_of_faces());
    const sms::Count_ratio_stop_predicate<Mesh> stop(ratio);  // counts edges, near enough
    sms::edge_collapse(mesh, stop,
                       CGAL::parameters::get_cost(sms::Edge_length_cost<Mesh>())
                           .get_placement(sms::Midpoint_placement<Mesh>()));
  }
  mesh.collect_garbage();
  Scan out;
  out.origin = scan.origin;
  for (const auto v : mesh.vertices()) {
    const auto& p = mesh.point(v);
    out.positions.emplace_back(p.x(), p.y(), p.z());
  }
  for (const auto f : mesh.faces()) {
    Triangle t{};
    std::size_t k = 0;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(f))) t[k++] = v;
    out.triangles.push_back(t);
  }
  return out;
}

}  // namespace nacre::data
