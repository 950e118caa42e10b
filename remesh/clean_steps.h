// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "remesh/remesh.h"

/// The steps of cleaning, in their order, and what they hand on. Every step is near linear.
namespace nacre::remesh {

/// Counts changes of one kind and remembers the lowest ids.
class Counter {
 public:
  explicit Counter(std::string kind) { action_.kind = std::move(kind); }
  void add(std::size_t id) {
    ++action_.count;
    auto& ids = action_.first_ids;
    if (ids.size() == kFirstIds && id >= ids.back()) return;
    ids.insert(std::upper_bound(ids.begin(), ids.end(), id), id);
    if (ids.size() > kFirstIds) ids.pop_back();
  }
  void measure(double area, double extent) {
    action_.area += area;
    action_.extent = std::max(action_.extent, extent);
  }
  void append_to(CleanReport& report) const {
    if (action_.count > 0) report.actions.push_back(action_);
  }

 private:
  static constexpr std::size_t kFirstIds = 8;
  CleanAction action_;
};

struct Box {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  void add(const Vec3& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  [[nodiscard]] double extent() const { return (high - low).norm(); }
};

struct CleanCounts {
  Counter welded{"welded vertices"}, isolated{"dropped isolated vertices"},
      degenerate{"dropped degenerate faces"}, duplicate{"dropped duplicate faces"},
      crowded{"cut edges of three or more faces"}, one_sided{"cut one-sided edges"},
      parted{"split non-manifold vertices"}, doubled{"split doubled edges"},
      reoriented{"reoriented faces"}, inside_out{"turned pieces inside out"},
      small{"dropped small pieces"}, holes{"filled pin holes"}, handles{"cut tiny handles"};
};

/// The faces that are left. Two vertices are in one place if their coordinates are equal; that is a
/// reason to weld them, but not where the input's own numbering makes a manifold without.
struct Soup {
  const Scan& scan;
  std::vector<std::uint32_t> place;   ///< per input vertex: the lowest vertex in the same place
  std::vector<Triangle> corners;      ///< by input vertex
  std::vector<Triangle> at;           ///< by place
  std::vector<std::uint32_t> source;  ///< input face of each
};

/// All faces, without isolated vertices.
[[nodiscard]] Soup make_soup(const Scan& scan, CleanCounts& counts);

/// Drops faces with two corners in one place, and all but the first of those with the same three
/// corners; by place these go only where no hole is torn: an outer layer of a face that a closed
/// surface has for itself stays. Returns whether such a one stayed.
bool drop_faces(Soup& soup, CleanCounts& counts);

/// Where cutting has laid open what drop_faces() left: drops from the soup what it would drop now.
/// `source` is the input face of each triangle of `cleaned`. False if there is nothing.
bool drop_loosened(Soup& soup, const Scan& cleaned, std::span<const std::uint32_t> source,
                   CleanCounts& counts);

/// Which other face each side of each face joins. Side k of face f is 3 f + k.
struct Joins {
  std::vector<std::uint32_t> partner;  ///< per side: the side that it joins, or kNone
  std::vector<std::uint32_t> piece;    ///< per face
  std::vector<char> turned;            ///< per face: to be turned so that joined faces agree
  std::uint32_t piece_count = 0;
  /// Sides in one place that are not all joined in pairs, place by place.
  std::vector<std::vector<std::uint32_t>> crowded;
};

[[nodiscard]] Joins join_sides(const Soup& soup, CleanCounts& counts);

/// Turns faces. An open piece keeps the winding that most of its faces have. A closed one faces
/// outward, unless it lies in another closed one: then both are turned or neither, so that the
/// wall of a cavity stays one.
void orient(Soup& soup, Joins& joins, CleanCounts& counts);

/// Gives every fan of joined faces a vertex of its own. Where this leaves several pairs of faces on
/// one edge by number, all pairs but one get a vertex in the middle of their edge.
[[nodiscard]] CleanScan part_vertices(Soup& soup, Joins& joins, CleanCounts& counts);

/// Fills `pieces` from the triangles' piece numbers and joins.
void count_topology(CleanScan& cleaned, std::uint32_t piece_count,
                    std::span<const std::uint32_t> partner);

/// Bounding box diagonal of each piece.
[[nodiscard]] std::vector<double> piece_extents(const CleanScan& cleaned);

/// Both as shares of the largest piece's extent, the diagonal of its bounding box.
struct SmallPieces {
  double extent;  ///< only pieces of less extent go
  double error;   ///< and only if they lie within this of the larger ones; infinite: wherever
};

/// Drops small pieces, unless they are much of the area; `face_source` is each triangle's input
/// face.
void drop_small_pieces(CleanScan& cleaned, std::vector<std::uint32_t>& face_source,
                       const SmallPieces& options, CleanCounts& counts);

/// Closes boundary loops of few edges and little extent. New triangles come last; `source` grows
/// with them. Pieces are to be counted anew afterwards; so with the next.
void fill_pin_holes(CleanScan& cleaned, std::vector<std::uint32_t>& source, CleanCounts& counts);

/// Cuts handles around or through which there is a loop of little extent, and closes both ends.
void cut_tiny_handles(CleanScan& cleaned, std::vector<std::uint32_t>& source, CleanCounts& counts);

}  // namespace nacre::remesh
