// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/estimate.h"

#include <fmt/format.h>
#include <tbb/info.h>

#include <algorithm>
#include <cstdio>

#include "app/progress.h"
#include "app/sizes.h"

namespace nacre::app {
namespace {

// Measured on scans of 5,000 to 1,000,000 triangles (bench/README.md of app: --report's seconds and
// peak_bytes). Remeshing goes with the scan; coding and measuring with the semi-regular mesh, whose
// size goes in steps of four and is at least some 160,000 triangles.
constexpr double kSecondsPerScan = 8, kSecondsPerTriangle = 1.5e-4;
constexpr double kRemeshShare = 0.5;     // of the seconds
constexpr double kParallelShare = 0.75;  // of the work, by Amdahl's law
constexpr std::uint64_t kBytesPerScan = 350'000'000;
constexpr std::uint64_t kBytesPerTriangle = 2'300, kBytesPerFurtherTriangle = 700;
constexpr std::uint64_t kTrianglesAtFirstRate = 400'000;

int threads_of(const Common& common) {
  return common.threads > 0 ? common.threads : tbb::info::default_concurrency();
}

}  // namespace

Estimate estimate_of(const InputFacts& input, bool codes, int threads) {
  Estimate out;
  out.triangles = input.faces;
  out.seconds = kSecondsPerScan + kSecondsPerTriangle * static_cast<double>(input.faces);
  if (!codes) out.seconds *= kRemeshShare;
  out.seconds *= 1 - kParallelShare + kParallelShare / std::max(threads, 1);
  const std::uint64_t first = std::min(out.triangles, kTrianglesAtFirstRate);
  out.peak_bytes = kBytesPerScan + kBytesPerTriangle * first +
                   kBytesPerFurtherTriangle * (out.triangles - first);
  return out;
}

std::string describe(const Estimate& estimate, const InputFacts& input, int threads) {
  return fmt::format("{}: {} faces; about {} on {} thread{}, at most about {}; nothing was written",
                     input.file.string(), format_count(estimate.triangles),
                     format_duration(estimate.seconds), threads, threads == 1 ? "" : "s",
                     format_bytes(estimate.peak_bytes));
}

Result<void> check_memory(const Common& common, const InputFacts& input, bool codes) {
  if (common.max_memory_bytes == 0) return {};
  const Estimate estimate = estimate_of(input, codes, threads_of(common));
  if (estimate.peak_bytes <= common.max_memory_bytes) return {};
  return Error{
      ErrorCode::kLimitExceeded,
      fmt::format("{}: {} faces may take up to {}, over --max-memory {}; give it more, or "
                  "simplify the scan first",
                  input.file.string(), format_count(estimate.triangles),
                  format_bytes(estimate.peak_bytes), format_bytes(common.max_memory_bytes))};
}

Result<bool> only_estimates(const Common& common, const InputFacts& input, bool codes) {
  if (common.dry_run) {
    const int threads = threads_of(common);
    const std::string line = describe(estimate_of(input, codes, threads), input, threads) + "\n";
    std::fwrite(line.data(), 1, line.size(), stdout);
  }
  if (Result<void> fits = check_memory(common, input, codes); !fits) return fits.error();
  return common.dry_run;
}

}  // namespace nacre::app
