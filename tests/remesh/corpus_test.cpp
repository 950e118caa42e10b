// SPDX-License-Identifier: GPL-3.0-or-later
#include "support/corpus.h"

#include <gtest/gtest.h>

#include "io/io.h"
#include "remesh_checks.h"

namespace nacre::remesh {
namespace {

class RealScan : public ::testing::TestWithParam<const char*> {};

TEST_P(RealScan, ComesOutHealthy) {
  NACRE_SKIP_WITHOUT(GetParam());
  const auto scan = io::read_scan(corpus::mesh(GetParam()));
  ASSERT_TRUE(scan.has_value());
  const auto out = remesh(scan->scan, testing::options_of(0, 3));
  ASSERT_TRUE(out.has_value()) << out.error().message;
  testing::expect_healthy(*out);
  EXPECT_LT(testing::final_error(scan->scan, *out),
            0.01 * metric::Surface::build(scan->scan)->bbox_diagonal());
}

INSTANTIATE_TEST_SUITE_P(Small, RealScan,
                         ::testing::Values("bunny_res3.ply", "drill_shaft.ply", "conrod.stl",
                                           "fandisk.obj"));

/// One of its vertices is at the end of a pit five edges deep, with three triangles for walls.
TEST(Remesh, ElephantHasNoFoldedTriangles) {
  NACRE_SKIP_WITHOUT("elephant.off");
  const auto scan = io::read_scan(corpus::mesh("elephant.off"));
  ASSERT_TRUE(scan.has_value());
  const auto out = remesh(scan->scan, testing::options_of(0, 0));
  ASSERT_TRUE(out.has_value()) << out.error().message;
  testing::expect_healthy(*out);
  for (const BandReport& band : out->bands) {
    EXPECT_EQ(band.folded_triangles, 0u);
    EXPECT_GE(static_cast<double>(band.normal_only), 0.995 * static_cast<double>(band.vertices));
  }
}

/// Slow because each needle must be cut along its length.
TEST(Remesh, NeedlesComeOutOrAreRefused) {
  Scan scan = shapes::grid(30, 3);
  for (Vec3& p : scan.positions) p[0] *= 1e-9;
  const auto out = remesh(scan, testing::options_of(20, 2));
  if (out) {
    testing::expect_healthy(*out);
  } else {
    EXPECT_EQ(out.error().code, ErrorCode::kGeometryRefused);
  }
}

}  // namespace
}  // namespace nacre::remesh
