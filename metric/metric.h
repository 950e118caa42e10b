// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
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
};

/// One-sided distance, in model units, from sample points of one surface to the other surface.
/// rms and mean are over the area samples; the maximum is over area samples and vertices.
struct OneSided {
  double rms = 0, mean = 0, maximum = 0;
  Vec3 maximum_at = Vec3::Zero();  ///< on the surface measured from, relative to A's origin
  std::size_t sample_count = 0;    ///< area samples
};

struct Comparison {
  OneSided a_to_b, b_to_a;
  double bbox_diagonal = 0;  ///< of A, the reference (over vertices that lie on a face)
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

/// [LVQ] eq. (7): 20 log10(diagonal / distance), +infinity at distance 0.
[[nodiscard]] double psnr_db(double bbox_diagonal, double rms_distance);

/// Distances up to this many ulps of the largest coordinate count as zero: a sample is
/// a + u (b − a) + v (c − a), at most 6 roundings per coordinate (so < 11 ulps in space), and the
/// foot point on the other surface is computed likewise.
inline constexpr double kRoundingUlps = 32;

}  // namespace nacre::metric
