// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "base/result.h"
#include "base/run_context.h"
#include "base/scan.h"

/// Distance between two surfaces. See README.md.
namespace nacre::metric {

struct Options {
  /// Area samples in each direction, beside all vertices that lie on a face. Stratified over the
  /// faces by area; about 1 µs each on one thread. Range 1000 .. 10^9.
  std::size_t samples = 500'000;
  /// Places the samples inside their faces. Any value; the same value gives the same result.
  std::uint64_t seed = 1;
  /// Points of A, relative to its origin, that count for its maximum as its vertices do.
  std::vector<Vec3> places = {};
};

/// One-sided distance, in model units, from sample points of one surface to the other surface.
/// rms and mean are over the area samples; the maximum is over area samples, vertices and places.
struct OneSided {
  double rms = 0, mean = 0, maximum = 0;
  Vec3 maximum_at = Vec3::Zero();  ///< on the surface measured from, relative to A's origin
  std::size_t sample_count = 0;    ///< area samples
  /// Area samples by distance, on a logarithmic scale: histogram[0] has those nearer than
  /// histogram_edge(0) diagonals of A, [k] those from histogram_edge(k − 1) up to
  /// histogram_edge(k), the last those from one diagonal on.
  std::vector<std::uint64_t> histogram;
  /// Least histogram edge, times the diagonal, that at least `share` of the samples lie below;
  /// infinite if it is beyond the last edge.
  [[nodiscard]] double quantile(double share, double bbox_diagonal) const;
};

/// Edges are a tenth of a decade apart (2 dB), from 10^-7 to 1.
inline constexpr int kHistogramEdges = 71;
/// 10^(k / 10 − 7), as a share of A's diagonal; k < kHistogramEdges.
[[nodiscard]] double histogram_edge(int k);

struct Comparison {
  OneSided a_to_b, b_to_a;
  double bbox_diagonal = 0;    ///< of A, the reference (over vertices that lie on a face)
  Vec3 origin = Vec3::Zero();  ///< of A: what places are relative to
  /// 20 log10(diagonal / max(rms a→b, rms b→a)), [LVQ] eq. (7); +infinity for equal surfaces.
  double psnr_db = 0;
};

/// Surface prepared for nearest-point queries; immutable, safe to share between threads. About
/// 150 bytes per triangle. Faces without area are left out: they bound no surface.
class Surface {
 public:
  /// Errors   kBadInput if a corner index is out of range, a coordinate is not finite or beyond
  ///          10^75, or no triangle has an area; `where` is the vertex or the triangle.
  static Result<Surface> build(const Scan& scan);

  struct Nearest {
    Vec3 point = Vec3::Zero();
    std::uint32_t triangle = kNone;  ///< index in the scan; the first found of equally near ones
    double distance = 0;
  };
  /// Queries and answers are relative to the origin of the scan that the surface was built from.
  /// A query that is not finite is infinitely far from triangle kNone.
  [[nodiscard]] Nearest nearest(const Vec3& query) const;
  /// The same, quicker when `nearby` is the answer to a query close to this one.
  [[nodiscard]] Nearest nearest(const Vec3& query, const Nearest& nearby) const;
  /// One distance per query, in order; quickest when neighbours in the list are neighbours in
  /// space. Parallel.
  [[nodiscard]] std::vector<double> distances(std::span<const Vec3> queries) const;

  /// Of the bounding box of all vertices that lie on a face with an area.
  [[nodiscard]] double bbox_diagonal() const;

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

/// Both one-sided distances as Metro and MESH measure them; A is the reference. Deterministic at
/// any thread count. The two origins may differ. A distance below the rounding of the coordinates
/// (kRoundingUlps) counts as zero, so a surface compared with itself has infinite PSNR.
///
/// Errors   as Surface::build; kBadInput for options out of range; kCancelled.
/// Source   [CignoniRocchiniScopigno1998] sampling; [AspertSantaCruzEbrahimi2002] rms by area.
[[nodiscard]] Result<Comparison> compare(const Scan& a, const Scan& b, const Options& options = {},
                                         const RunContext& context = {});

/// The same for one reference and many candidates: surface_a is *Surface::build(a), made once.
[[nodiscard]] Result<Comparison> compare(const Scan& a, const Surface& surface_a, const Scan& b,
                                         const Options& options = {},
                                         const RunContext& context = {});

struct CertifyOptions {
  /// A direction is done once its bounds differ by at most this share of the value, 0 .. 1 ...
  double relative_tolerance = 0.01;
  /// ... or by this share of the diagonal of A, 1e-9 .. 1. Halving it doubles the cost where the
  /// surfaces nearly agree, and only there.
  double diagonal_tolerance = 1e-5;
  /// Model units: a direction stops as soon as it is known to be farther. Its upper bound holds
  /// all the same, but may be loose.
  double give_up_above = std::numeric_limits<double>::infinity();
  /// Pieces of faces looked at in one direction, about 1 µs and no lasting memory each; what is
  /// then left gets a bound that is not refined.
  std::size_t max_pieces = 200'000'000;
};

/// Bounds of the one-sided Hausdorff distance, model units: lower <= max over p of d(p, surface)
/// <= upper.
struct CertifiedOneSided {
  double lower = 0, upper = 0;
  Vec3 lower_at = Vec3::Zero();   ///< where `lower` was met, relative to A's origin
  std::size_t pieces = 0;         ///< looked at
  bool within_tolerance = false;  ///< the bounds are as near as asked for
};

struct Certified {
  CertifiedOneSided a_to_b, b_to_a;
  double bbox_diagonal = 0;    ///< of A
  Vec3 origin = Vec3::Zero();  ///< of A: what places are relative to
  /// Of the two-sided Hausdorff distance.
  [[nodiscard]] double lower() const { return std::max(a_to_b.lower, b_to_a.lower); }
  [[nodiscard]] double upper() const { return std::max(a_to_b.upper, b_to_a.upper); }
  [[nodiscard]] bool within_tolerance() const {
    return a_to_b.within_tolerance && b_to_a.within_tolerance;
  }
};

/// Two-sided Hausdorff distance with proof, for any two triangle soups: branch and bound over the
/// faces (certify.cpp). Rounding is in the bounds. Deterministic at any thread count.
///
/// Errors   as compare().
/// Source   [GutheBorodinKlein2005]
[[nodiscard]] Result<Certified> certified_distance(const Scan& a, const Surface& surface_a,
                                                   const Scan& b,
                                                   const CertifyOptions& options = {},
                                                   const RunContext& context = {});
[[nodiscard]] Result<Certified> certified_distance(const Scan& a, const Scan& b,
                                                   const CertifyOptions& options = {},
                                                   const RunContext& context = {});

/// [LVQ] eq. (7): 20 log10(diagonal / distance), +infinity at distance 0.
[[nodiscard]] double psnr_db(double bbox_diagonal, double rms_distance);

/// Distances up to this many ulps of the largest coordinate count as zero: a sample is
/// a + u (b − a) + v (c − a), at most 6 roundings per coordinate (so < 11 ulps in space), and the
/// foot point on the other surface is computed likewise.
inline constexpr double kRoundingUlps = 32;

}  // namespace nacre::metric
