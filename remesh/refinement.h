// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "base/semi_regular_mesh.h"
#include "base/topology.h"
#include "remesh/pierce.h"
#include "remesh/surface_map.h"

namespace nacre::remesh {

/// The semi-regular mesh while it grows: where each vertex is in space, on the scan and in the
/// domain.
class Refinement {
 public:
  enum Kind : std::uint8_t { kNormal = 0, kBoundary = 1, kVector = 2 };

  Refinement(const SurfaceMap& map, const BaseMesh& base, const LineTree& tree,
             const Topology& topology)
      : map_(map), base_(base), tree_(tree), topology_(topology) {}

  void resize(std::size_t vertices);
  /// Sets a vertex to a point of the scan; `at` is its place in space.
  void store(std::size_t vertex, const SurfacePoint& point, const Vec3& at, Kind kind);
  void store(std::size_t vertex, const SurfacePoint& point, Kind kind);

  [[nodiscard]] Vec3 scan_normal(std::uint32_t face) const;
  /// Cosine between a triangle and the scan under its corners; 0 if either has no direction.
  [[nodiscard]] double facing(const Triangle& t) const;
  [[nodiscard]] bool is_folded(const Triangle& t) const { return facing(t) < 0; }
  /// Whether a triangle, made of the given base triangle, lies upside down in the domain.
  [[nodiscard]] bool is_turned(const Triangle& t, std::uint32_t base_face) const;

  /// A base corner belongs to every triangle around it: seen from the one that is asked for.
  [[nodiscard]] DomainPoint seen_from(std::uint32_t vertex, std::uint32_t base_face) const;
  /// The scan's point at the middle, in the domain, of the edge's two ends as they really are;
  /// nearest to `otherwise` if they have no chart.
  [[nodiscard]] SurfacePoint expected_point(const Edge& edge, std::uint32_t base_face,
                                            const Vec3& otherwise) const;

  [[nodiscard]] const SurfaceMap& map() const { return map_; }
  [[nodiscard]] const Scan& scan() const { return map_.scan(); }
  [[nodiscard]] const BaseMesh& base() const { return base_; }
  [[nodiscard]] const LineTree& tree() const { return tree_; }
  [[nodiscard]] const Topology& topology() const { return topology_; }

  std::vector<Vec3> positions;
  std::vector<SurfacePoint> surface;
  std::vector<DomainPoint> domain;
  std::vector<std::uint8_t> kind;

 private:
  const SurfaceMap& map_;
  const BaseMesh& base_;
  const LineTree& tree_;
  const Topology& topology_;
};

/// Mends what placing the vertices of level + 1 one by one has left: first triangles that are
/// turned over in the domain, then those that are folded in space. Left alone, either kind grows
/// fourfold a level.
void unfold(Refinement& mesh, int level, const LevelPrediction& prediction, double reach);

}  // namespace nacre::remesh
