// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "base/scan.h"

namespace nacre::metric {

/// Sample points of a surface, uniform by area, in an order that walks through space.
///
/// The faces are visited along a Morton curve through their centroids. Face i of that order gets
/// round(C_i) − round(C_{i−1}) samples, C the cumulated area scaled to the sample count, so that
/// rounding errors do not add up and every stretch of the curve has its due share. Inside a face
/// the points follow the R2 sequence, shifted by a hash of (seed, face).
///
/// Shapes   `vertices`: every vertex of a face with an area, once, along the same curve.
/// Source   stratification by area: [CignoniRocchiniScopigno1998]; R2: [Roberts2018].
class SurfaceSampler {
 public:
  /// `scan` must outlive the sampler and have passed Surface::build.
  SurfaceSampler(const Scan& scan, std::size_t sample_count, std::uint64_t seed);

  [[nodiscard]] std::size_t size() const { return first_sample_.back(); }
  [[nodiscard]] const std::vector<std::uint32_t>& vertices() const { return vertices_; }

  /// Calls visit(point) for samples [begin, end) in order.
  template <class Visit>
  void for_each(std::size_t begin, std::size_t end, const Visit& visit) const {
    if (begin >= end) return;
    for (std::size_t i = face_of(begin); begin < end; ++i)
      for (; begin < end && begin < first_sample_[i + 1]; ++begin)
        visit(point(i, begin - first_sample_[i]));
  }

 private:
  [[nodiscard]] std::size_t face_of(std::size_t sample) const;
  [[nodiscard]] Vec3 point(std::size_t face, std::size_t k) const;

  const Scan* scan_;
  std::uint64_t seed_;
  std::vector<std::uint32_t> faces_;       // with an area, along the curve
  std::vector<std::size_t> first_sample_;  // of each entry of faces_, then the total
  std::vector<std::uint32_t> vertices_;
};

}  // namespace nacre::metric
