// SPDX-License-Identifier: GPL-3.0-or-later
//
// Prints, and calls nothing: partition, account and limits are the site's and the user's.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <system_error>

#include "app/batch/estimate.h"
#include "app/batch/manifest.h"
#include "app/batch/verbs.h"
#include "app/exit_code.h"

namespace nacre::app::batch {
namespace {

namespace fs = std::filesystem;

constexpr double kSecondsPerShard = 15 * 60;
constexpr int kMostShards = 1000;  // sites allow indices up to 1000 unless they say otherwise
// Estimates are within a factor of three; a shard out of time is requeued and goes on.
constexpr double kTimeMargin = 3;
constexpr double kLeastSeconds = 10 * 60;
constexpr std::uint64_t kMi = std::uint64_t{1} << 20;

/// In quotes that a shell leaves alone.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

std::string script(const std::string& nacre, const std::string& manifest, int shards, int cpus,
                   std::uint64_t memory_mi, int minutes) {
  return fmt::format(
      R"(#!/bin/bash
# Made by: nacre batch sbatch. Submit it, and the summary after it, with
#   job=$(sbatch --parsable nacre.sbatch)
#   sbatch --dependency=afterany:$job --mem=1G --wrap {merge}
# Partition, account and the like: sbatch options, SBATCH_* variables or further #SBATCH lines.
#SBATCH --job-name=nacre
#SBATCH --array=0-{last}
#SBATCH --cpus-per-task={cpus}
#SBATCH --mem={memory}M
#SBATCH --time={minutes}
#SBATCH --output=nacre-%A_%a.log
#SBATCH --open-mode=append
#SBATCH --requeue
#SBATCH --signal=B:TERM@60
nacre={nacre}
manifest={manifest}
# A shard may be run twice, by whatever accident: outputs are the same and appear whole.
"$nacre" batch run "$manifest" --shard "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT" \
  --threads "$SLURM_CPUS_PER_TASK" --max-memory {limit}Mi &
child=$!
# Slurm sends TERM a minute before the time is over; nacre then stops with 75, "try again".
trap 'kill -TERM "$child"' TERM
wait "$child"; code=$?
while kill -0 "$child" 2>/dev/null; do wait "$child"; code=$?; done
if [ "$code" -eq 75 ]; then
  trap - TERM  # with which the requeue ends this script
  for try in 1 2 3 4 5; do  # a busy controller answers later; it then ends this script
    scontrol requeue "${{SLURM_ARRAY_JOB_ID}}_$SLURM_ARRAY_TASK_ID" && sleep 60
    sleep 5
  done
fi
exit "$code"
)",
      fmt::arg("merge", quoted(quoted(nacre) + " batch merge " + quoted(manifest))),
      fmt::arg("last", shards - 1), fmt::arg("cpus", cpus), fmt::arg("memory", memory_mi),
      fmt::arg("minutes", minutes), fmt::arg("nacre", quoted(nacre)),
      fmt::arg("manifest", quoted(manifest)), fmt::arg("limit", memory_mi / 20 * 19));
}

}  // namespace

Result<int> run_sbatch(const SbatchCommand& command, Console&) {
  Result<Manifest> manifest = read_manifest(command.manifest);
  if (!manifest) return manifest.error();
  double seconds = 0;
  std::uint64_t largest = 0;
  for (const Item& item : manifest->items) {
    seconds += estimated_seconds(item);
    largest = std::max(largest, estimated_bytes(item));
  }
  const int most = std::clamp(static_cast<int>(manifest->items.size()), 1, kMostShards);
  const int cut = static_cast<int>(
      std::clamp(std::ceil(seconds / kSecondsPerShard / command.cpus), 1.0, 1.0 * most));
  const int shards = command.shards > 0 ? command.shards : cut;
  const std::uint64_t memory_mi = command.max_memory.value_or(largest + largest / 10) / kMi + 1;
  double longest = 0;
  for (int s = 0; s < shards; ++s) {
    double shard_seconds = 0;
    for (const std::size_t i : shard_items(*manifest, s, shards)) {
      shard_seconds += estimated_seconds(manifest->items[i]);
    }
    longest = std::max(longest, shard_seconds);
  }
  const double allowed = std::max(kLeastSeconds, kTimeMargin * longest / command.cpus);
  std::error_code failed;
  const fs::path self = fs::read_symlink("/proc/self/exe", failed);
  std::fputs(script(failed ? "nacre" : self.string(), fs::absolute(command.manifest).string(),
                    shards, command.cpus, memory_mi, static_cast<int>(std::ceil(allowed / 60)))
                 .c_str(),
             stdout);
  return int{kExitDone};
}

}  // namespace nacre::app::batch
