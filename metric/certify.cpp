// SPDX-License-Identifier: GPL-3.0-or-later
//
// Branch and bound over the faces of the surface that is measured from. A piece of a face is closed
// once its upper bound is no more than the tolerance above the largest distance met so far. Two
// bounds, of which the lesser counts, for a piece with corners v_i:
//   (1) the distance to a set changes no faster than one walks, and no point of a triangle is
//       farther than (longest side) / √3 from its nearest corner: max d(v_i) + longest / √3;
//   (2) the distance to one triangle t is convex, so over a piece it is largest at a corner:
//       max d(v_i, t), for the t nearest to a corner or to the centre.
// (2) closes at once what lies over a single triangle of the other surface; (1) makes sure that
// halving ends. Bounding pieces of faces so is
// [GutheBorodinKlein2005]'s idea; [TangLeeKim2009] is what CGAL has (README.md compares the two).
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <new>
#include <vector>

#include "base/parallel.h"
#include "metric/beside.h"
#include "metric/metric.h"
#include "metric/triangle.h"

namespace nacre::metric {
namespace {

constexpr std::size_t kFacesPerRound = 4096;
constexpr std::size_t kFirstRound = 256;
/// What one face may be cut into before it is closed with the bound it has.
constexpr std::size_t kMaxPiecesPerFace = std::size_t{1} << 22;
/// Points of the surface are computed with at most 6 roundings a coordinate, and a halving adds
/// one; the foot point likewise: see kRoundingUlps.
constexpr double kBoundUlps = 4 * kRoundingUlps;
/// 1 / √3, a bit more.
constexpr double kCoverRadius = 0.577350270;

struct Corner {
  Vec3 point = Vec3::Zero();
  Surface::Nearest nearest;
};

struct Piece {
  std::array<Corner, 3> corner;
};

struct Longest {
  std::size_t side = 0;  ///< from corner `side` to the next
  double length = 0;
};

Longest longest_side(const Piece& piece) {
  Longest longest;
  for (std::size_t k = 0; k < 3; ++k) {
    const double length = norm(piece.corner[(k + 1) % 3].point - piece.corner[k].point);
    if (length > longest.length) longest = {k, length};
  }
  return longest;
}

double farthest_corner(const Piece& piece) {
  return std::max({piece.corner[0].nearest.distance, piece.corner[1].nearest.distance,
                   piece.corner[2].nearest.distance});
}

/// What is known of a part of the surface.
struct Bounds {
  double lower = 0, upper = 0;
  Vec3 lower_at = Vec3::Zero();
  std::size_t pieces = 0;

  void found(const Corner& corner) {
    if (!(corner.nearest.distance > lower)) return;
    lower = corner.nearest.distance;
    lower_at = corner.point;
  }
  void merge(const Bounds& other) {
    if (other.lower > lower) {
      lower = other.lower;
      lower_at = other.lower_at;
    }
    upper = std::max(upper, other.upper);
    pieces += other.pieces;
  }
};

/// Measures one direction.
class OneWay {
 public:
  OneWay(const Scan& from, const Surface& to, const Scan& to_scan, const CertifyOptions& options,
         double least_gap, const RunContext& context)
      : from_(from),
        to_(to),
        to_scan_(to_scan),
        options_(options),
        least_gap_(least_gap),
        context_(context) {}

  Bounds run() {
    measure_corners();
    order_faces();
    Bounds all;
    for (const std::uint32_t f : faces_)
      for (const Corner& corner : piece_of(f).corner) all.found(corner);
    std::size_t done = 0;
    while (done < faces_.size()) {
      if (context_.cancelled() || all.lower > options_.give_up_above) break;
      // Faces come with their first bounds falling: what follows cannot matter either.
      if (first_bound_[faces_[done]] <= threshold(all.lower)) break;
      const std::size_t count =
          std::min(faces_.size() - done, done == 0 ? kFirstRound : kFacesPerRound);
      all.merge(round(done, count, all));
      done += count;
    }
    if (done < faces_.size()) all.upper = std::max(all.upper, first_bound_[faces_[done]]);
    return all;
  }

