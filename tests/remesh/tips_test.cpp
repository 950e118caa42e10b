// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/tips.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "remesh/remesh.h"
#include "remesh/split_edges.h"
#include "support/shapes.h"

namespace nacre::remesh {
namespace {

/// A flat grid of cells of size 1 with three triangles over one of its own, up to the given height.
Scan grid_with_tip(double height) {
  Scan scan = shapes::grid(10, 10);
  const Triangle mouth = scan.triangles[100];
  const auto& p = scan.positions;
  const Vec3 middle = (p[mouth[0]] + p[mouth[1]] + p[mouth[2]]) / 3;
  const auto tip = static_cast<std::uint32_t>(scan.positions.size());
  const double edge = (p[mouth[1]] - p[mouth[0]]).norm();
  scan.positions.push_back(middle + Vec3(0, 0, height * edge));
  scan.triangles[100] = {mouth[0], mouth[1], tip};
  scan.triangles.push_back({mouth[1], mouth[2], tip});
  scan.triangles.push_back({mouth[2], mouth[0], tip});
  return scan;
}

TEST(Tips, AreSharpAndLongAndOnNoBoundary) {
  EXPECT_TRUE(tips_of(shapes::grid(10, 10)).empty());  // whose corners have 90 degrees or less
  EXPECT_TRUE(tips_of(grid_with_tip(1)).empty());
  EXPECT_TRUE(tips_of(Scan{}).empty());
  for (const double height : {-6.0, 6.0}) {
    const Scan scan = grid_with_tip(height);
    const auto tip = static_cast<std::uint32_t>(scan.positions.size() - 1);
    EXPECT_EQ(tips_of(scan), std::vector<std::uint32_t>{tip});
    std::size_t at_tip = 0;
    for (const char c : vertices_at_tips(scan)) at_tip += c != 0;
    EXPECT_EQ(at_tip, 4u);
  }
}

TEST(Tips, WallsAreNotSplit) {
  CleanScan cleaned;
  cleaned.scan = grid_with_tip(6);
  cleaned.piece.assign(cleaned.scan.triangles.size(), 0);
  const auto tip = static_cast<std::uint32_t>(cleaned.scan.positions.size() - 1);
  const Triangle wall = cleaned.scan.triangles.back();
  const double mean = side_for_count(cleaned.scan, 100);
  const std::size_t before = cleaned.scan.triangles.size();
  split_long_edges(cleaned, mean / 2);
  EXPECT_GT(cleaned.scan.triangles.size(), before);
  std::size_t walls = 0;
  for (const Triangle& t : cleaned.scan.triangles) walls += std::count(t.begin(), t.end(), tip);
  EXPECT_EQ(walls, 3u);
  EXPECT_EQ(cleaned.scan.triangles[before - 1], wall);
}

}  // namespace
}  // namespace nacre::remesh
