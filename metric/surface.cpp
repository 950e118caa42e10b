// SPDX-License-Identifier: GPL-3.0-or-later
// CGAL's tree, walked with our own traversal: the library's closest-point traversal goes left
// before right and tests boxes through Sphere_3 objects; visiting the nearer child first with plain
// box distances answers the same query several times sooner (README.md has the figures).
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Simple_cartesian.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <utility>

#include "base/parallel.h"
#include "metric/beside.h"
#include "metric/metric.h"
#include "metric/triangle.h"

namespace nacre::metric {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;

constexpr double kLargestCoordinate = 1e75;  // its fourth power, met in squared areas, is finite
constexpr std::size_t kQueriesPerBlock = 2048;

/// Carries its corners, so that the tree's own order of the primitives is also their memory order.
struct TriangleInTree {
  using Id = std::uint32_t;
  using Point = Kernel::Point_3;
  using Datum = Kernel::Triangle_3;
  using Point_reference = Point;
  using Datum_reference = Datum;

  std::array<Vec3, 3> corner;
  Id triangle = kNone;

  [[nodiscard]] Id id() const { return triangle; }
  [[nodiscard]] Datum datum() const {
    const auto point = [](const Vec3& p) { return Point(p[0], p[1], p[2]); };
    return {point(corner[0]), point(corner[1]), point(corner[2])};
  }
  [[nodiscard]] Point reference_point() const {
    const Vec3 sum = corner[0] + corner[1] + corner[2];
    return {sum[0] / 3, sum[1] / 3, sum[2] / 3};
  }
};

using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, TriangleInTree>>;

double squared_distance(const Vec3& p, const CGAL::Bbox_3& box) {
  const double x = std::max({box.xmin() - p[0], 0.0, p[0] - box.xmax()});
  const double y = std::max({box.ymin() - p[1], 0.0, p[1] - box.ymax()});
  const double z = std::max({box.zmin() - p[2], 0.0, p[2] - box.zmax()});
  return (x * x + y * y) + z * z;
}

/// What CGAL's traversal_with_priority asks for; nearer boxes have the higher priority.
struct NearestTraversal {
  using Priority = double;

  double best2 = std::numeric_limits<double>::infinity();
  Vec3 point = Vec3::Zero();
  std::uint32_t triangle = kNone;

  static bool go_further() { return true; }
  void intersection(const Vec3& query, const TriangleInTree& t) {
    const Vec3 q = closest_on_triangle(query, t.corner[0], t.corner[1], t.corner[2]);
    const Vec3 away = query - q;
    const double d2 = dot(away, away);
    if (!(d2 < best2)) return;
    best2 = d2;
    point = q;
    triangle = t.triangle;
  }
  template <class Node>
  bool do_intersect(const Vec3& query, const Node& node) const {
    return squared_distance(query, node.bbox()) < best2;
  }
  template <class Node>
  std::pair<bool, Priority> do_intersect_with_priority(const Vec3& query, const Node& node) const {
    const double d2 = squared_distance(query, node.bbox());
    return {d2 < best2, -d2};
  }
};

}  // namespace

Result<void> check_surface(const Scan& scan) {
  for (std::size_t v = 0; v < scan.positions.size(); ++v) {
    if (!(scan.positions[v].array().abs() <= kLargestCoordinate).all())
      return Error{ErrorCode::kBadInput, "vertex coordinate is not a finite number below 1e75", v};
  }
  for (std::size_t f = 0; f < scan.triangles.size(); ++f) {
    for (const std::uint32_t v : scan.triangles[f])
      if (v >= scan.positions.size())
        return Error{ErrorCode::kBadInput, "triangle names a vertex that does not exist", f};
  }
  const auto has_area = [&](const Triangle& t) {
    return twice_area(scan.positions[t[0]], scan.positions[t[1]], scan.positions[t[2]]) > 0;
  };
  if (std::none_of(scan.triangles.begin(), scan.triangles.end(), has_area))
    return Error{ErrorCode::kBadInput, "no triangle with an area: there is no surface to measure"};
  return {};
}

struct Surface::Impl {
  Tree tree;
  double bbox_diagonal = 0;
};

Result<Surface> Surface::build(const Scan& scan) try {
  if (const Result<void> checked = check_surface(scan); !checked) return checked.error();
  auto impl = std::make_shared<Impl>();
  CGAL::Bbox_3 box;
  for (std::size_t f = 0; f < scan.triangles.size(); ++f) {
    const Triangle& t = scan.triangles[f];
    TriangleInTree added;
    for (std::size_t k = 0; k < 3; ++k) added.corner[k] = scan.positions[t[k]];
    added.triangle = static_cast<std::uint32_t>(f);
    const auto& [a, b, c] = added.corner;
    if (!(twice_area(a, b, c) > 0)) continue;
    box += added.datum().bbox();
    impl->tree.insert(added);
  }
  impl->tree.do_not_accelerate_distance_queries();
  impl->tree.build();
  impl->bbox_diagonal =
      norm({box.xmax() - box.xmin(), box.ymax() - box.ymin(), box.zmax() - box.zmin()});
  Surface surface;
  surface.impl_ = std::move(impl);
  return surface;
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::kLimitExceeded, "not enough memory to index the surface"};
}

Surface::Nearest Surface::nearest(const Vec3& query) const { return nearest(query, {}); }

Surface::Nearest Surface::nearest(const Vec3& query, const Nearest& nearby) const {
  NearestTraversal search;
  if (!query.allFinite()) return {query, kNone, search.best2};
  if (nearby.triangle != kNone) {
    search.best2 = dot(query - nearby.point, query - nearby.point);
    search.point = nearby.point;
    search.triangle = nearby.triangle;
  }
  impl_->tree.traversal_with_priority(query, search);
  return {search.point, search.triangle, std::sqrt(search.best2)};
}

std::vector<double> Surface::distances(std::span<const Vec3> queries) const {
  std::vector<double> result(queries.size());
  const std::size_t blocks = (queries.size() + kQueriesPerBlock - 1) / kQueriesPerBlock;
  parallel_for_each_index(
      blocks,
      [&](std::size_t b) {
        Nearest last;
        const std::size_t end = std::min(queries.size(), (b + 1) * kQueriesPerBlock);
        for (std::size_t i = b * kQueriesPerBlock; i < end; ++i) {
          last = nearest(queries[i], last);
          result[i] = last.distance;
        }
      },
      1);
  return result;
}

double Surface::bbox_diagonal() const { return impl_->bbox_diagonal; }

}  // namespace nacre::metric
