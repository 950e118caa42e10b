// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <system_error>
#include <utility>

#include "app/batch/estimate.h"
#include "app/batch/plan.h"
#include "app/batch/summary.h"
#include "app/batch/verbs.h"
#include "app/batch/work_folder.h"
#include "app/exit_code.h"
#include "app/files.h"
#include "app/json.h"
#include "app/sizes.h"

namespace nacre::app::batch {
namespace {

namespace fs = std::filesystem;

}  // namespace

Result<int> run_merge(const MergeCommand& command, Console& console) {
  Result<Manifest> manifest = read_manifest(command.manifest);
  if (!manifest) return manifest.error();
  const Store store(manifest->output_root);
  remove_abandoned(store.work());
  const std::vector<Row> rows = collect(*manifest, store, false);
  const fs::path folder = command.folder.empty() ? manifest->output_root : command.folder;
  std::error_code failed;
  fs::create_directories(folder, failed);  // write_output says why, if it failed
  // Made anew from the records at every merge, so there is nothing of anybody's to overwrite.
  const std::array<std::pair<const char*, std::string>, 4> files = {
      {{"summary.html", summary_html(rows)},
       {"summary.csv", summary_csv(rows)},
       {"summary.json", summary_json(rows)},
       {"failed.jsonl", failed_json_lines(rows)}}};
  for (const auto& [name, text] : files) {
    if (Result<void> ok = write_output(folder / name, text, true); !ok) return ok.error();
  }
  const Totals t = totals_of(rows);
  console.note(fmt::format("{}: {} of {} scans done, {} failed, {} missing; {} -> {}",
                           (folder / "summary.html").string(), t.done, t.scans,
                           t.failed + t.foreign, t.missing, format_bytes(t.input_bytes),
                           format_bytes(t.output_bytes)));
  return t.done == t.scans ? int{kExitDone} : int{kExitItemsFailed};
}

Result<int> run_status(const StatusCommand& command, Console&) {
  Result<Manifest> manifest = read_manifest(command.manifest);
  if (!manifest) return manifest.error();
  const Store store(manifest->output_root);
  const std::vector<Row> rows = collect(*manifest, store, command.verify);
  const Totals t = totals_of(rows);
  double left = 0;
  for (const Row& row : rows) {
    if (row.state == State::kToDo) left += estimated_seconds(row.item);
  }
  const int live = count_live(store.work());
  if (command.json) {
    const Json json = {{"schema", "nacre-batch-status/0"},
                       {"scans", t.scans},
                       {"done", t.done},
                       {"failed", t.failed},
                       {"foreign", t.foreign},
                       {"missing", t.missing},
                       {"processes", live},
                       {"estimated_seconds_left", left}};
    std::fputs(dump_json(json).c_str(), stdout);
  } else {
    std::fputs(
        fmt::format("{} scans: {} done, {} failed, {} to do (about {:.1f} hours on one "
                    "thread); {} processes at work\n",
                    format_count(t.scans), format_count(t.done), format_count(t.failed + t.foreign),
                    format_count(t.missing), left / 3600, live)
            .c_str(),
        stdout);
    for (const Row& row : rows) {
      if (row.state == State::kDone || (row.state == State::kToDo && !row.failure)) continue;
      std::fputs(
          fmt::format("{}: {}: {}\n", name_of(row.state), row.item.scan, reason(row)).c_str(),
          stdout);
    }
  }
  return t.failed + t.foreign > 0 ? int{kExitItemsFailed} : int{kExitDone};
}

Result<int> run_folder(const FolderCommand& command, Console& console) {
  Result<Manifest> manifest = make_plan(command.plan, console);
  if (!manifest) return manifest.error();
  const fs::path file = command.plan.manifest;
  std::error_code failed;
  fs::create_directories(file.parent_path(), failed);  // write_output says why, if it failed
  // Kept so that status, run and merge can be used on this batch as well.
  if (Result<void> ok = write_output(file, to_json_lines(*manifest), true); !ok) return ok.error();
  RunCommand run = command.run;
  run.manifest = file;
  Result<int> code = run_shard(run, console);
  if (!code || *code == kExitInterrupted) return code;
  return run_merge({file, {}}, console);
}

Result<int> run_batch(const Verb& verb, Console& console) {
  struct Visitor {
    Console& console;
    Result<int> operator()(const PlanCommand& c) const { return run_plan(c, console); }
    Result<int> operator()(const RunCommand& c) const { return run_shard(c, console); }
    Result<int> operator()(const StatusCommand& c) const { return run_status(c, console); }
    Result<int> operator()(const MergeCommand& c) const { return run_merge(c, console); }
    Result<int> operator()(const SbatchCommand& c) const { return run_sbatch(c, console); }
    Result<int> operator()(const FolderCommand& c) const { return run_folder(c, console); }
  };
  return std::visit(Visitor{console}, verb);
}

}  // namespace nacre::app::batch
