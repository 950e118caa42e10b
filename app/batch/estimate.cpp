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
// scan; the semi-regular mesh grows in steps of four, so the bytes are those of scans whose finest
// level is dense, and others take half of that or less.
constexpr double kSecondsPerScan = 8, kSecondsPerTriangle = 1.5e-4;
constexpr std::uint64_t kBytesPerScan = 350'000'000, kBytesPerTriangle = 2'300;
constexpr std::uint64_t kMostTriangles = 1'000'000'000'000;  // a header may claim anything

}  // namespace

double estimated_seconds(const Item& item) {
  return kSecondsPerScan + kSecondsPerTriangle * static_cast<double>(item.triangles);
}

std::uint64_t estimated_bytes(const Item& item) {
  return kBytesPerScan + kBytesPerTriangle * std::min(item.triangles, kMostTriangles);
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
