// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/batch/estimate.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <queue>
#include <utility>

#include "app/estimate.h"

namespace nacre::app::batch {

double estimated_seconds(const Item& item) { return expected_seconds(item.triangles); }

std::uint64_t estimated_bytes(const Item& item) { return expected_peak_bytes(item.triangles); }

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
