// SPDX-License-Identifier: GPL-3.0-or-later
#include "data/simulate.h"

#include <cmath>

#include "data/merge.h"
#include "data/random.h"
#include "data/range_view.h"

namespace nacre::data {
namespace {

constexpr std::uint64_t kJitterStream = 1000;
constexpr double kJitter = 0.04;  // of the mean edge: the rest of the noise comes from the views

double mean_edge(const Scan& scan) {
  double sum = 0;
  for (const Triangle& t : scan.triangles)
    for (int k = 0; k < 3; ++k) sum += norm(scan.positions[t[k]] - scan.positions[t[(k + 1) % 3]]);
  return sum / (3.0 * static_cast<double>(scan.triangles.size()));
}

}  // namespace

Result<Scan> simulate_scan(const Target& target, const SimulationOptions& options) {
  const bool in_range = options.turntable_views >= 1 && options.turntable_views <= 90 &&
                        options.view_pixels >= 32 && options.view_pixels <= 4096 &&
                        options.voxels >= 16 && options.voxels <= 512 && options.faces > 100 &&
                        options.pinhole_rounds >= 0 && options.dark_spots >= 0 &&
                        options.dust >= 0 && options.unit > 0 && target.radius > 0 &&
                        target.lipschitz > 0 && target.distance != nullptr;
  if (!in_range) return Error{ErrorCode::kBadInput, "simulate_scan: an option is out of range"};

  const std::vector<RangeView> views = scan_views(target, options);
  Scan scan = merge_views(views, target, options);
  scan = simplify(drop_islands(scan, options.smallest_island), options.faces);
  scan = drop_islands(scan, options.smallest_island);
  if (scan.triangles.empty())
    return Error{ErrorCode::kBadInput, "simulate_scan: no view saw anything"};

  const Random random{options.seed};
  const double jitter = kJitter * mean_edge(scan);
  for (std::size_t v = 0; v < scan.positions.size(); ++v) {
    scan.positions[v] += jitter * random.gaussian3(kJitterStream, v);
    scan.positions[v] *= options.unit;
  }
  return scan;
}

}  // namespace nacre::data
