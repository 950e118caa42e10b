// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "app/options.h"
#include "app/progress.h"
#include "base/result.h"
#include "base/scan.h"
#include "metric/metric.h"

/// The level table of a coded scan: each prefix decoded, and measured against the scan as read.
namespace nacre::app {

/// Bytes of a file to keep free for its level table; 0: none is written. kAuto writes one that
/// takes at most 1 % of the file.
[[nodiscard]] std::size_t reserved_table_bytes(LevelTableMode mode, codec::Profile profile,
                                               int levels, std::uint64_t target_bytes);

struct LevelTableOptions {
  std::size_t samples = 500'000;  ///< of the finest level; coarser ones take kCoarseSamples at most
  /// What is known of the finest level already, measured with `samples`.
  std::optional<metric::Comparison> finest;
  std::optional<metric::Certified> finest_certified;
};

/// A coarse level's RMS is known to well below the table's 0.05 dB from so many samples.
inline constexpr std::size_t kCoarseSamples = 100'000;

/// Puts a level table into `stream`, which grows by what reserved_table_bytes() said. PSNR is
/// sampled as `compare` does it; maximum errors are certified bounds, at most 1 % over the true
/// ones before rounding. A table that is there is replaced; a certified error stays.
///
/// Errors   kGeometryRefused: the scan has no surface; kCancelled; kNoConvergence: the stream does
///          not decode.
[[nodiscard]] Result<void> fill_level_table(std::vector<std::uint8_t>& stream, const Scan& scan,
                                            const LevelTableOptions& options, Console& console);

}  // namespace nacre::app
