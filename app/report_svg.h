// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

/// Plots as SVG for a page: no script, colours from the page's style sheet.
namespace nacre::app {

struct Series {
  std::vector<std::array<double, 2>> points;  ///< x, y; those that are not finite are left out
  bool line = true, dots = false;
  std::string css_class;  ///< of the page: "c1" .. "c4", "chosen"
  std::string name;       ///< for the legend; empty: none
};

struct Axis {
  std::string label;
  bool logarithmic = false;  ///< values must be positive; others are left out
};

struct Plot {
  std::string title;  ///< read aloud, and shown when pointed at
  Axis x, y;
  std::vector<Series> series;
  int width = 640, height = 320;
};

/// One <svg> element; without any point, a paragraph that says so.
[[nodiscard]] std::string svg(const Plot& plot);

/// Round numbers that cover [low, high], about `count` of them: 1, 2 or 5 times a power of ten
/// apart; on a logarithmic axis those numbers themselves.
[[nodiscard]] std::vector<double> ticks(double low, double high, int count, bool logarithmic);

/// Text for HTML: & < > " and ' replaced, control characters and broken UTF-8 too.
[[nodiscard]] std::string escaped(std::string_view text);

}  // namespace nacre::app
