// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/collapse_edges.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "map_checks.h"

namespace nacre::remesh {
namespace {

using namespace shapes;
using testing::facts_of;

CleanScan cleaned(const Scan& scan) {
  auto out = clean(scan, RepairPolicy::kSafe, 0);
  EXPECT_TRUE(out.has_value());
  return std::move(*out);
}

void expect_same_topology(const Scan& before, const Scan& after) {
  const ManifoldFacts was = facts_of(before), is = facts_of(after);
  EXPECT_EQ(is.defect, "");
  EXPECT_EQ(is.pieces, was.pieces);
  EXPECT_EQ(is.boundary_loops, was.boundary_loops);
  EXPECT_EQ(is.genus, was.genus);
}

TEST(CollapseEdges, KeepsPiecesGenusAndLoops) {
  for (const auto& [name, scan] : testing::scans_of_all_kinds()) {
    SCOPED_TRACE(name);
    const CleanScan before = cleaned(scan);
    for (const int vertices : {4, 40, 200}) {
      const auto after = collapse_edges(before, vertices, {});
      ASSERT_TRUE(after.has_value()) << after.error().message;
      expect_same_topology(before.scan, after->scan);
      EXPECT_LE(after->scan.positions.size(), static_cast<std::size_t>(vertices) + 60);
      ASSERT_EQ(after->piece.size(), after->scan.triangles.size());
    }
  }
}

TEST(CollapseEdges, TrianglesStayInTheirPiece) {
  const Scan near = sphere(4);
  const CleanScan before = cleaned(joined(near, moved(near, {5, 0, 0})));
  const auto after = collapse_edges(before, 200, {});
  ASSERT_TRUE(after.has_value());
  ASSERT_EQ(before.pieces.size(), 2u);
  const std::uint32_t left = before.scan.positions[before.scan.triangles[0][0]][0] < 2.5
                                 ? before.piece[0]
                                 : 1 - before.piece[0];
  for (std::size_t f = 0; f < after->piece.size(); ++f) {
    const Vec3& corner = after->scan.positions[after->scan.triangles[f][0]];
    EXPECT_EQ(after->piece[f] == left, corner[0] < 2.5) << f;
  }
}

TEST(CollapseEdges, VerticesGoWhereTheyServeTheSurfaceBest) {
  // Inscribed in a sphere, a mesh has too little volume; Lindstrom and Turk keep it.
  const Scan ball = sphere(5);
  const auto after = collapse_edges(cleaned(ball), 150, {});
  ASSERT_TRUE(after.has_value());
  EXPECT_LT(after->scan.positions.size(), 160u);
  EXPECT_NEAR(volume(after->scan) / volume(ball), 1, 0.002);
}

TEST(CollapseEdgesQuickly, KeepsTopologyAndPieces) {
  for (const auto& [name, scan] : testing::scans_of_all_kinds()) {
    SCOPED_TRACE(name);
    const CleanScan before = cleaned(scan);
    const auto after = collapse_edges_quickly(before, 20, {});
    ASSERT_TRUE(after.has_value()) << after.error().message;
    expect_same_topology(before.scan, after->scan);
    ASSERT_EQ(after->piece.size(), after->scan.triangles.size());
    for (std::size_t f = 0; f < after->piece.size(); ++f)
      ASSERT_LT(after->piece[f], before.pieces.size());
  }
}

TEST(CollapseEdgesQuickly, IsNearlyAsGood) {
  const Scan ball = sphere(6);
  const auto well = collapse_edges(cleaned(ball), 150, {});
  const auto quickly = collapse_edges_quickly(cleaned(ball), 150, {});
  ASSERT_TRUE(well.has_value() && quickly.has_value());
  EXPECT_NE(well->scan.positions, quickly->scan.positions);
  EXPECT_EQ(well->scan.positions.size(), quickly->scan.positions.size());
  EXPECT_NEAR(volume(quickly->scan) / volume(ball), 1, 0.02);
}

TEST(CollapseEdges, StopsWhenCancelled) {
  const std::atomic<bool> cancel{true};
  RunContext context;
  context.cancel = &cancel;
  const auto after = collapse_edges(cleaned(sphere(4)), 50, context);
  ASSERT_FALSE(after.has_value());
  EXPECT_EQ(after.error().code, ErrorCode::kCancelled);
}

}  // namespace
}  // namespace nacre::remesh
