// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cstddef>
#include <vector>

/// Loops whose result does not depend on the number of threads. Encoder side only: links TBB.
namespace nacre {

/// Calls body(i) for i in [0, count), in any order; iterations must write disjoint outputs.
template <class Body>
void parallel_for_each_index(std::size_t count, const Body& body, std::size_t grain = 256) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i != range.end(); ++i) body(i);
                    });
}

/// Calls both, at the same time where a thread is free; they must not write what the other reads.
template <class One, class Other>
void in_parallel(const One& one, const Other& other) {
  tbb::parallel_invoke(one, other);
}

/// Σ term(i) for i in [0, count) over a fixed partition: the same bits at any thread count.
/// T needs a zero-initialised T{} and operator+=.
template <class T, class Term>
T deterministic_sum(std::size_t count, const Term& term, std::size_t block = 4096) {
  const std::size_t blocks = (count + block - 1) / block;
  std::vector<T> partial(blocks, T{});
  parallel_for_each_index(
      blocks,
      [&](std::size_t b) {
        const std::size_t end = std::min(count, (b + 1) * block);
        for (std::size_t i = b * block; i < end; ++i) partial[b] += term(i);
      },
      1);
  T total{};
  for (const T& p : partial) total += p;
  return total;
}

}  // namespace nacre
