// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include "base/parallel.h"
#include "metric/metric.h"
#include "metric/sampling.h"

namespace nacre::metric {
namespace {

constexpr std::size_t kPointsPerBlock = 2048;

/// What one block of points found; blocks are merged in order, so the first of equal maxima wins.
struct Tally {
  double sum = 0, sum_of_squares = 0;
  double maximum = -1;
  Vec3 maximum_at = Vec3::Zero();

  void add(const Vec3& point, double distance) {
    sum += distance;
    sum_of_squares += distance * distance;
    if (distance > maximum) {
      maximum = distance;
      maximum_at = point;
    }
  }
  void merge(const Tally& other) {
    sum += other.sum;
    sum_of_squares += other.sum_of_squares;
    if (other.maximum > maximum) {
      maximum = other.maximum;
      maximum_at = other.maximum_at;
    }
  }
};

/// Measures `count` points against `to`; for_each_point(begin, end, visit) gives them. The blocks
/// are fixed, so neither the sums nor the hints depend on the threads.
template <class ForEachPoint>
Tally measure(std::size_t count, const Surface& to, double zero_below, const RunContext& context,
              const ForEachPoint& for_each_point) {
  std::vector<Tally> tallies((count + kPointsPerBlock - 1) / kPointsPerBlock);
  parallel_for_each_index(
      tallies.size(),
      [&](std::size_t b) {
        if (context.cancelled()) return;
        Surface::Nearest last;
        const std::size_t end = std::min(count, (b + 1) * kPointsPerBlock);
        for_each_point(b * kPointsPerBlock, end, [&](const Vec3& p) {
          last = to.nearest(p, last);
          tallies[b].add(p, last.distance > zero_below ? last.distance : 0.0);
        });
      },
      1);
  Tally all;
  for (const Tally& t : tallies) all.merge(t);
  return all;
}

OneSided one_sided(const Scan& from, const Surface& to, double zero_below, const Options& options,
                   const RunContext& context) {
  const SurfaceSampler sampler(from, options.samples, options.seed);
  Tally all = measure(sampler.size(), to, zero_below, context,
                      [&](std::size_t begin, std::size_t end, const auto& visit) {
                        sampler.for_each(begin, end, visit);
                      });
  OneSided result;
  result.sample_count = sampler.size();
  const double n = static_cast<double>(result.sample_count);
  result.mean = all.sum / n;
  result.rms = std::sqrt(all.sum_of_squares / n);

  const std::vector<std::uint32_t>& vertices = sampler.vertices();
  all.merge(measure(vertices.size(), to, zero_below, context,
                    [&](std::size_t begin, std::size_t end, const auto& visit) {
                      for (std::size_t i = begin; i < end; ++i) visit(from.positions[vertices[i]]);
                    }));
  result.maximum = all.maximum;
  result.maximum_at = all.maximum_at;
  return result;
}

Scan moved_to_origin(Scan scan, const Vec3& origin) {
  const Vec3 shift = scan.origin - origin;
  if (shift != Vec3::Zero())
    for (Vec3& p : scan.positions) p += shift;
  scan.origin = origin;
  return scan;
}

double largest_coordinate(const Scan& scan) {
  double largest = 0;
  for (const Triangle& t : scan.triangles)
    for (const std::uint32_t v : t)
      largest = std::max(largest, scan.positions[v].cwiseAbs().maxCoeff());
  return largest;
}

}  // namespace

double psnr_db(double bbox_diagonal, double rms_distance) {
  if (rms_distance == 0) return std::numeric_limits<double>::infinity();
  return 20 * std::log10(bbox_diagonal / rms_distance);
}

Result<Comparison> compare(const Scan& a, const Surface& surface_a, const Scan& b,
                           const Options& options, const RunContext& context) try {
  if (options.samples < 1000 || options.samples > 1'000'000'000)
    return Error{ErrorCode::kBadInput, "samples must be from 1000 to 10^9"};
  if (!a.origin.allFinite() || !b.origin.allFinite())
    return Error{ErrorCode::kBadInput, "the origin of a surface is not finite"};
  const Scan b_beside_a = moved_to_origin(b, a.origin);
  const Result<Surface> surface_b = Surface::build(b_beside_a);
  if (!surface_b) return surface_b.error();

  const double zero_below = kRoundingUlps * std::numeric_limits<double>::epsilon() *
                            std::max(largest_coordinate(a), largest_coordinate(b_beside_a));
  Comparison result;
  context.report("compare", 0.0);
  result.a_to_b = one_sided(a, *surface_b, zero_below, options, context);
  context.report("compare", 0.5);
  result.b_to_a = one_sided(b_beside_a, surface_a, zero_below, options, context);
  context.report("compare", 1.0);
  if (context.cancelled()) return Error{ErrorCode::kCancelled, "comparison cancelled"};

  result.bbox_diagonal = surface_a.bbox_diagonal();
  result.psnr_db = psnr_db(result.bbox_diagonal, std::max(result.a_to_b.rms, result.b_to_a.rms));
  return result;
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::kLimitExceeded, "not enough memory to compare the surfaces"};
}

Result<Comparison> compare(const Scan& a, const Scan& b, const Options& options,
                           const RunContext& context) {
  const Result<Surface> surface_a = Surface::build(a);
  if (!surface_a) return surface_a.error();
  return compare(a, *surface_a, b, options, context);
}

}  // namespace nacre::metric
