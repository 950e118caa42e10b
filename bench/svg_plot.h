// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <utility>
#include <vector>

/// Line plots as SVG text.
namespace nacre::bench {

struct Series {
  std::string name;
  std::vector<std::pair<double, double>> points;
  bool has_line = true, has_markers = true;
};

struct Plot {
  std::string title, x_label, y_label;
  bool x_is_log = false, y_is_log = false;  ///< then values are > 0
  std::vector<Series> series;
};

/// A picture of 720 by 480 with axes, grid and legend. Series without points are left out.
[[nodiscard]] std::string to_svg(const Plot& plot);

}  // namespace nacre::bench