 private:
  /// A piece whose upper bound is at most this is closed.
  [[nodiscard]] double threshold(double lower) const {
    return std::max(lower + least_gap_, lower * (1 + options_.relative_tolerance));
  }

  void measure_corners() {
    std::vector<bool> on_face(from_.positions.size(), false);
    for (const Triangle& t : from_.triangles)
      for (const std::uint32_t v : t) on_face[v] = true;
    corners_.resize(from_.positions.size());
    constexpr std::size_t kBlock = 1024;
    parallel_for_each_index((corners_.size() + kBlock - 1) / kBlock,
                            [&](std::size_t b) {
                              Surface::Nearest last;
                              const std::size_t end = std::min(corners_.size(), (b + 1) * kBlock);
                              for (std::size_t v = b * kBlock; v < end; ++v) {
                                if (!on_face[v]) continue;
                                last = to_.nearest(from_.positions[v], last);
                                corners_[v] = {from_.positions[v], last};
                              }
                            },
                            1);
  }

  void order_faces() {
    first_bound_.assign(from_.triangles.size(), 0);
    for (std::uint32_t f = 0; f < from_.triangles.size(); ++f) {
      const Triangle& t = from_.triangles[f];
      if (!(twice_area(from_.positions[t[0]], from_.positions[t[1]], from_.positions[t[2]]) > 0))
        continue;
      const Piece piece = piece_of(f);
      first_bound_[f] = upper_bound(piece, longest_side(piece).length, 0);
      faces_.push_back(f);
    }
    std::ranges::stable_sort(faces_, [&](std::uint32_t f, std::uint32_t g) {
      return first_bound_[f] > first_bound_[g];
    });
  }

  [[nodiscard]] Piece piece_of(std::uint32_t face) const {
    const Triangle& t = from_.triangles[face];
    return {{corners_[t[0]], corners_[t[1]], corners_[t[2]]}};
  }

  /// max d(v_i, t) for triangle t of the other surface.
  [[nodiscard]] double distance_to_face(const Piece& piece, std::uint32_t face) const {
    const Triangle& t = to_scan_.triangles[face];
    double most = 0;
    for (const Corner& corner : piece.corner) {
      if (corner.nearest.triangle == face) {
        most = std::max(most, corner.nearest.distance);
        continue;
      }
      const Vec3 q = closest_on_triangle(corner.point, to_scan_.positions[t[0]],
                                         to_scan_.positions[t[1]], to_scan_.positions[t[2]]);
      most = std::max(most, norm(corner.point - q));
    }
    return most;
  }

  [[nodiscard]] Corner centre_of(const Piece& piece) const {
    const auto& [a, b, c] = piece.corner;
    const Vec3 point = (a.point + b.point + c.point) / 3;
    return {point, to_.nearest(point, a.nearest)};
  }

  /// The lesser of the two bounds; a bound at or below `enough` is as good as any.
  [[nodiscard]] double upper_bound(const Piece& piece, double longest, double enough) const {
    double bound = farthest_corner(piece) + kCoverRadius * longest;
    for (std::size_t k = 0; k < 3 && bound > enough; ++k) {
      const std::uint32_t face = piece.corner[k].nearest.triangle;
      if (k > 0 && face == piece.corner[0].nearest.triangle) continue;
      bound = std::min(bound, distance_to_face(piece, face));
    }
    return bound;
  }

  /// Cuts a face until each piece is closed, given what was known at the round's start.
  [[nodiscard]] Bounds refine(std::uint32_t face, const Bounds& known, std::size_t most) const {
    Bounds here;
    here.lower = known.lower;
    here.lower_at = known.lower_at;
    std::vector<Piece> open = {piece_of(face)};
    while (!open.empty()) {
      const Piece piece = open.back();
      open.pop_back();
      ++here.pieces;
      const Longest longest = longest_side(piece);
      const double enough = threshold(here.lower);
      double bound = upper_bound(piece, longest.length, enough);
      if (bound > enough) {
        const Corner inside = centre_of(piece);
        here.found(inside);
        bound = std::min(bound, distance_to_face(piece, inside.nearest.triangle));
      }
      const bool halves_no_more = !(longest.length > least_gap_);
      if (bound <= enough || halves_no_more || here.pieces >= most) {
        here.upper = std::max(here.upper, bound);
        continue;
      }
      const Corner& a = piece.corner[longest.side];
      const Corner& b = piece.corner[(longest.side + 1) % 3];
      const Corner& c = piece.corner[(longest.side + 2) % 3];
      Corner middle;
      middle.point = 0.5 * (a.point + b.point);
      middle.nearest = to_.nearest(middle.point, a.nearest);
      here.found(middle);
      open.push_back({{a, middle, c}});
      open.push_back({{middle, b, c}});
    }
    return here;
  }

