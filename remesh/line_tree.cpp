// SPDX-License-Identifier: GPL-3.0-or-later
#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

#include <algorithm>
#include <cmath>

#include "remesh/pierce.h"

namespace nacre::remesh {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Iterator = std::vector<Kernel::Triangle_3>::const_iterator;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

Kernel::Point_3 to_cgal(const Vec3& p) { return {p[0], p[1], p[2]}; }

}  // namespace

struct LineTree::Impl {
  const Scan* scan = nullptr;
  std::vector<Kernel::Triangle_3> triangles;
  std::vector<std::uint32_t> face;  // of each triangle of the tree
  Tree tree;
};

LineTree::LineTree(const Scan& scan) {
  auto impl = std::make_shared<Impl>();
  impl->scan = &scan;
  for (std::uint32_t f = 0; f < scan.triangles.size(); ++f) {
    const Triangle& t = scan.triangles[f];
    const Kernel::Triangle_3 triangle(to_cgal(scan.positions[t[0]]), to_cgal(scan.positions[t[1]]),
                                      to_cgal(scan.positions[t[2]]));
    if (triangle.is_degenerate()) continue;
    impl->triangles.push_back(triangle);
    impl->face.push_back(f);
  }
  impl->tree.insert(impl->triangles.cbegin(), impl->triangles.cend());
  impl->tree.build();
  impl->tree.accelerate_distance_queries();
  impl_ = std::move(impl);
}

std::vector<LineTree::Hit> LineTree::hits(const Vec3& origin, const Vec3& direction,
                                          double reach) const {
  std::vector<Hit> found;
  if (impl_->triangles.empty()) return found;
  const Vec3 from = origin - reach * direction, to = origin + reach * direction;
  std::vector<Iterator> primitives;
  impl_->tree.all_intersected_primitives(Kernel::Segment_3(to_cgal(from), to_cgal(to)),
                                         std::back_inserter(primitives));
  const Scan& scan = *impl_->scan;
  for (const Iterator it : primitives) {
    const std::uint32_t f = impl_->face[static_cast<std::size_t>(it - impl_->triangles.cbegin())];
    const Triangle& t = scan.triangles[f];
    // [MollerTrumbore1997], with the weights clamped: CGAL has already said that they meet.
    const Vec3 e1 = scan.positions[t[1]] - scan.positions[t[0]];
    const Vec3 e2 = scan.positions[t[2]] - scan.positions[t[0]];
    const Vec3 p = direction.cross(e2);
    const double det = e1.dot(p);
    if (std::abs(det) < 1e-12 * e1.norm() * e2.norm()) continue;  // seen edge-on
    const Vec3 s = origin - scan.positions[t[0]];
    const Vec3 q = s.cross(e1);
    const double u = std::clamp(s.dot(p) / det, 0.0, 1.0);
    const double v = std::clamp(direction.dot(q) / det, 0.0, 1.0 - u);
    found.push_back({e2.dot(q) / det, {f, {1 - u - v, u, v}}});
  }
  std::sort(found.begin(), found.end(), [](const Hit& a, const Hit& b) {
    return std::abs(a.t) != std::abs(b.t) ? std::abs(a.t) < std::abs(b.t)
                                          : a.point.face < b.point.face;
  });
  return found;
}

SurfacePoint LineTree::nearest(const Vec3& query) const {
  if (impl_->triangles.empty()) return {0, {1, 0, 0}};  // no area anywhere: any point will do
  const auto [point, it] = impl_->tree.closest_point_and_primitive(to_cgal(query));
  const std::uint32_t f = impl_->face[static_cast<std::size_t>(it - impl_->triangles.cbegin())];
  const Triangle& t = impl_->scan->triangles[f];
  const Vec3 &a = impl_->scan->positions[t[0]], &b = impl_->scan->positions[t[1]],
             &c = impl_->scan->positions[t[2]];
  const Vec3 p(point.x(), point.y(), point.z()), n = (b - a).cross(c - a);
  const double area2 = n.squaredNorm();
  const double wb = std::clamp((p - a).cross(c - a).dot(n) / area2, 0.0, 1.0);
  const double wc = std::clamp((b - a).cross(p - a).dot(n) / area2, 0.0, 1.0 - wb);
  return {f, {1 - wb - wc, wb, wc}};
}

}  // namespace nacre::remesh
