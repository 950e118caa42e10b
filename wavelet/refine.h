// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "wavelet/butterfly_mask.h"
#include "wavelet/wavelet.h"

/// One level of either transform; what analysis and synthesis share.
namespace nacre::wavelet {

/// Predicts each next level of one mesh. Keeps a reference to `topology`.
class Refiner {
 public:
  Refiner(const Topology& topology, Transform transform);

  /// All vertices of level + 1 before details: the kept ones (moved by Loop), then the midpoints.
  [[nodiscard]] std::vector<Vec3> predict(int level, std::span<const Vec3> coarse) const;

  /// The same in place: `positions` grows from level to level + 1.
  void refine(int level, std::vector<Vec3>& positions) const;

 private:
  const Topology& topology_;
  std::optional<ButterflyMask> butterfly_;  ///< none: Loop
};

/// Level + 1 with details: midpoint e becomes ((p + n d0) + t1 d1) + t2 d2 in its frame; terms of
/// zero details are left out.
[[nodiscard]] std::vector<Vec3> displace(const LevelTopology& level,
                                         std::span<const Vec3> predicted,
                                         std::span<const Vec3> details);

/// The same in place, from predicted positions of level + 1; `moved` is room to work in.
void displace(const LevelTopology& level, const SparseBand& band, std::span<Vec3> positions,
              std::vector<Vec3>& moved);

/// kBadInput naming the first vertex that has a coordinate that is not finite.
[[nodiscard]] Result<void> check_finite(std::span<const Vec3> positions);

}  // namespace nacre::wavelet
