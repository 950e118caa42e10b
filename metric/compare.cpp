// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <new>

#include "base/parallel.h"
#include "metric/beside.h"
#include "metric/metric.h"
#include "metric/sampling.h"

namespace nacre::metric {
namespace {

constexpr std::size_t kPointsPerBlock = 2048;

constexpr double kHistogramTop = kHistogramEdges - 1;  // the edge that is one diagonal
constexpr double kEdgesPerDecade = 10;

/// Which of the kHistogramEdges + 1 places a distance has.
std::size_t histogram_place(double distance, double diagonal) {
  if (!(distance > 0)) return 0;
  const double edge = std::floor(kEdgesPerDecade * std::log10(distance / diagonal) + kHistogramTop);
  return static_cast<std::size_t>(std::clamp(edge + 1, 0.0, kHistogramTop + 1));
}

/// What one block of points found; blocks are merged in order, so the first of equal maxima wins.
struct Tally {
  double sum = 0, sum_of_squares = 0;
  double maximum = -1;
  Vec3 maximum_at = Vec3::Zero();
  std::array<std::uint64_t, kHistogramEdges + 1> histogram{};

  void add(const Vec3& point, double distance, double diagonal) {
    sum += distance;
    ++histogram[histogram_place(distance, diagonal)];
    sum_of_squares += distance * distance;
    if (distance > maximum) {
      maximum = distance;
      maximum_at = point;
    }
  }
  void merge(const Tally& other) {
    sum += other.sum;
    sum_of_squares += other.sum_of_squares;
    for (std::size_t k = 0; k < histogram.size(); ++k) histogram[k] += other.histogram[k];
    if (other.maximum > maximum) {
      maximum = other.maximum;
      maximum_at = other.maximum_at;
    }
  }
};

struct Scale {
  double zero_below = 0;  ///< distances up to here count as zero
  double diagonal = 0;    ///< of the reference
};

/// Measures `count` points against `to`; for_each_point(begin, end, visit) gives them. The blocks
/// are fixed, so neither the sums nor the hints depend on the threads.
template <class ForEachPoint>
Tally measure(std::size_t count, const Surface& to, const Scale& scale, const RunContext& context,
              const ForEachPoint& for_each_point) {
  // A batch of blocks at a time: a tally is half a kilobyte, and a block may be one of a million.
  constexpr std::size_t kBlocksPerBatch = 4096;
  const std::size_t blocks = (count + kPointsPerBlock - 1) / kPointsPerBlock;
  Tally all;
  for (std::size_t first = 0; first < blocks; first += kBlocksPerBatch) {
    std::vector<Tally> tallies(std::min(kBlocksPerBatch, blocks - first));
    parallel_for_each_index(
        tallies.size(),
        [&](std::size_t b) {
          if (context.cancelled()) return;
          Surface::Nearest last;
          const std::size_t begin = (first + b) * kPointsPerBlock;
          for_each_point(begin, std::min(count, begin + kPointsPerBlock), [&](const Vec3& p) {
            last = to.nearest(p, last);
            tallies[b].add(p, last.distance > scale.zero_below ? last.distance : 0.0,
                           scale.diagonal);
          });
        },
        1);
    for (const Tally& t : tallies) all.merge(t);
  }
  return all;
}

OneSided one_sided(const Scan& from, const Surface& to, const Scale& scale, const Options& options,
                   std::span<const Vec3> places, const RunContext& context) {
  const SurfaceSampler sampler(from, options.samples, options.seed);
  Tally all = measure(sampler.size(), to, scale, context,
                      [&](std::size_t begin, std::size_t end, const auto& visit) {
                        sampler.for_each(begin, end, visit);
                      });
  OneSided result;
  result.sample_count = sampler.size();
  const double n = static_cast<double>(result.sample_count);
  result.mean = all.sum / n;
  result.rms = std::sqrt(all.sum_of_squares / n);
  result.histogram.assign(all.histogram.begin(), all.histogram.end());

  const std::vector<std::uint32_t>& vertices = sampler.vertices();
  all.merge(measure(vertices.size(), to, scale, context,
                    [&](std::size_t begin, std::size_t end, const auto& visit) {
                      for (std::size_t i = begin; i < end; ++i) visit(from.positions[vertices[i]]);
                    }));
  all.merge(measure(places.size(), to, scale, context,
                    [&](std::size_t begin, std::size_t end, const auto& visit) {
                      for (std::size_t i = begin; i < end; ++i) visit(places[i]);
                    }));
  result.maximum = all.maximum;
  result.maximum_at = all.maximum_at;
  return result;
}

}  // namespace

Result<Scan> moved_beside(const Scan& a, const Scan& b) {
  if (!a.origin.allFinite() || !b.origin.allFinite())
    return Error{ErrorCode::kBadInput, "the origin of a surface is not finite"};
  Scan moved = b;
  const Vec3 shift = b.origin - a.origin;
  if (shift != Vec3::Zero())
    for (Vec3& p : moved.positions) p += shift;
  moved.origin = a.origin;
  return moved;
}

double largest_coordinate(const Scan& scan) {
  double largest = 0;
  for (const Triangle& t : scan.triangles)
    for (const std::uint32_t v : t)
      largest = std::max(largest, scan.positions[v].cwiseAbs().maxCoeff());
  return largest;
}

double histogram_edge(int k) { return std::pow(10.0, (k - kHistogramTop) / kEdgesPerDecade); }

double OneSided::quantile(double share, double bbox_diagonal) const {
  const double enough = share * static_cast<double>(sample_count);
  std::uint64_t below = 0;
  for (int k = 0; k < kHistogramEdges && !histogram.empty(); ++k) {
    below += histogram[static_cast<std::size_t>(k)];
    if (static_cast<double>(below) >= enough) return bbox_diagonal * histogram_edge(k);
  }
  return std::numeric_limits<double>::infinity();
}

double psnr_db(double bbox_diagonal, double rms_distance) {
  if (rms_distance == 0) return std::numeric_limits<double>::infinity();
  return 20 * std::log10(bbox_diagonal / rms_distance);
}

Result<Comparison> compare(const Scan& a, const Surface& surface_a, const Scan& b,
                           const Options& options, const RunContext& context) try {
  if (options.samples < 1000 || options.samples > 1'000'000'000)
    return Error{ErrorCode::kBadInput, "samples must be from 1000 to 10^9"};
  const Result<Scan> beside = moved_beside(a, b);
  if (!beside) return beside.error();
  const Scan& b_beside_a = *beside;
  if (const Result<void> ok = check_surface(b_beside_a); !ok) return ok.error();

  const double largest = std::max(largest_coordinate(a), largest_coordinate(b_beside_a));
  const Scale scale = {kRoundingUlps * std::numeric_limits<double>::epsilon() * largest,
                       surface_a.bbox_diagonal()};
  Comparison result;
  context.report("compare", 0.0);
  // One direction waits for a tree that grows on one thread; the other need not.
  Result<void> built;
  in_parallel(
      [&] {
        const Result<Surface> surface_b = Surface::build(b_beside_a);
        if (surface_b)
          result.a_to_b = one_sided(a, *surface_b, scale, options, options.places, context);
        else
          built = surface_b.error();
      },
      [&] { result.b_to_a = one_sided(b_beside_a, surface_a, scale, options, {}, context); });
  if (!built) return built.error();
  context.report("compare", 1.0);
  if (context.cancelled()) return Error{ErrorCode::kCancelled, "comparison cancelled"};

  result.bbox_diagonal = scale.diagonal;
  result.origin = a.origin;
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
