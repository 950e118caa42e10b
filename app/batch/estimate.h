// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "app/batch/manifest.h"

/// What encoding a scan is expected to take, from its triangle count alone (app/estimate.h).
namespace nacre::app::batch {

/// Seconds on one thread, within a factor of about three.
[[nodiscard]] double estimated_seconds(const Item& item);

/// Peak resident bytes, on the safe side for most scans.
[[nodiscard]] std::uint64_t estimated_bytes(const Item& item);

/// Which items belong to a shard, largest first: each item, by falling cost, goes to the shard with
/// the least so far (ties: the lower index), so every process that is told the same manifest and
/// count cuts it in the same way.
///
/// Ensures  (1) the shards 0 .. shard_count-1 hold each item exactly once
///          (2) no shard's cost exceeds the mean by more than the cost of the largest item
[[nodiscard]] std::vector<std::size_t> shard_items(const Manifest& manifest, int shard,
                                                   int shard_count);

}  // namespace nacre::app::batch
