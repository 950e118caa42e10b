// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/simplify.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <set>

#include "map_checks.h"
#include "remesh/adjacency.h"

namespace nacre::remesh {
namespace {

using testing::facts_of;

Parameterisation simplified(const Scan& scan, int base_vertices) {
  SimplifyOptions options;
  options.base_vertices = base_vertices;
  auto map = simplify(scan, options);
  EXPECT_TRUE(map.has_value());
  return std::move(*map);
}

/// What simplify() ensures for every scan.
void expect_valid(const Scan& scan, const Parameterisation& map) {
  const ManifoldFacts before = facts_of(scan), after = facts_of(map.base);
  ASSERT_EQ(before.defect, "");
  ASSERT_EQ(after.defect, "");
  EXPECT_EQ(after.pieces, before.pieces);
  EXPECT_EQ(after.closed_pieces, before.closed_pieces);
  EXPECT_EQ(after.boundary_loops, before.boundary_loops);
  EXPECT_EQ(after.genus, before.genus);
  EXPECT_EQ(
      map.base.neighbors,
      side_neighbors(map.base.triangles, static_cast<std::uint32_t>(map.base.scan_vertex.size())));

  ASSERT_EQ(map.point.size(), scan.positions.size());
  for (std::size_t v = 0; v < map.point.size(); ++v)
    ASSERT_TRUE(testing::is_valid(map.point[v], map.base.triangles.size())) << "vertex " << v;

  // Base vertices: different scan vertices, each at its own corner.
  const std::set<std::uint32_t> used(map.base.scan_vertex.begin(), map.base.scan_vertex.end());
  EXPECT_EQ(used.size(), map.base.scan_vertex.size());
  for (std::uint32_t b = 0; b < map.base.scan_vertex.size(); ++b) {
    const DomainPoint& p = map.point[map.base.scan_vertex[b]];
    const std::uint32_t c = corner_of(map.base.triangles[p.face], b);
    EXPECT_EQ(map.base.triangles[p.face][c], b);
    EXPECT_EQ(p.weight[c], 1);
  }
}

void expect_boundary_on_boundary(const Scan& scan, const Parameterisation& map) {
  const auto boundary = testing::boundary_vertices(scan);
  std::size_t off = 0;
  for (std::size_t v = 0; v < boundary.size(); ++v)
    off += boundary[v] && !testing::on_base_boundary(map.base, map.point[v]);
  EXPECT_EQ(off, 0u);
}

TEST(Simplify, KeepsTheTopologyAndPlacesEveryVertex) {
  for (const auto& [name, scan] : testing::scans_of_all_kinds()) {
    SCOPED_TRACE(name);
    for (const int size : {4, 40, 200}) {
      const Parameterisation map = simplified(scan, size);
      expect_valid(scan, map);
      expect_boundary_on_boundary(scan, map);
      EXPECT_LE(map.base.scan_vertex.size(), static_cast<std::size_t>(size) + 60);
    }
  }
}

TEST(Simplify, ReachesTheSizeOnASphere) {
  for (const int size : {4, 6, 30, 100, 500}) {
    EXPECT_EQ(simplified(shapes::sphere(4), size).base.scan_vertex.size(),
              static_cast<std::size_t>(size));
  }
}

TEST(Simplify, GoesDownToTheSmallestOfEachKind) {
  EXPECT_EQ(simplified(shapes::sphere(3), 1).base.scan_vertex.size(), 4u);
  EXPECT_EQ(simplified(shapes::grid(6, 6), 1).base.triangles.size(), 1u);
  EXPECT_LE(simplified(shapes::torus(20, 12), 1).base.scan_vertex.size(), 12u);
}

TEST(Simplify, IsOneToOneButForATinyShare) {
  for (const auto& [name, scan] : testing::scans_of_all_kinds()) {
    SCOPED_TRACE(name);
    const auto found = testing::orientation_of(scan, simplified(scan, 50));
    EXPECT_GT(found.same_face, scan.triangles.size() / 4);
    // Only the vertices are mapped: the straight triangle between them can turn over where the
    // composed map bends inside it.
    EXPECT_LE(found.same_turned, found.same_face / 200);
  }
}

TEST(Simplify, StopsWhereTheErrorPassesTheBound) {
  const Scan scan = shapes::bumpy_sphere(4);
  std::size_t last = 0;
  for (const double rms : {0.02, 0.005, 0.001}) {
    SimplifyOptions options;
    options.rms_error = rms;
    const auto map = simplify(scan, options);
    ASSERT_TRUE(map.has_value());
    expect_valid(scan, *map);
    const std::size_t size = map->base.scan_vertex.size();
    EXPECT_GT(size, last);
    EXPECT_LT(size, scan.positions.size());
    last = size;
    // The quadrics' planes say about how far the base is off; within a factor of a few.
    Scan base;
    for (const std::uint32_t v : map->base.scan_vertex) base.positions.push_back(scan.positions[v]);
    base.triangles = map->base.triangles;
    const double diagonal = 2 * std::sqrt(3.0);
    const double found = testing::rms_error(scan, base);
    EXPECT_LT(found, 4 * rms * diagonal);
    EXPECT_GT(found, rms * diagonal / 6);
  }
}

TEST(Simplify, LeavesWhatIsSmallAlone) {
  const Scan triangle = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  const Scan two = {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}};
  const Scan back_to_back = {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
                             {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}}};
  for (const Scan& scan : {triangle, two, back_to_back, shapes::tetrahedron(), shapes::octahedron(),
                           shapes::torus(3, 3), shapes::grid(1, 2)}) {
    for (const int size : {0, 1, 3, 5, 1000}) {
      const Parameterisation map = simplified(scan, size);
      expect_valid(scan, map);
      expect_boundary_on_boundary(scan, map);
    }
  }
  EXPECT_EQ(simplified(triangle, 1).base.triangles.size(), 1u);
  EXPECT_EQ(simplified(shapes::tetrahedron(), 1).base.triangles.size(), 4u);
  // Asked for no less than there is: the scan itself is the base.
  const Scan sphere = shapes::sphere(2);
  EXPECT_EQ(simplified(sphere, 66).base.triangles, sphere.triangles);
}

