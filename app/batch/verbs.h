// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "app/batch/command.h"
#include "app/progress.h"
#include "base/result.h"

namespace nacre::app::batch {

/// The exit code of a verb that got through: 0, 8 if some scans failed or are missing, 75 if a
/// signal ended it early. Notes and warnings go to the console, what was asked for to stdout.
[[nodiscard]] Result<int> run_plan(const PlanCommand& command, Console& console);
[[nodiscard]] Result<int> run_shard(const RunCommand& command, Console& console);
[[nodiscard]] Result<int> run_status(const StatusCommand& command, Console& console);
[[nodiscard]] Result<int> run_merge(const MergeCommand& command, Console& console);
[[nodiscard]] Result<int> run_sbatch(const SbatchCommand& command, Console& console);
[[nodiscard]] Result<int> run_folder(const FolderCommand& command, Console& console);

/// Any of them.
[[nodiscard]] Result<int> run_batch(const Verb& verb, Console& console);

}  // namespace nacre::app::batch
