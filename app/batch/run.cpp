// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "app/batch/estimate.h"
#include "app/batch/machine.h"
#include "app/batch/runner.h"
#include "app/batch/verbs.h"
#include "app/batch/work_folder.h"
#include "app/exit_code.h"
#include "app/sizes.h"

namespace nacre::app::batch {
namespace {

struct ToDo {
  std::vector<std::size_t> items;
  std::size_t done = 0, failed = 0, foreign = 0;
};

ToDo find_to_do(const Manifest& manifest, const Store& store, const RunCommand& command,
                Console& console) {
  ToDo found;
  for (const std::size_t i : shard_items(manifest, command.shard, command.shard_count)) {
    const Item& item = manifest.items[i];
    if (command.retry_failed) store.forget_failure(item);
    const State state =
        command.overwrite ? State::kToDo : state_of(store, manifest, item, command.verify, false);
    if (state == State::kDone) ++found.done;
    if (state == State::kFailed) ++found.failed;
    if (state == State::kToDo) found.items.push_back(i);
    if (state == State::kForeign) {
      ++found.foreign;
      console.warning(
          fmt::format("{}: exists already and was made by no batch; move it away, or "
                      "use -f to overwrite it",
                      output_path(manifest, item).string()));
    }
  }
  return found;
}

Limits limits_of(const RunCommand& command) {
  Limits limits;
  limits.threads = command.threads > 0 ? command.threads : usable_threads();
  limits.jobs = command.jobs > 0 ? command.jobs : limits.threads;
  const std::uint64_t free = usable_memory();
  limits.bytes =
      command.max_memory.value_or(free > 0 ? free : std::numeric_limits<std::uint64_t>::max());
  return limits;
}

}  // namespace

Result<int> run_shard(const RunCommand& command, Console& console) {
  Result<Manifest> manifest = read_manifest(command.manifest);
  if (!manifest) return manifest.error();
  const Store store(manifest->output_root);
  remove_abandoned(store.work());
  Result<WorkFolder> work = WorkFolder::make(store.work());
  if (!work) return work.error();
  const ToDo to_do = find_to_do(*manifest, store, command, console);
  if (to_do.done + to_do.failed > 0) {
    console.note(fmt::format("{} scans are done already, {} were given up earlier{}", to_do.done,
                             to_do.failed,
                             to_do.failed > 0 ? " (--retry-failed tries them again)" : ""));
  }
  const Limits limits = limits_of(command);
  Runner runner(*manifest, store, command, work->path(), console);
  Result<Runner::Outcome> outcome = runner.run(to_do.items, limits);
  if (!outcome) return outcome.error();
  const std::size_t failed = to_do.failed + to_do.foreign + outcome->failed;
  console.note(fmt::format("{} of {} scans encoded, {} done before, {} failed; peak memory {}{}",
                           outcome->encoded, to_do.items.size(), to_do.done, failed,
                           format_bytes(outcome->peak_bytes),
                           outcome->interrupted ? "; interrupted, run it again to go on" : ""));
  if (outcome->interrupted) return int{kExitInterrupted};
  return failed > 0 ? int{kExitItemsFailed} : int{kExitDone};
}

}  // namespace nacre::app::batch
