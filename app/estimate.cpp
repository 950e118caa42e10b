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

// Measured, see README.md here and in batch/. Memory goes with the finest level. That has as many
// triangles as are asked for, or up to four times that, and small scans have other meshes tried.
constexpr double kSecondsPerScan = 8, kSecondsPerTriangle = 1.5e-4;
constexpr double kRemeshShare = 0.5;     // of the seconds
constexpr double kParallelShare = 0.75;  // of the work, by Amdahl's law
constexpr std::uint64_t kLeastBytes = 400'000'000, kBytesPerMesh = 150'000'000;
/// For each triangle that is asked for.
constexpr std::uint64_t kBytesPerFinest = 960;
/// The remesher gives this many finest triangles for one of the scan in any case, and no goal more.
constexpr double kUsualFinest = 2.5, kMostFinest = 16;
constexpr std::uint64_t kMostTriangles = 1'000'000'000'000;  // a header may claim anything

struct Estimate {
  double seconds = 0;
  std::uint64_t peak_bytes = 0;
  std::uint64_t triangles = 0;
};

int threads_of(const Common& common) {
  return common.threads > 0 ? common.threads : tbb::info::default_concurrency();
}

/// Of encode (`codes`) or remesh, from counts alone.
Estimate estimate_of(const InputFacts& input, bool codes, std::uint64_t finest, int threads) {
  Estimate out;
  out.triangles = input.faces;
  out.seconds = expected_seconds(input.faces, finest);
  if (!codes) out.seconds *= kRemeshShare;
  out.seconds *= 1 - kParallelShare + kParallelShare / std::max(threads, 1);
  out.peak_bytes = expected_peak_bytes(input.faces, finest);
  return out;
}

/// "scan.ply: 96,966 faces; about 25 s on 2 threads, at most 480 MB; nothing was written"
std::string describe(const Estimate& estimate, const InputFacts& input, int threads) {
  return fmt::format("{}: {} faces; about {} on {} thread{}, at most about {}; nothing was written",
                     input.file.string(), format_count(estimate.triangles),
                     format_duration(estimate.seconds), threads, threads == 1 ? "" : "s",
                     format_bytes(estimate.peak_bytes));
}

Result<void> check_memory(const Estimate& estimate, const Common& common, const InputFacts& input) {
  if (common.max_memory_bytes == 0 || estimate.peak_bytes <= common.max_memory_bytes) return {};
  return Error{
      ErrorCode::kLimitExceeded,
      fmt::format("{}: {} faces may take up to {}, over --max-memory {}; give it more, or "
                  "simplify the scan first",
                  input.file.string(), format_count(estimate.triangles),
                  format_bytes(estimate.peak_bytes), format_bytes(common.max_memory_bytes))};
}

}  // namespace

double expected_seconds(std::uint64_t triangles, std::uint64_t finest) {
  const auto scan = static_cast<double>(triangles);
  const double asked = std::min(static_cast<double>(finest), kMostFinest * scan);
  return kSecondsPerScan + kSecondsPerTriangle * std::max(scan, asked / kUsualFinest);
}

std::uint64_t expected_peak_bytes(std::uint64_t triangles, std::uint64_t finest) {
  triangles = std::min(triangles, kMostTriangles);
  const auto usual = static_cast<std::uint64_t>(kUsualFinest * static_cast<double>(triangles));
  const auto most = static_cast<std::uint64_t>(kMostFinest) * triangles;
  return std::max(kLeastBytes,
                  kBytesPerMesh + kBytesPerFinest * std::max(usual, std::min(finest, most)));
}

Result<bool> only_estimates(const Common& common, const InputFacts& input, bool codes,
                            std::uint64_t finest) {
  const int threads = threads_of(common);
  const Estimate estimate = estimate_of(input, codes, finest, threads);
  if (common.dry_run) {
    const std::string line = describe(estimate, input, threads) + "\n";
    std::fwrite(line.data(), 1, line.size(), stdout);
  }
  if (Result<void> fits = check_memory(estimate, common, input); !fits) return fits.error();
  return common.dry_run;
}

}  // namespace nacre::app
