// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "wavelet/refine.h"
#include "wavelet/wavelet.h"

namespace nacre::wavelet {

Result<std::vector<Vec3>> synthesize(const Topology& topology, const Pyramid& pyramid,
                                     Transform transform, int levels) {
  const auto bands = static_cast<int>(pyramid.bands.size());
  if (levels < 0) levels = bands;
  if (levels > bands || levels > topology.level_count()) {
    return Error{ErrorCode::kBadInput, std::to_string(levels) +
                                           " levels asked for, but there are " +
                                           std::to_string(bands) + " bands and " +
                                           std::to_string(topology.level_count()) + " levels"};
  }
  if (pyramid.base_positions.size() != topology.level(0).vertex_count) {
    return Error{ErrorCode::kBadInput,
                 std::to_string(pyramid.base_positions.size()) + " base positions for " +
                     std::to_string(topology.level(0).vertex_count) + " base vertices"};
  }
  for (int j = 0; j < levels; ++j) {
    const std::size_t size = pyramid.bands[static_cast<std::size_t>(j)].size();
    if (size == topology.band_size(j)) continue;
    return Error{ErrorCode::kBadInput,
                 "band " + std::to_string(j) + " has " + std::to_string(size) + " details, not " +
                     std::to_string(topology.band_size(j)),
                 static_cast<std::size_t>(j)};
  }

  const Refiner refiner(topology, transform);
  std::vector<Vec3> positions = pyramid.base_positions;
  for (int j = 0; j < levels; ++j) {
    const std::vector<Vec3> predicted = refiner.predict(j, positions);
    positions = displace(topology.level(j), predicted, pyramid.bands[static_cast<std::size_t>(j)]);
  }
  if (const auto ok = check_finite(positions); !ok) return ok.error();
  return positions;
}

struct Synthesizer::Impl {
  const Topology& topology;
  Refiner refiner;
  std::vector<Vec3> moved;
};

Synthesizer::Synthesizer(const Topology& topology, Transform transform)
    : impl_(new Impl{topology, Refiner(topology, transform), {}}) {}

Synthesizer::~Synthesizer() = default;

void Synthesizer::next_level(int level, const SparseBand& band, std::vector<Vec3>& positions) {
  impl_->refiner.refine(level, positions);
  displace(impl_->topology.level(level), band, positions, impl_->moved);
}

Result<std::vector<Vec3>> synthesize(const Topology& topology, std::vector<Vec3> base_positions,
                                     std::span<const SparseBand> bands, Transform transform) {
  const auto levels = static_cast<int>(bands.size());
  if (levels > topology.level_count() || base_positions.size() != topology.level(0).vertex_count)
    return Error{ErrorCode::kBadInput, "bands or base positions do not fit the topology"};
  Synthesizer synthesizer(topology, transform);
  std::vector<Vec3> positions = std::move(base_positions);
  positions.reserve(topology.level(levels).vertex_count);
  for (int j = 0; j < levels; ++j)
    synthesizer.next_level(j, bands[static_cast<std::size_t>(j)], positions);
  if (const auto ok = check_finite(positions); !ok) return ok.error();
  return positions;
}

}  // namespace nacre::wavelet
