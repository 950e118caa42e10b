// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/split_edges.h"

#include <gtest/gtest.h>

#include "map_checks.h"
#include "remesh/adjacency.h"

namespace nacre::remesh {
namespace {

double longest_edge(const Scan& scan) {
  double longest = 0;
  for (const Triangle& t : scan.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      longest = std::max(longest, (scan.positions[t[k]] - scan.positions[t[(k + 1) % 3]]).norm());
  return longest;
}

double area(const Scan& scan) {
  double sum = 0;
  for (const Triangle& t : scan.triangles)
    sum += (scan.positions[t[1]] - scan.positions[t[0]])
               .cross(scan.positions[t[2]] - scan.positions[t[0]])
               .norm() /
           2;
  return sum;
}

TEST(SplitLongEdges, KeepsTheSurface) {
  for (const Scan& scan : {shapes::tetrahedron(), shapes::torus(9, 7), shapes::holed_grid(6, 2, 4),
                           shapes::plate(2), shapes::bumpy_sphere(2)}) {
    const double bound = longest_edge(scan) / 5;
    CleanScan cleaned = *clean(scan);
    const Scan before_split = cleaned.scan;
    split_long_edges(cleaned, bound);
    const Scan& fine = cleaned.scan;
    ASSERT_EQ(cleaned.piece.size(), fine.triangles.size());
    EXPECT_LE(longest_edge(fine), bound);
    EXPECT_NEAR(area(fine), area(scan), 1e-9 * area(scan));
    const ManifoldFacts before = testing::facts_of(scan), after = testing::facts_of(fine);
    ASSERT_EQ(after.defect, "");
    EXPECT_EQ(after.pieces, before.pieces);
    EXPECT_EQ(after.boundary_loops, before.boundary_loops);
    EXPECT_EQ(after.genus, before.genus);
    for (std::size_t v = 0; v < before_split.positions.size(); ++v)
      EXPECT_EQ(fine.positions[v], before_split.positions[v]);
    EXPECT_LT(fine.triangles.size(), 200 * scan.triangles.size());
  }
}

TEST(SplitLongEdges, LeavesShortEdgesAlone) {
  CleanScan cleaned = *clean(shapes::sphere(3));
  const auto triangles = cleaned.scan.triangles;
  split_long_edges(cleaned, longest_edge(cleaned.scan));
  EXPECT_EQ(cleaned.scan.triangles, triangles);
}

TEST(SplitLongEdges, GivesNewTrianglesTheirPiece) {
  CleanScan cleaned =
      *clean(shapes::joined(shapes::tetrahedron(), shapes::moved(shapes::grid(2, 2), {9, 9, 9})));
  split_long_edges(cleaned, 0.3);
  for (std::size_t f = 0; f < cleaned.scan.triangles.size(); ++f)
    EXPECT_EQ(cleaned.piece[f],
              cleaned.scan.positions[cleaned.scan.triangles[f][0]][0] > 5 ? 1u : 0u);
}

TEST(SplitLongEdges, StopsPastTheMostTriangles) {
  CleanScan cleaned = *clean(shapes::sphere(2));
  split_long_edges(cleaned, 1e-6, 5000);
  EXPECT_GE(cleaned.scan.triangles.size(), 5000u);
  EXPECT_LE(cleaned.scan.triangles.size(), 10'000u);
  EXPECT_EQ(testing::facts_of(cleaned.scan).defect, "");
}

TEST(SideForCount, CoversTheScan) {
  const Scan scan = shapes::grid(10, 10);
  const double side = side_for_count(scan, 400);
  EXPECT_NEAR(400 * std::sqrt(3.0) / 4 * side * side, 100, 1e-9);
}

TEST(SideForCount, KeepsNeedlesFromBeingCutToDust) {
  Scan scan = shapes::grid(30, 3);
  for (Vec3& p : scan.positions) p[0] *= 1e-9;
  EXPECT_NEAR(side_for_count(scan, 20'000), 3e-3, 1e-9);
  for (Vec3& p : scan.positions) p[0] = 0;
  EXPECT_EQ(side_for_count(scan, 20'000), 0);
}

/// Inner edges whose two ends are on the boundary.
std::size_t chords(const Scan& scan) {
  const auto neighbors =
      side_neighbors(scan.triangles, static_cast<std::uint32_t>(scan.positions.size()));
  std::vector<char> on_boundary(scan.positions.size(), 0);
  for (std::size_t f = 0; f < scan.triangles.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k)
      if (neighbors[f][k] == kNone)
        on_boundary[scan.triangles[f][k]] = on_boundary[scan.triangles[f][(k + 1) % 3]] = 1;
  std::size_t count = 0;
  for (std::size_t f = 0; f < scan.triangles.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k)
      count += neighbors[f][k] != kNone && on_boundary[scan.triangles[f][k]] &&
               on_boundary[scan.triangles[f][(k + 1) % 3]];
  return count / 2;
}

TEST(SplitChords, LeavesNoneAndKeepsTheSurface) {
  std::size_t met = 0;
  for (const Scan& scan : {shapes::grid(1, 1), shapes::grid(1, 9), shapes::grid(5, 4),
                           shapes::holed_grid(6, 2, 4), shapes::torus(9, 7)}) {
    CleanScan cleaned = *clean(scan);
    const std::size_t before = chords(cleaned.scan);
    const std::size_t vertices = cleaned.scan.positions.size();
    met += before;
    split_chords(cleaned);
    EXPECT_EQ(chords(cleaned.scan), 0u);
    EXPECT_GE(cleaned.scan.positions.size(), vertices + before);
    EXPECT_EQ(cleaned.piece.size(), cleaned.scan.triangles.size());
    EXPECT_NEAR(area(cleaned.scan), area(scan), 1e-12 * area(scan));
    const ManifoldFacts a = testing::facts_of(scan), b = testing::facts_of(cleaned.scan);
    ASSERT_EQ(b.defect, "");
    EXPECT_EQ(b.boundary_loops, a.boundary_loops);
    EXPECT_EQ(b.genus, a.genus);
  }
  EXPECT_GT(met, 10u);
}

}  // namespace
}  // namespace nacre::remesh
