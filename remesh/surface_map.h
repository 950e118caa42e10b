// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <optional>

#include "base/scan.h"
#include "remesh/chart.h"

namespace nacre::remesh {

/// Both directions of a parameterisation: scan surface ↔ base domain. Safe to share between
/// threads.
class SurfaceMap {
 public:
  SurfaceMap(const Scan& scan, const Parameterisation& parameterisation);

  /// Where a point of the scan lies in the domain: linear on the scan triangle, in the chart that
  /// holds its corners (nearest corner if none does).
  [[nodiscard]] DomainPoint to_domain(const SurfacePoint& point) const;

  /// The point of the scan at a domain point, by walking over the scan's triangles from `hint`.
  /// Where the walk is led astray (a triangle that relaxation turned over): from the scan vertex
  /// nearest in the domain, and as the last resort that vertex itself.
  [[nodiscard]] SurfacePoint to_surface(const DomainPoint& point, std::uint32_t hint) const;

  [[nodiscard]] const Atlas& atlas() const { return atlas_; }
  [[nodiscard]] const Scan& scan() const { return scan_; }
  [[nodiscard]] std::span<const Triangle> neighbors() const { return neighbors_; }
  /// A scan triangle at the scan vertex that base vertex v started from.
  [[nodiscard]] std::uint32_t start_triangle(std::uint32_t base_vertex) const;

 private:
  std::optional<SurfacePoint> walk(const DomainPoint& target, std::uint32_t start) const;

  const Scan& scan_;
  const Parameterisation& map_;
  Atlas atlas_;
  std::vector<Triangle> neighbors_;
  std::vector<std::uint32_t> face_of_vertex_;
  std::vector<std::uint32_t> vertex_start_, vertices_;  // scan vertices by base triangle
};

}  // namespace nacre::remesh
