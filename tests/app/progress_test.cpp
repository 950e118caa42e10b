// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/progress.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>

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

TEST(ProgressLine, SaysWhatIsLeft) {
  EXPECT_EQ(progress_line("remesh", 0.5, 12),
            "remesh               [###############               ]  50 %  12 s left");
  EXPECT_EQ(format_duration(0.2), "1 s");
  EXPECT_EQ(format_duration(200), "3 min 20 s");
  EXPECT_EQ(format_duration(3900), "1 h 5 min");
  EXPECT_EQ(format_duration(-5), "0 s");
}

TEST(Console, TellsProgressAsJson) {
  const std::atomic<bool> cancel{false};
  testing::internal::CaptureStderr();
  {
    Console console(Verbosity::kQuiet, cancel, ProgressStyle::kJson);
    const RunContext context = console.context();
    context.report("piercing", 0.25);
    context.report("piercing", 0.26);  // too soon
    context.report("compare", 0);
  }
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_TRUE(text.starts_with(R"({"progress": {"stage": "piercing", "fraction": 0.250, )"))
      << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2) << text;
}

TEST(Console, NoProgressWhereNoneIsWanted) {
  const std::atomic<bool> cancel{false};
  Console console(Verbosity::kNormal, cancel, ProgressStyle::kNone);
  EXPECT_FALSE(console.context().progress);
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