  [[nodiscard]] Bounds round(std::size_t first, std::size_t count, const Bounds& known) const {
    std::vector<Bounds> found(count);
    const std::size_t most = known.pieces < options_.max_pieces ? kMaxPiecesPerFace : 1;
    parallel_for_each_index(
        count,
        [&](std::size_t i) {
          const std::uint32_t face = faces_[first + i];
          if (context_.cancelled()) {
            found[i].upper = first_bound_[face];
          } else {
            found[i] = refine(face, known, most);
          }
        },
        16);
    Bounds all;
    for (const Bounds& b : found) all.merge(b);
    return all;
  }

  const Scan& from_;
  const Surface& to_;
  const Scan& to_scan_;
  const CertifyOptions& options_;
  double least_gap_;
  const RunContext& context_;
  std::vector<Corner> corners_;
  std::vector<double> first_bound_;   // per face; 0 for those without an area
  std::vector<std::uint32_t> faces_;  // with an area, by falling first bound
};

CertifiedOneSided finish(const Bounds& bounds, const CertifyOptions& options, double slack,
                         double least_gap) {
  CertifiedOneSided side;
  side.lower = std::max(0.0, bounds.lower - slack);
  side.upper = bounds.upper + slack;
  side.lower_at = bounds.lower_at;
  side.pieces = bounds.pieces;
  const double gap = std::max(least_gap, options.relative_tolerance * bounds.lower);
  // A little more than the gap, for the bound itself is rounded.
  side.within_tolerance = bounds.upper - bounds.lower <= gap * (1 + 1e-9);
  return side;
}

}  // namespace

Result<Certified> certified_distance(const Scan& a, const Surface& surface_a, const Scan& b,
                                     const CertifyOptions& options, const RunContext& context) try {
  if (!(options.relative_tolerance >= 0 && options.relative_tolerance <= 1) ||
      !(options.diagonal_tolerance >= 1e-9 && options.diagonal_tolerance <= 1)) {
    return Error{ErrorCode::kBadInput,
                 "tolerances must be from 0 to 1 of the value and from 1e-9 to 1 of the diagonal"};
  }
  const Result<Scan> beside = moved_beside(a, b);
  if (!beside) return beside.error();
  const Result<Surface> surface_b = Surface::build(*beside);
  if (!surface_b) return surface_b.error();

  Certified result;
  result.bbox_diagonal = surface_a.bbox_diagonal();
  result.origin = a.origin;
  const double slack = kBoundUlps * std::numeric_limits<double>::epsilon() *
                       std::max(largest_coordinate(a), largest_coordinate(*beside));
  const double least_gap = options.diagonal_tolerance * result.bbox_diagonal;
  context.report("certify", 0.0);
  OneWay forward(a, *surface_b, *beside, options, least_gap, context);
  result.a_to_b = finish(forward.run(), options, slack, least_gap);
  context.report("certify", 0.5);
  OneWay backward(*beside, surface_a, a, options, least_gap, context);
  result.b_to_a = finish(backward.run(), options, slack, least_gap);
  context.report("certify", 1.0);
  if (context.cancelled()) return Error{ErrorCode::kCancelled, "certification cancelled"};
  return result;
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::kLimitExceeded, "not enough memory to compare the surfaces"};
}

Result<Certified> certified_distance(const Scan& a, const Scan& b, const CertifyOptions& options,
                                     const RunContext& context) {
  const Result<Surface> surface_a = Surface::build(a);
  if (!surface_a) return surface_a.error();
  return certified_distance(a, *surface_a, b, options, context);
}

}  // namespace nacre::metric
