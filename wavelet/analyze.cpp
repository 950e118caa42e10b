// SPDX-License-Identifier: GPL-3.0-or-later
#include <cassert>
#include <string>

#include "base/parallel.h"
#include "wavelet/frames.h"
#include "wavelet/loop_inverse.h"
#include "wavelet/refine.h"
#include "wavelet/wavelet.h"

// Details are measured against the positions that synthesis will rebuild from them, not against the
// given ones. The two differ in the last bits only, but a frame can turn by 90 degrees between them
// (two components of a normal are equally small), and a detail is useless in another frame.

namespace nacre::wavelet {
namespace {

/// Positions of every level whose refinement, plus details, gives `positions`.
Result<std::vector<std::vector<Vec3>>> coarsen(const Topology& topology,
                                               std::span<const Vec3> positions,
                                               Transform transform) {
  const int levels = topology.level_count();
  std::vector<std::vector<Vec3>> targets(static_cast<std::size_t>(levels) + 1);
  targets.back().assign(positions.begin(), positions.end());
  for (int j = levels - 1; j >= 0; --j) {
    const std::vector<Vec3>& finer = targets[static_cast<std::size_t>(j) + 1];
    const std::span<const Vec3> kept(finer.data(), topology.level(j).vertex_count);
    std::vector<Vec3>& coarser = targets[static_cast<std::size_t>(j)];
    if (transform == Transform::kButterfly) {
      coarser.assign(kept.begin(), kept.end());
      continue;
    }
    auto solved = invert_loop_even_rule(topology.level(j), kept);
    if (!solved) return solved.error();
    coarser = std::move(*solved);
  }
  return targets;
}

}  // namespace

PredictedLevel predict_level(const Topology& topology, int level, std::span<const Vec3> coarse) {
  assert(coarse.size() == topology.level(level).vertex_count);
  const auto frame_at = [](const LevelTopology& at, std::span<const Vec3> p, std::uint32_t e) {
    return frame_of(midpoint_normal(at, p, e), edge_vector(at, p, e));
  };
  return {&topology.level(level), Refiner(topology, Transform::kButterfly).predict(level, coarse),
          frame_at};
}

LevelPrediction predict(const Topology& topology, int level, std::span<const Vec3> coarse) {
  const PredictedLevel predicted = predict_level(topology, level, coarse);
  LevelPrediction result;
  result.points.assign(predicted.positions.begin() + topology.level(level).vertex_count,
                       predicted.positions.end());
  result.frames.resize(result.points.size());
  parallel_for_each_index(result.frames.size(),
                          [&](std::size_t e) { result.frames[e] = predicted.frame(e); });
  return result;
}

std::vector<Vec3> with_details(PredictedLevel predicted, const SparseBand& band) {
  std::vector<Vec3> moved;
  displace(*predicted.coarse, band, predicted.positions, moved);
  return std::move(predicted.positions);
}

Result<Pyramid> analyze(const Topology& topology, std::span<const Vec3> positions,
                        Transform transform) {
  if (positions.size() != topology.vertex_count()) {
    return Error{ErrorCode::kBadInput, std::to_string(positions.size()) + " positions for " +
                                           std::to_string(topology.vertex_count()) + " vertices"};
  }
  if (const auto ok = check_finite(positions); !ok) return ok.error();
  const auto targets = coarsen(topology, positions, transform);
  if (!targets) return targets.error();

  const Refiner refiner(topology, transform);
  Pyramid pyramid;
  pyramid.base_positions = targets->front();
  std::vector<Vec3> rebuilt = pyramid.base_positions;
  for (int j = 0; j < topology.level_count(); ++j) {
    const LevelTopology& level = topology.level(j);
    const std::vector<Vec3>& target = (*targets)[static_cast<std::size_t>(j) + 1];
    const std::vector<Vec3> predicted = refiner.predict(j, rebuilt);
    std::vector<Vec3>& band = pyramid.bands.emplace_back(level.edges.size());
    parallel_for_each_index(band.size(), [&](std::size_t i) {
      const auto e = static_cast<std::uint32_t>(i);
      const Frame frame =
          frame_of(midpoint_normal(level, predicted, e), edge_vector(level, predicted, e));
      const Vec3 offset = target[level.vertex_count + e] - predicted[level.vertex_count + e];
      band[e] = to_frame(frame, offset);
    });
    rebuilt = displace(level, predicted, band);
  }
  if (const auto ok = check_finite(rebuilt); !ok) return ok.error();
  return pyramid;
}

}  // namespace nacre::wavelet
