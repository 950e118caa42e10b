// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>

#include "app/options.h"
#include "app/report.h"
#include "base/result.h"

/// What a run is expected to take, from counts alone.
namespace nacre::app {

struct Estimate {
  double seconds = 0;            ///< within a factor of about two on the machine it was measured on
  std::uint64_t peak_bytes = 0;  ///< on the safe side for most scans
  std::uint64_t triangles = 0;   ///< of the scan
};

/// Of encode (`codes`) or remesh, on so many threads.
[[nodiscard]] Estimate estimate_of(const InputFacts& input, bool codes, int threads);

/// "scan.ply: 96,966 faces; about 25 s on 2 threads, at most 480 MB; nothing was written"
[[nodiscard]] std::string describe(const Estimate& estimate, const InputFacts& input, int threads);

/// Errors   kLimitExceeded: more than common.max_memory_bytes, with what is expected.
[[nodiscard]] Result<void> check_memory(const Common& common, const InputFacts& input, bool codes);

/// To be called once the scan is read: true if that was all, and the estimate is on stdout.
/// Errors   kLimitExceeded.
[[nodiscard]] Result<bool> only_estimates(const Common& common, const InputFacts& input,
                                          bool codes);

}  // namespace nacre::app
