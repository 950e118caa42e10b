// SPDX-License-Identifier: Apache-2.0
#include "wavelet/refine.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string>

#include "wavelet/frames.h"
#include "wavelet/loop.h"

namespace nacre::wavelet {

Refiner::Refiner(const Topology& topology, Transform transform) : topology_(topology) {
  if (transform == Transform::kButterfly) butterfly_.emplace(topology);
}

std::vector<Vec3> Refiner::predict(int level, std::span<const Vec3> coarse) const {
  const std::uint32_t kept = topology_.level(level).vertex_count;
  assert(coarse.size() == kept);
  if (!butterfly_) return loop_subdivide(topology_.level(level), coarse);
  std::vector<Vec3> predicted(topology_.level(level + 1).vertex_count);
  std::copy(coarse.begin(), coarse.end(), predicted.begin());
  butterfly_->predict(level, coarse, std::span(predicted).subspan(kept));
  return predicted;
}

std::vector<Vec3> displace(const LevelTopology& level, std::span<const Vec3> predicted,
                           std::span<const Vec3> details) {
  assert(predicted.size() == level.vertex_count + details.size());
  std::vector<Vec3> positions(predicted.begin(), predicted.end());
  for (std::uint32_t e = 0; e < details.size(); ++e) {
    const Vec3& d = details[e];
    if (d[0] == 0 && d[1] == 0 && d[2] == 0) continue;
    Vec3& p = positions[level.vertex_count + e];
    const Vec3 normal = midpoint_normal(level, predicted, e);
    p += normal * d[0];
    if (d[1] == 0 && d[2] == 0) continue;
    const Frame frame = frame_of(normal, edge_vector(level, predicted, e));
    p += frame.tangent1 * d[1];
    p += frame.tangent2 * d[2];
  }
  return positions;
}

Result<void> check_finite(std::span<const Vec3> positions) {
  for (std::size_t v = 0; v < positions.size(); ++v) {
    const Vec3& p = positions[v];
    if (std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2])) continue;
    return Error{ErrorCode::kBadInput,
                 "vertex " + std::to_string(v) + " has a coordinate that is not finite", v};
  }
  return {};
}

}  // namespace nacre::wavelet
