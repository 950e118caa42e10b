// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "base/topology.h"

namespace nacre::wavelet {

/// The modified butterfly's prediction of every edge midpoint of a level. Linear in the mesh's size
/// whatever the valences. Keeps a reference to `topology`.
///
/// Interior edge   (a + b) / 2, plus c / 8 - (w0 + w1) / 16 for its lower-numbered triangle, plus
/// the
///                 same for the other: a, b its ends, c the opposite corner, w0 and w1 the wings
///                 beyond that triangle's next side and the one after. A wing that the boundary
///                 cuts off, beyond side (p, q) with opposite corner r, is (p + q) - r.
/// Extraordinary   an end v whose closed ring q_0 .. q_{K-1} has K != 6: v + Σ w_j (q_j - v) with
///                 w_j = (1/4 + a1 cos(2πj/K) + a2 cos(4πj/K)) / K, j counted from the edge;
///                 a1 = 1, a2 = 1/2, but a1 = 1/2 for K = 2, a2 = 0 for K < 4 and 1/4 for K = 4.
///                 Two such ends: the mean of both. Ends on the boundary count as regular.
/// Boundary edge   9/16 (a + b) - 1/16 (a' + b'), a' and b' the next vertices along the boundary.
/// Source          [Zorin1996] section 4; [Dyn1990] the regular stencil; K = 2, which only closed
///                 two-triangle corners have, continues Zorin's series.
class ButterflyMask {
 public:
  explicit ButterflyMask(const Topology& topology);

  /// points[e] = predicted midpoint of edge e of `level`.
  /// Shapes   coarse.size() >= level's vertex_count, points.size() == its edge count
  void predict(int level, std::span<const Vec3> coarse, std::span<Vec3> points) const;

  /// One of them, of a level > 0 and not of a ring: see at_ring().
  [[nodiscard]] Vec3 predict_one(int level, std::span<const Vec3> coarse, std::uint32_t e) const;
  /// Whether edge `e` of a level > 0 begins at an extraordinary vertex.
  [[nodiscard]] bool at_ring(int level, std::uint32_t e) const;
  /// Calls visit(edge of the level, point) for every such edge.
  template <class Visit>
  void predict_rings(int level, std::span<const Vec3> coarse, const Visit& visit) const {
    for (std::size_t ring = 0; ring + 1 < ring_begin_.size(); ++ring)
      predict_ring(level, ring, coarse, [&](const Spoke& s, const Vec3& point) {
        visit(edge_at_level(level, s), point);
      });
  }

 private:
  /// End `end` of base edge `edge`. Only base vertices can be extraordinary, and their edges on
  /// every level are the end pieces of base edges.
  struct Spoke {
    std::uint32_t edge;
    std::uint32_t end;
  };

  void find_rings();
  void predict_base(std::span<const Vec3> coarse, std::span<Vec3> points) const;
  void predict_split(int level, std::span<const Vec3> coarse, std::span<Vec3> points) const;
  static std::uint32_t edge_at_level(int level, const Spoke& s) {
    return s.end == 0 ? s.edge << level : ((s.edge + 1) << level) - 1;
  }
  /// Calls visit(spoke, point) for the ring's spokes in order.
  void predict_ring(int level, std::size_t ring, std::span<const Vec3> coarse,
                    const std::function<void(const Spoke&, const Vec3&)>& visit) const;
  /// The wing beyond the half of side k of parent triangle f: at corner k (0) or at the next (1).
  [[nodiscard]] static Vec3 wing_beyond(const LevelTopology& parent, std::span<const Vec3> coarse,
                                        std::uint32_t f, std::uint32_t k, std::uint32_t half);

  const Topology& topology_;
  std::vector<Spoke> spokes_;            ///< of all extraordinary rings, counter-clockwise
  std::vector<std::size_t> ring_begin_;  ///< ring r is spokes_[ring_begin_[r] .. ring_begin_[r+1])
  std::vector<std::uint32_t> ring_of_;   ///< by 2 * base edge + end; kNone when regular
};

}  // namespace nacre::wavelet