TEST(Simplify, SurvivesTrianglesWithoutArea) {
  Scan flat = shapes::grid(10, 10);
  for (Vec3& p : flat.positions) p[1] = 0;  // everything on one line
  expect_valid(flat, simplified(flat, 10));
  Scan needles = shapes::torus(30, 8);
  for (Vec3& p : needles.positions) p[2] *= 1e-8;
  expect_valid(needles, simplified(needles, 20));
  Scan point = shapes::sphere(3);
  for (Vec3& p : point.positions) p = {1, 2, 3};
  expect_valid(point, simplified(point, 20));
}

TEST(Simplify, IsDeterministicAndCanBeCancelled) {
  const Scan scan = shapes::bumpy_sphere(4);
  const Parameterisation a = simplified(scan, 80), b = simplified(scan, 80);
  EXPECT_EQ(a.base.triangles, b.base.triangles);
  EXPECT_EQ(a.base.scan_vertex, b.base.scan_vertex);
  for (std::size_t v = 0; v < a.point.size(); ++v) EXPECT_EQ(a.point[v].weight, b.point[v].weight);

  const std::atomic<bool> stop{true};
  RunContext context;
  context.cancel = &stop;
  const auto out = simplify(shapes::sphere(5), {}, {}, context);
  ASSERT_FALSE(out.has_value());
  EXPECT_EQ(out.error().code, ErrorCode::kCancelled);
}

TEST(Simplify, IsTheSameFarFromTheOrigin) {
  const Scan scan = shapes::bumpy_sphere(4);
  Scan far = scan;
  for (Vec3& p : far.positions) p += Vec3(1048576, -2097152, 524288);  // exact to 2^-32
  SimplifyOptions options;
  const auto near_map = simplify(scan, options), far_map = simplify(far, options);
  const auto a = static_cast<double>(near_map->base.scan_vertex.size());
  const auto b = static_cast<double>(far_map->base.scan_vertex.size());
  EXPECT_NEAR(b / a, 1, 0.1);
}

}  // namespace
}  // namespace nacre::remesh
