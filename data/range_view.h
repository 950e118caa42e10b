// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "data/random.h"
#include "data/simulate.h"

namespace nacre::data {

struct Ball {
  Vec3 center;
  double radius;
};

/// An orthographic range image, and the pose that the merging software believes it was taken from.
struct RangeView {
  Vec3 right, up, toward;
  double pixel_size = 0;  ///< target units
  int pixels = 0;         ///< width and height
  std::vector<float>
      height;  ///< along `toward`, row by row; not a number where nothing was measured
  std::vector<float> facing;  ///< cosine between surface and line of sight, 0 .. 1

  struct Sample {
    double height, facing;
  };
  /// Interpolated; false at the edge of what was measured.
  [[nodiscard]] bool sample(const Vec3& p, Sample& out) const;
};

/// Takes all views. `dark` balls hide the surface from all of them.
[[nodiscard]] std::vector<RangeView> scan_views(const Target& target,
                                                const SimulationOptions& options);

}  // namespace nacre::data
