// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/progress.h"

#include <gtest/gtest.h>

#include <limits>

namespace nacre::app {
namespace {

TEST(ProgressLine, FillsWithTheShareDone) {
  EXPECT_EQ(progress_line("remesh", 0),
            "remesh               [                              ]   0 %");
  EXPECT_EQ(progress_line("remesh", 0.5),
            "remesh               [###############               ]  50 %");
  EXPECT_EQ(progress_line("remesh", 1),
            "remesh               [##############################] 100 %");
}

TEST(ProgressLine, NeverLeavesItsBox) {
  EXPECT_EQ(progress_line("a", -1), progress_line("a", 0));
  EXPECT_EQ(progress_line("a", 2), progress_line("a", 1));
  EXPECT_EQ(progress_line("a", std::numeric_limits<double>::quiet_NaN()), progress_line("a", 0));
}

TEST(Console, HandsTheCancelFlagToStages) {
  std::atomic<bool> cancel{false};
  Console console(Verbosity::kQuiet, cancel);
  const RunContext context = console.context();
  EXPECT_FALSE(context.cancelled());
  cancel = true;
  EXPECT_TRUE(context.cancelled());
  EXPECT_TRUE(console.cancelled());
}

TEST(Console, KeepsWarningsWhenQuiet) {
  const std::atomic<bool> cancel{false};
  testing::internal::CaptureStderr();
  {
    Console console(Verbosity::kQuiet, cancel);
    console.note("a note");
    console.detail("a detail");
    console.warning("a warning");
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "warning: a warning\n");
}

TEST(Console, ShowsDetailsOnlyWhenAsked) {
  const std::atomic<bool> cancel{false};
  testing::internal::CaptureStderr();
  {
    Console normal(Verbosity::kNormal, cancel);
    normal.note("1");
    normal.detail("2");
    Console verbose(Verbosity::kVerbose, cancel);
    verbose.detail("3");
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "1\n3\n");
}

}  // namespace
}  // namespace nacre::app
