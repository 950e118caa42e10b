// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <utility>
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
  enum Kind : std::uint8_t {
    kNormal = 0,
    kBoundary = 1,
    kVector = 2,
    kNearBoundary = 3,  ///< on the normal's line, as near the boundary curve as makes no difference
  };
  static bool is_normal(std::uint8_t kind) { return kind == kNormal || kind == kNearBoundary; }
  static bool is_boundary(std::uint8_t kind) { return kind == kBoundary || kind == kNearBoundary; }

  Refinement(const SurfaceMap& map, const BaseMesh& base, const LineTree& tree,
             const Topology& topology);

  void resize(std::size_t vertices);

  /// All that is known of where a vertex is.
  struct Place {
    SurfacePoint surface;
    DomainPoint domain;
    Vec3 at;
    std::uint8_t kind;
  };
  [[nodiscard]] Place place(std::size_t vertex) const {
    return {surface(vertex), domain(vertex), positions[vertex], kind[vertex]};
  }
  void put(std::size_t vertex, const Place& place);
  /// Sets a vertex to a point of the scan; `at` is its place in space.
  void store(std::size_t vertex, const SurfacePoint& point, const Vec3& at, Kind kind);
  void store(std::size_t vertex, const SurfacePoint& point, Kind kind);

  [[nodiscard]] Vec3 scan_normal(std::uint32_t face) const;
  /// Cosine between a triangle and the scan under its corners; 0 if either has no direction. With
  /// corners on sides of the scan's triangles, where it is arbitrary whose normal counts: or the
  /// scan under its middle, whichever is more.
  [[nodiscard]] double facing(const Triangle& t) const;
  [[nodiscard]] bool is_folded(const Triangle& t) const;
  /// Whether it opposes the scan's triangles nearest to its middle and to its corners, whatever the
  /// map says: as a check from outside would see it. Where several of the scan's triangles are as
  /// near, on a crease, a check may take any: whether it is so for any choice, or for all.
  enum class Ties : std::uint8_t { kAny, kAll };
  [[nodiscard]] bool is_opposed(const Triangle& t, Ties ties = Ties::kAny) const;
  /// The same, asked only where that may be so: of triangles that are nearly folded, and of those
  /// with corners on sides of the scan's triangles, where it is arbitrary whose normal counts.
  [[nodiscard]] bool is_suspect(const Triangle& t, double facing) const;
  /// All of a level's that are folded or is_suspect(), ascending.
  [[nodiscard]] std::vector<std::uint32_t> opposed_triangles(int level) const;
  /// All of a level's, ascending.
  [[nodiscard]] std::vector<std::uint32_t> folded_triangles(int level) const;
  /// Twice the area in the domain of a triangle that was made of the given base triangle; nothing
  /// if its corners share no chart.
  [[nodiscard]] std::optional<double> domain_area(const Triangle& t, std::uint32_t base_face) const;
  /// Whether a triangle, made of the given base triangle, lies upside down in the domain.
  [[nodiscard]] bool is_turned(const Triangle& t, std::uint32_t base_face) const;

  /// All of a level > 0 that are turned, ascending.
  [[nodiscard]] std::vector<std::uint32_t> turned_triangles(int level) const;

  /// Where a vertex lies on the scan.
  [[nodiscard]] SurfacePoint surface(std::size_t vertex) const;
  [[nodiscard]] std::uint32_t surface_face(std::size_t vertex) const {
    if (vertex < coarser_) return surface_[vertex].face;
    const std::uint32_t face = face_[vertex - coarser_];
    return (face & kExact) == 0 ? face : exact_[face & ~kExact].face;
  }
  /// Where a vertex lies in the domain.
  [[nodiscard]] DomainPoint domain(std::size_t vertex) const;
  /// Only base vertices and what lies on the boundary may be elsewhere than their surface point.
  void set_domain(std::size_t vertex, const DomainPoint& point);
  /// A base corner belongs to every triangle around it: seen from the one that is asked for.
  [[nodiscard]] DomainPoint seen_from(std::uint32_t vertex, std::uint32_t base_face) const;
  /// The scan's point at the middle, in the domain, of the edge's two ends as they really are;
  /// nearest to `otherwise` if they have no chart.
  [[nodiscard]] SurfacePoint expected_point(const Edge& edge, std::uint32_t base_face,
                                            const Vec3& otherwise) const;

  [[nodiscard]] bool has_tips() const { return has_tips_; }
  [[nodiscard]] const SurfaceMap& map() const { return map_; }
  [[nodiscard]] const Scan& scan() const { return map_.scan(); }
  [[nodiscard]] const BaseMesh& base() const { return base_; }
  [[nodiscard]] const LineTree& tree() const { return tree_; }
  [[nodiscard]] const Topology& topology() const { return topology_; }
  [[nodiscard]] Triangle triangle(int level, std::size_t i) const {
    return topology_.triangle(level, i);
  }

  std::vector<Vec3> positions;
  std::vector<std::uint8_t> kind;

  /// Where vertices were before they were set for the first time.
  struct Earlier {
    Place place;
    bool has_strayed = false;  ///< and were elsewhere later, wherever they are now
  };
  using Journal = std::map<std::uint32_t, Earlier>;
  /// Kept from when it is not null. Searching sets a vertex thousands of times.
  Journal* journal = nullptr;

 private:
  /// Beside a place's number in `exact_`.
  static constexpr std::uint32_t kExact = 0x80000000u;

  void note(std::uint32_t vertex);
  void set_surface(std::size_t vertex, const SurfacePoint& point);
  [[nodiscard]] std::size_t on_boundary(std::size_t vertex) const;

  const SurfaceMap& map_;
  bool has_tips_;  // without them ties are rare, and looking for them costs more than it brings
  const BaseMesh& base_;
  const LineTree& tree_;
  const Topology& topology_;
  std::size_t coarser_;  // vertices of all levels but the finest
  std::vector<SurfacePoint> surface_;
  // The finest level's vertices are three quarters of all. Where one is on its line, the scan's
  // triangle and its position say the rest; others have a place in `exact_`.
  std::vector<std::uint32_t> face_;
  std::deque<SurfacePoint> exact_;
  std::vector<std::uint32_t> free_;  // of exact_
  std::mutex exact_in_use_;          // while places are added
  // The map says it again for all others.
  std::vector<DomainPoint> base_domain_, boundary_domain_;
  std::vector<std::uint32_t> boundary_;  // vertices on boundary edges, ascending
};

/// Mends what placing the vertices of level + 1 one by one has left: first triangles that are
/// turned over in the domain, then those that are folded in space. Left alone, either kind grows
/// fourfold a level. With `give_back`, what a turned triangle has sent to its expected point goes
/// back to its line where that does no harm; trials do without.
///
/// Returns  the triangles of level + 1 that stay folded, ascending.
std::vector<std::uint32_t> unfold(Refinement& mesh, int level, const PredictedLevel& prediction,
                                  double reach, bool give_back);

}  // namespace nacre::remesh
