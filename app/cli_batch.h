// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/options.h"
#include "base/result.h"

namespace CLI {
class App;
}

namespace nacre::app {

/// The part of the command line behind `nacre batch`: verbs of its own, and IN OUT for all at once.
class BatchParser {
 public:
  /// Must outlive the parse, and stay where it is.
  void add_to(CLI::App& app);

  /// What was parsed. `encode_options` are the words after "--".
  /// Errors   kBadInput: a size, a shard or a combination that makes no sense.
  [[nodiscard]] Result<BatchCommand> finish(std::vector<std::string> encode_options);

 private:
  struct Raw {
    std::optional<std::string> shard, max_memory;
  };
  void add_plan_options(CLI::App* verb, batch::PlanCommand& plan);
  void add_run_options(CLI::App* verb, batch::RunCommand& run, bool sharded);
  CLI::App* add_verb(CLI::App* app, const char* name, const char* description);
  Result<void> finish_run(batch::RunCommand& run) const;

  CLI::App* batch_ = nullptr;
  Raw raw_;
  bool quiet_ = false, verbose_ = false;
  int threads_ = 0;
  batch::FolderCommand folder_;
  std::string out_dir_;
  batch::PlanCommand plan_;
  batch::RunCommand run_;
  batch::StatusCommand status_;
  batch::MergeCommand merge_;
  batch::SbatchCommand sbatch_;
};

}  // namespace nacre::app
