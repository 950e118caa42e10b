// SPDX-License-Identifier: Apache-2.0
#pragma once

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
  void predict_ring(int level, std::size_t ring, std::span<const Vec3> coarse,
                    std::span<Vec3> points) const;

  const Topology& topology_;
  std::vector<Spoke> spokes_;            ///< of all extraordinary rings, counter-clockwise
  std::vector<std::size_t> ring_begin_;  ///< ring r is spokes_[ring_begin_[r] .. ring_begin_[r+1])
  std::vector<std::uint32_t> ring_of_;   ///< by 2 * base edge + end; kNone when regular
};

}  // namespace nacre::wavelet
