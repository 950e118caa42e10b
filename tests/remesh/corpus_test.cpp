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

}  // namespace
}  // namespace nacre::remesh
