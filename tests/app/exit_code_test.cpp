// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/exit_code.h"

#include <gtest/gtest.h>

#include "app/files.h"

namespace nacre::app {
namespace {

// The numbers are a promise to scripts: written out here, not taken from the enumerators.
TEST(ExitCode, IsThePublishedTable) {
  EXPECT_EQ(exit_code(ErrorCode::kBadInput), 2);
  EXPECT_EQ(exit_code(ErrorCode::kUnreadableFile), 3);
  EXPECT_EQ(exit_code(ErrorCode::kGeometryRefused), 4);
  EXPECT_EQ(exit_code(ErrorCode::kGoalUnreachable), 5);
  EXPECT_EQ(exit_code(ErrorCode::kLimitExceeded), 6);
  EXPECT_EQ(exit_code(ErrorCode::kCorruptStream), 7);
  EXPECT_EQ(exit_code(ErrorCode::kUnsupportedVersion), 7);
  EXPECT_EQ(exit_code(ErrorCode::kCancelled), 75);
  EXPECT_EQ(exit_code(ErrorCode::kCannotWrite), 1);
  EXPECT_EQ(exit_code(ErrorCode::kNoConvergence), 1);
}

TEST(ExitCode, DependsOnWhereTheErrorArose) {
  const Error limit{ErrorCode::kLimitExceeded, "too many vertices"};
  EXPECT_EQ(exit_code(in_file(limit, "out.glb").code), 6);
  EXPECT_EQ(exit_code(stream_error(limit, "in.ncr").code), 7);
  const Error bad{ErrorCode::kBadInput, "no triangle of positive area"};
  EXPECT_EQ(exit_code(in_file(bad, "a").code), 2);
  EXPECT_EQ(exit_code(surface_error(bad, "a.ply").code), 4);
  EXPECT_EQ(exit_code(stream_error(bad, "a.ncr").code), 7);
  EXPECT_EQ(exit_code(stream_error({ErrorCode::kUnsupportedVersion, "too new"}, "a.ncr").code), 7);
}

}  // namespace
}  // namespace nacre::app
