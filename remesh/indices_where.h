// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "base/parallel.h"

namespace nacre::remesh {

/// Those of 0 .. count - 1 that fulfil the condition, ascending; it is asked in parallel.
template <class Condition>
std::vector<std::uint32_t> indices_where(std::size_t count, const Condition& condition) {
  constexpr std::size_t kBlock = 4096;
  std::vector<std::vector<std::uint32_t>> found((count + kBlock - 1) / kBlock);
  parallel_for_each_index(
      found.size(),
      [&](std::size_t b) {
        for (std::size_t i = b * kBlock; i < std::min(count, (b + 1) * kBlock); ++i)
          if (condition(i)) found[b].push_back(static_cast<std::uint32_t>(i));
      },
      1);
  std::vector<std::uint32_t> all;
  for (const auto& block : found) all.insert(all.end(), block.begin(), block.end());
  return all;
}

/// Sorts, and leaves one of each.
inline void make_unique(std::vector<std::uint32_t>& indices) {
  std::sort(indices.begin(), indices.end());
  indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
}

}  // namespace nacre::remesh
