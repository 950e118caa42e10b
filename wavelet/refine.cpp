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

void Refiner::refine(int level, std::vector<Vec3>& positions) const {
  if (!butterfly_) {
    positions = loop_subdivide(topology_.level(level), positions);
    return;
  }
  const std::uint32_t kept = topology_.level(level).vertex_count;
  positions.resize(topology_.level(level + 1).vertex_count);
  butterfly_->predict(level, std::span<const Vec3>(positions).first(kept),
                      std::span(positions).subspan(kept));
}

namespace {

/// Midpoint e with its detail.
Vec3 displaced(const LevelTopology& level, std::span<const Vec3> predicted, std::uint32_t e,
               const Vec3& d) {
  const Vec3 normal = midpoint_normal(level, predicted, e);
  Vec3 p = predicted[level.vertex_count + e];
  p += normal * d[0];
  if (d[1] == 0 && d[2] == 0) return p;
  const Frame frame = frame_of(normal, edge_vector(level, predicted, e));
  p += frame.tangent1 * d[1];
  p += frame.tangent2 * d[2];
  return p;
}

}  // namespace

std::vector<Vec3> displace(const LevelTopology& level, std::span<const Vec3> predicted,
                           std::span<const Vec3> details) {
  assert(predicted.size() == level.vertex_count + details.size());
  std::vector<Vec3> positions(predicted.begin(), predicted.end());
  for (std::uint32_t e = 0; e < details.size(); ++e) {
    const Vec3& d = details[e];
    if (d[0] == 0 && d[1] == 0 && d[2] == 0) continue;
    positions[level.vertex_count + e] = displaced(level, predicted, e, d);
  }
  return positions;
}

void displace(const LevelTopology& level, const SparseBand& band, std::span<Vec3> positions,
              std::vector<Vec3>& moved) {
  // Frames are those of the prediction, so nothing moves before all are known.
  moved.resize(band.edges.size());
  for (std::size_t i = 0; i < moved.size(); ++i)
    moved[i] = displaced(level, positions, band.edges[i], band.details[i]);
  for (std::size_t i = 0; i < moved.size(); ++i)
    positions[level.vertex_count + band.edges[i]] = moved[i];
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
