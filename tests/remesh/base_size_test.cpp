// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/base_size.h"

#include <gtest/gtest.h>

#include <cmath>

namespace nacre::remesh {
namespace {

TEST(BaseSize, ABaseThatComesCloseEnoughStays) {
  EXPECT_EQ(denser_base(480, 100'000, 7.8e-5), 0);
  EXPECT_EQ(denser_base(480, 100'000, 0), 0);
  EXPECT_EQ(denser_base(480, 100'000, std::nan("")), 0);
}

TEST(BaseSize, ADenserBaseBringsTheErrorToTheUsualOne) {
  const int denser = denser_base(480, 100'000, 1.1e-4);
  EXPECT_NEAR(1.1e-4 * std::pow(480.0 / denser, 0.66), 5.5e-5, 1e-7);
}

TEST(BaseSize, ADenserBaseHasAtMostAFifthOfTheScansVertices) {
  EXPECT_EQ(denser_base(480, 4'000, 1), 800);
  // Hardly more is not worth the while.
  EXPECT_EQ(denser_base(480, 3'000, 1), 0);
}

TEST(BaseSize, PiecesHolesAndHandlesAskForMoreThanShapesDo) {
  std::vector<PieceReport> pieces(1);
  EXPECT_EQ(base_size({}, pieces, 1'000'000).least, 480);
  EXPECT_EQ(base_size({}, pieces, 5'000).least, 200);
  pieces[0].genus = 20;
  pieces[0].boundary_loops = 2;
  EXPECT_EQ(base_size({}, pieces, 1'000'000).least, 20 * (4 + 3 * 2 + 4 * 20));
}

TEST(BaseSize, LevelsGiveTheTrianglesThatAreAskedForOrThatTheScanNeeds) {
  // 1000 * 4^4 < 320,000, the least; 4^5 for what is asked for; no more than 16 for each one.
  EXPECT_EQ(default_levels(10'000, 1'000, 0), 5);
  EXPECT_EQ(default_levels(10'000, 1'000, 1), 4);
  EXPECT_EQ(default_levels(100'000, 1'000, 1'000'000), 5);
  EXPECT_EQ(default_levels(100'000, 1'000, 1'100'000), 6);
  EXPECT_EQ(default_levels(10'000, 1'000, 100'000'000), 4);
}

}  // namespace
}  // namespace nacre::remesh
