// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/batch/glob.h"

#include <gtest/gtest.h>

#include <string>

namespace nacre::app::batch {
namespace {

TEST(Glob, OnePartMatchesTheFileNameAtAnyDepth) {
  EXPECT_TRUE(glob_match("*.ply", "a.ply"));
  EXPECT_TRUE(glob_match("*.ply", "x/y/a.ply"));
  EXPECT_TRUE(glob_match("part?.stl", "x/part7.stl"));
  EXPECT_FALSE(glob_match("part?.stl", "x/part17.stl"));
  EXPECT_FALSE(glob_match("*.ply", "a.ply.obj"));
  EXPECT_FALSE(glob_match("x", "x/a.ply"));
}

TEST(Glob, StarsStayWithinAPartAndTwoDoNot) {
  EXPECT_TRUE(glob_match("busts/*.ply", "busts/a.ply"));
  EXPECT_FALSE(glob_match("busts/*.ply", "busts/old/a.ply"));
  EXPECT_TRUE(glob_match("busts/**", "busts/old/a.ply"));
  EXPECT_TRUE(glob_match("busts/**/*.ply", "busts/a.ply"));
  EXPECT_TRUE(glob_match("busts/**/*.ply", "busts/x/y/a.ply"));
  EXPECT_TRUE(glob_match("**/old/*", "a/b/old/c"));
  EXPECT_FALSE(glob_match("**/old/*", "a/older/c"));
  EXPECT_FALSE(glob_match("busts/**", "other/busts/a.ply"));
  EXPECT_TRUE(glob_match("**", "a/b"));
}

TEST(Glob, HostilePatternsEnd) {
  const std::string text(2000, 'a');
  std::string pattern;
  for (int i = 0; i < 500; ++i) pattern += "*a";
  EXPECT_TRUE(glob_match(pattern, text));
  EXPECT_FALSE(glob_match(pattern + "b", text));
  EXPECT_FALSE(glob_match("", "a"));
}

}  // namespace
}  // namespace nacre::app::batch
