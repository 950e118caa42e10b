// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/svg_plot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

namespace nacre::bench {
namespace {

std::size_t count_of(const std::string& text, const std::string& what) {
  std::size_t count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1))
    ++count;
  return count;
}

/// The numbers after each occurrence of a key such as cx='.
std::vector<double> values_of(const std::string& text, const std::string& key) {
  std::vector<double> out;
  for (std::size_t at = text.find(key); at != std::string::npos; at = text.find(key, at + 1))
    out.push_back(std::strtod(text.c_str() + at + key.size(), nullptr));
  return out;
}

TEST(SvgPlot, DrawsEveryPointInsideTheFrame) {
  const Plot plot{"a < b & c",
                  "x",
                  "y",
                  true,
                  false,
                  {{"one", {{1000, 60}, {2000, 65}, {4000, 70}}, true, true},
                   {"none", {}, true, true},
                   {"two", {{1000, 50}, {64000, 90}}, true, false}}};
  const std::string svg = to_svg(plot);
  EXPECT_EQ(count_of(svg, "<circle"), 3u);
  EXPECT_EQ(count_of(svg, "<path"), 2u);
  EXPECT_EQ(count_of(svg, ">none<"), 0u);
  EXPECT_EQ(count_of(svg, "a &lt; b &amp; c"), 1u);
  const std::vector<double> x = values_of(svg, "cx='"), y = values_of(svg, "cy='");
  ASSERT_EQ(x.size(), 3u);
  // Equal factors are equal distances; more dB is further up.
  EXPECT_NEAR(x[1] - x[0], x[2] - x[1], 0.02);
  EXPECT_NEAR(y[0] - y[1], y[1] - y[2], 0.02);
  EXPECT_GT(y[0], y[1]);
  for (const double v : x) EXPECT_TRUE(v > 0 && v < 720);
  for (const double v : y) EXPECT_TRUE(v > 0 && v < 480);
}

TEST(SvgPlot, OnePointOrNoneIsAPictureToo) {
  EXPECT_NE(to_svg({"", "", "", false, false, {}}).find("</svg>"), std::string::npos);
  const std::string svg = to_svg({"", "", "", false, true, {{"p", {{3, 7}}, true, true}}});
  EXPECT_EQ(count_of(svg, "<circle"), 1u);
  EXPECT_EQ(count_of(svg, "nan"), 0u);
  EXPECT_EQ(count_of(svg, "inf"), 0u);
}

}  // namespace
}  // namespace nacre::bench
