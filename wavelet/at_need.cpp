// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <utility>

#include "wavelet/butterfly_mask.h"
#include "wavelet/frames.h"
#include "wavelet/normal_at_midpoint.h"
#include "wavelet/wavelet.h"

namespace nacre::wavelet {
namespace {

class ButterflyAtNeed final : public MidpointsAtNeed {
 public:
  ButterflyAtNeed(const Topology& topology, int level, std::span<const Vec3> coarse)
      : mask_(topology), topology_(topology.level(level)), level_(level), coarse_(coarse) {
    mask_.predict_rings(level, coarse, [&](std::uint32_t edge, const Vec3& point) {
      rings_.emplace_back(edge, point);
    });
    std::sort(rings_.begin(), rings_.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
  }

  [[nodiscard]] Vec3 point(std::uint32_t edge) const override {
    if (!mask_.at_ring(level_, edge)) return mask_.predict_one(level_, coarse_, edge);
    return std::lower_bound(rings_.begin(), rings_.end(), edge,
                            [](const auto& a, std::uint32_t e) { return a.first < e; })
        ->second;
  }
  [[nodiscard]] Frame frame(std::uint32_t edge) const override {
    return frame_of(normal_at_midpoint(topology_, *this, edge),
                    edge_vector(topology_, coarse_, edge));
  }
  /// Of level + 1.
  Vec3 operator[](std::uint32_t vertex) const {
    return vertex < topology_.vertex_count ? coarse_[vertex]
                                           : point(vertex - topology_.vertex_count);
  }

 private:
  ButterflyMask mask_;
  const LevelTopology& topology_;
  int level_;
  std::span<const Vec3> coarse_;
  std::vector<std::pair<std::uint32_t, Vec3>> rings_;  // by edge
};

}  // namespace

PredictedLevel predict_at_need(const Topology& topology, int level, std::span<const Vec3> coarse) {
  if (level == 0) return predict_level(topology, level, coarse);
  PredictedLevel predicted;
  predicted.coarse = &topology.level(level);
  predicted.at_need = std::make_shared<const ButterflyAtNeed>(topology, level, coarse);
  return predicted;
}

}  // namespace nacre::wavelet
