// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
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
  assert(shrink >= 0);
  return dequantize(points, step, tangential_ratio, std::array<double, 3>{shrink, shrink, shrink});
}

std::vector<Vec3> dequantize(std::span<const LatticePoint> points, double step,
                             double tangential_ratio, const std::array<double, 3>& shrinks) {
  const double tangential_step = step * tangential_ratio;
  const auto component = [&](std::int32_t value, double unit) {
    const auto index = static_cast<std::size_t>(std::clamp(std::abs(value), 1, 3) - 1);
    assert(std::abs(shrinks[index]) <= 0.5);
    return dequantize_component(value, unit, shrinks[index]);
  };
  std::vector<Vec3> details;
  details.reserve(points.size());
  for (const LatticePoint& point : points) {
    details.emplace_back(component(point[0], step), component(point[1], tangential_step),
                         component(point[2], tangential_step));
  }
  return details;
}

}  // namespace nacre::quant
