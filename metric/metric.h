// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

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
  /// faces by area; about 4 µs each. Range >= 1000.
  std::size_t samples = 500'000;
  std::uint64_t seed = 1;
};

/// One-sided distance, in model units, from sample points of one surface to the other surface.
/// rms and mean are over the area samples; the maximum is over area samples and vertices.
struct OneSided {
  double rms = 0, mean = 0, maximum = 0;
  Vec3 maximum_at = Vec3::Zero();
  std::size_t sample_count = 0;
};

struct Comparison {
  OneSided a_to_b, b_to_a;
  double bbox_diagonal = 0;  ///< of A, the reference (over vertices that lie on a face)
  /// 20 log10(diagonal / max(rms a→b, rms b→a)), [LVQ] eq. (7); +infinity for equal surfaces.
  double psnr_db = 0;
};

/// Surface prepared for nearest-point and line queries; immutable, safe to share between threads.
class Surface {
 public:
  /// Errors   kBadInput if there is no triangle of positive area... or a coordinate is not finite.
  static Result<Surface> build(const Scan& scan);
  struct Nearest {
    Vec3 point;
    std::uint32_t triangle = kNone;
    double distance = 0;
  };
  [[nodiscard]] Nearest nearest(const Vec3& query) const;
  [[nodiscard]] std::vector<double> distances(std::span<const Vec3> queries) const;

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

/// Both one-sided distances as Metro and MESH measure them; A is the reference. Deterministic at any
/// thread count. The two origins may differ.
[[nodiscard]] Result<Comparison> compare(const Scan& a, const Scan& b, const Options& options = {},
                                         const RunContext& context = {});

}  // namespace nacre::metric
