// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/cli_stages.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>

namespace nacre::app {
namespace {

std::vector<std::string> first_names(std::size_t stages) {
  return {kDumpStageNames.begin(), kDumpStageNames.begin() + static_cast<std::ptrdiff_t>(stages)};
}

Error usage_error(std::string message) { return {ErrorCode::kBadInput, std::move(message)}; }

}  // namespace

void StageParser::add_options(CLI::App& verb, DumpSettings& settings, std::size_t stages) {
  std::vector<std::string> names = first_names(stages);
  verb.add_option("--until", until_,
                  "Stop after this stage, which is dumped; no other output is made")
      ->check(CLI::IsMember(names));
  auto* dump = verb.add_option("--dump", dump_,
                               fmt::format("Write these stages down, to look at, to edit and to go "
                                           "on from: all, or some of {}",
                                           fmt::join(names, ",")));
  names.emplace_back("all");
  dump->delimiter(',')->allow_extra_args(false)->check(CLI::IsMember(names));
  verb.add_option("--work-dir", settings.work_dir,
                  "Where: DIR/02-clean and so on; made if missing. Stages that are there already "
                  "from the same input and options are used");
  verb.add_option("--from", settings.from,
                  "Go on from this dumped stage, edited or not, e.g. DIR/05-normal-mesh; only what "
                  "comes after it is made");
}

Result<void> StageParser::finish(DumpSettings& settings, std::size_t stages, bool has_output,
                                 bool has_report) const {
  const bool all = std::ranges::find(dump_, "all") != dump_.end();
  for (std::size_t i = 0; i < stages; ++i) {
    const std::string_view name = kDumpStageNames[i];
    settings.stages[i] = all || std::ranges::find(dump_, name) != dump_.end();
    if (until_ != name) continue;
    settings.until = static_cast<DumpStage>(i);
    settings.stages[i] = true;
  }
  const bool has_folder = !settings.work_dir.empty();
  if (!dump_.empty() && !has_folder)
    return usage_error("--dump needs --work-dir, the folder to write to");
  if (settings.until && !has_folder)
    return usage_error("--until needs --work-dir, the folder to write the stage to");
  if (has_folder && dump_.empty() && !settings.until)
    return usage_error("--work-dir needs --dump, the stages to write there, e.g. --dump all");
  if (settings.until && has_output)
    return usage_error("--until stops before the output is made; leave out -o");
  if (settings.until && has_report)
    return usage_error("--until stops before there is anything to report; leave out --report");
  if (!settings.until && !has_output)
    return usage_error("-o is required: the file to write (or --until, to stop before it)");
  return {};
}

void StageParser::add_verb(CLI::App& verb) {
  verb.add_option("ACTION", action_, "list or diff")
      ->required()
      ->check(CLI::IsMember({"list", "diff"}));
  verb.add_option("DIR", folders_,
                  "The --work-dir of a run, or the folder of one stage; diff takes two")
      ->required()
      ->expected(1, 2);
  verb.add_flag("--json", json_, "Print JSON");
}

Result<StageCommand> StageParser::finish_verb() const {
  StageCommand command;
  command.json = json_;
  const std::size_t wanted = action_ == "diff" ? 2 : 1;
  if (folders_.size() != wanted)
    return usage_error(fmt::format("stage {} takes {} (see nacre stage --help)", action_,
                                   wanted == 2 ? "two folders" : "one folder"));
  command.a = folders_[0];
  if (wanted == 2) command.b = folders_[1];
  return command;
}

}  // namespace nacre::app
