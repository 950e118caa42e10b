// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/batch/estimate.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <queue>
#include <utility>

namespace nacre::app::batch {
namespace {

// Measured with --threads 1, see README.md. The fixed parts are what coding takes whatever the
// scan: the semi-regular mesh has a size of its own, which grows in steps of four, most for scans
// below some 400,000 triangles.
constexpr double kSecondsPerScan = 8, kSecondsPerTriangle = 1.5e-4;
constexpr std::uint64_t kBytesPerScan = 350'000'000;
constexpr std::uint64_t kBytesPerTriangle = 2'300, kBytesPerFurtherTriangle = 700;
constexpr std::uint64_t kTrianglesAtFirstRate = 400'000;

}  // namespace

double estimated_seconds(const Item& item) {
  return kSecondsPerScan + kSecondsPerTriangle * static_cast<double>(item.triangles);
}

std::uint64_t estimated_bytes(const Item& item) {
  const std::uint64_t first = std::min(item.triangles, kTrianglesAtFirstRate);
  return kBytesPerScan + kBytesPerTriangle * first +
         kBytesPerFurtherTriangle * (item.triangles - first);
}

std::vector<std::size_t> shard_items(const Manifest& manifest, int shard, int shard_count) {
  std::vector<std::size_t> order(manifest.items.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::greater<>(), [&](std::size_t i) {
    return manifest.items[i].triangles;  // the cost grows with it
  });
  using Load = std::pair<double, int>;
  std::priority_queue<Load, std::vector<Load>, std::greater<>> loads;
  for (int s = 0; s < shard_count; ++s) loads.emplace(0.0, s);
  std::vector<std::size_t> mine;
  for (const std::size_t i : order) {
    const auto [load, s] = loads.top();
    loads.pop();
    loads.emplace(load + estimated_seconds(manifest.items[i]), s);
    if (s == shard) mine.push_back(i);
  }
  return mine;
}

}  // namespace nacre::app::batch
