// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

#include "quant/quant.h"

namespace nacre::quant {
namespace {

// atan(hypot(t1, t2) / |z|) < Θ without a transcendental per vector: squares against tan² Θ.
double squared_tangent_limit(double theta_rad) {
  if (theta_rad <= 0) return 0;
  if (theta_rad >= std::numbers::pi / 2) return std::numeric_limits<double>::infinity();
  const double tangent = std::tan(theta_rad);
  return tangent * tangent;
}

bool inside_cone(const Vec3& detail, double squared_tangent) {
  if (std::isinf(squared_tangent)) return true;
  return detail[1] * detail[1] + detail[2] * detail[2] < squared_tangent * (detail[0] * detail[0]);
}

std::int32_t quantize_component(double value, double step, double dead_zone) {
  const double magnitude = std::abs(value) / step;
  if (!(magnitude >= dead_zone)) return 0;  // not a number ends here, too
  // floor(x + 0.5) would round the sum; this comparison is exact.
  double index = std::floor(std::min(magnitude, double{kMaxComponent}));
  if (magnitude - index >= 0.5) index += 1;
  index = std::clamp(index, 1.0, double{kMaxComponent});
  return static_cast<std::int32_t>(value < 0 ? -index : index);
}

}  // namespace

std::vector<LatticePoint> quantize(std::span<const Vec3> details, const QuantizerOptions& options) {
  assert(options.step > 0 && options.tangential_ratio >= 1);
  assert(options.dead_zone >= 0.5 && options.dead_zone < 1);
  const double squared_tangent = squared_tangent_limit(options.theta_rad);
  const double tangential_step = options.step * options.tangential_ratio;
  std::vector<LatticePoint> points;
  points.reserve(details.size());
  for (const Vec3& detail : details) {
    LatticePoint point = {quantize_component(detail[0], options.step, options.dead_zone), 0, 0};
    if (!inside_cone(detail, squared_tangent)) {  // [LVQ] 3.2, steps 1 to 3
      point[1] = quantize_component(detail[1], tangential_step, options.dead_zone);
      point[2] = quantize_component(detail[2], tangential_step, options.dead_zone);
    }
    points.push_back(point);
  }
  return points;
}

}  // namespace nacre::quant
