// SPDX-License-Identifier: GPL-3.0-or-later
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Simple_cartesian.h>

#include <algorithm>
#include <boost/iterator/transform_iterator.hpp>
#include <cmath>

#include "remesh/pierce.h"

namespace nacre::remesh {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;

Kernel::Point_3 to_cgal(const Vec3& p) { return {p[0], p[1], p[2]}; }

Kernel::Triangle_3 triangle_of(const Scan& scan, std::uint32_t face) {
  const Triangle& t = scan.triangles[face];
  return {to_cgal(scan.positions[t[0]]), to_cgal(scan.positions[t[1]]),
          to_cgal(scan.positions[t[2]])};
}

/// A triangle by its number: CGAL's own primitives would keep a copy of each, 72 bytes, which is
/// more than all the rest of the tree.
class Primitive {
 public:
  using Id = std::uint32_t;
  using Point = Kernel::Point_3;
  using Datum = Kernel::Triangle_3;
  using Point_reference = Point;
  using Datum_reference = Datum;
  using Shared_data = const Scan*;

  Primitive(std::vector<std::uint32_t>::const_iterator face, const Scan*) : face_(*face) {}
  static Shared_data construct_shared_data(const Scan* scan) { return scan; }
  [[nodiscard]] Id id() const { return face_; }
  [[nodiscard]] Datum datum(const Scan* scan) const { return triangle_of(*scan, face_); }
  [[nodiscard]] Point reference_point(const Scan* scan) const {
    return to_cgal(scan->positions[scan->triangles[face_][0]]);
  }

 private:
  std::uint32_t face_;
};
using Traits = CGAL::AABB_traits<Kernel, Primitive>;
using Tree = CGAL::AABB_tree<Traits>;

/// Lists what a tree holds, in its own order.
struct Lister {
  std::vector<std::uint32_t>& faces;

  [[nodiscard]] static bool go_further() { return true; }
  [[nodiscard]] static bool do_intersect(int, const CGAL::AABB_node<Traits>&) { return true; }
  void intersection(int, const Primitive& primitive) const { faces.push_back(primitive.id()); }
};

/// As CGAL does by itself, where it would hold all points three times meanwhile. `room` is to work
/// in.
void prepare_distances(const Scan& scan, std::vector<std::uint32_t>& room, Tree& tree) {
  room.clear();
  Lister lister{room};
  tree.traversal(0, lister);
  const auto start_of = [&](std::uint32_t face) {
    return Traits::Point_and_primitive_id(to_cgal(scan.positions[scan.triangles[face][0]]), face);
  };
  tree.accelerate_distance_queries(boost::make_transform_iterator(room.cbegin(), start_of),
                                   boost::make_transform_iterator(room.cend(), start_of));
}

}  // namespace

struct LineTree::Impl {
  const Scan* scan = nullptr;
  Tree tree;
};

LineTree::LineTree(const Scan& scan) {
  auto impl = std::make_shared<Impl>();
  impl->scan = &scan;
  std::vector<std::uint32_t> faces;
  faces.reserve(scan.triangles.size());
  for (std::uint32_t f = 0; f < scan.triangles.size(); ++f)
    if (!triangle_of(scan, f).is_degenerate()) faces.push_back(f);
  impl->tree.insert(faces.cbegin(), faces.cend(), &scan);
  impl->tree.build();
  if (!faces.empty()) prepare_distances(scan, faces, impl->tree);
  impl_ = std::move(impl);
}

std::vector<LineTree::Hit> LineTree::hits(const Vec3& origin, const Vec3& direction,
                                          double reach) const {
  std::vector<Hit> found;
  if (impl_->tree.empty()) return found;
  const Vec3 from = origin - reach * direction, to = origin + reach * direction;
  std::vector<std::uint32_t> faces;
  impl_->tree.all_intersected_primitives(Kernel::Segment_3(to_cgal(from), to_cgal(to)),
                                         std::back_inserter(faces));
  const Scan& scan = *impl_->scan;
  for (const std::uint32_t f : faces) {
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
  if (impl_->tree.empty()) return {0, {1, 0, 0}};  // no area anywhere: any point will do
  const auto [point, f] = impl_->tree.closest_point_and_primitive(to_cgal(query));
  return point_below({point.x(), point.y(), point.z()}, f, impl_->scan->triangles,
                     impl_->scan->positions);
}

}  // namespace nacre::remesh
