// SPDX-License-Identifier: Apache-2.0
#include <cassert>
#include <cstdlib>

#include "quant/quant.h"

namespace nacre::quant {
namespace {

// The order of these operations is part of the format.
double dequantize_component(std::int32_t component, double step, double shrink) {
  if (component == 0) return 0.0;
  const double magnitude = (static_cast<double>(std::abs(component)) - shrink) * step;
  return component < 0 ? -magnitude : magnitude;
}

}  // namespace

std::vector<Vec3> dequantize(std::span<const LatticePoint> points, double step,
                             double tangential_ratio, double shrink) {
  assert(shrink >= 0 && shrink <= 0.5);
  const double tangential_step = step * tangential_ratio;
  std::vector<Vec3> details;
  details.reserve(points.size());
  for (const LatticePoint& point : points) {
    details.emplace_back(dequantize_component(point[0], step, shrink),
                         dequantize_component(point[1], tangential_step, shrink),
                         dequantize_component(point[2], tangential_step, shrink));
  }
  return details;
}

}  // namespace nacre::quant
