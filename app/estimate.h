// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "app/options.h"
#include "app/report.h"
#include "base/result.h"

/// What a run is expected to take, from counts alone. It balances work and keeps memory; no output
/// depends on it.
namespace nacre::app {

/// Seconds of an encode on one thread, within a factor of about three. `finest`: triangles that the
/// goal asks of the finest level at least (RemeshSettings::least_triangles), if known.
[[nodiscard]] double expected_seconds(std::uint64_t triangles, std::uint64_t finest = 0);

/// Peak resident bytes of an encode, on the safe side for most scans.
[[nodiscard]] std::uint64_t expected_peak_bytes(std::uint64_t triangles, std::uint64_t finest = 0);

/// For encode (`codes`) or remesh, once the scan is read: holds what it may take against
/// --max-memory. True if that was all (--dry-run), and the estimate is on stdout.
///
/// Errors   kLimitExceeded: more than common.max_memory_bytes, with what is expected.
[[nodiscard]] Result<bool> only_estimates(const Common& common, const InputFacts& input, bool codes,
                                          std::uint64_t finest = 0);

}  // namespace nacre::app
