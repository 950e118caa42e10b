// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/cli_run.h"

#include <CLI/CLI.hpp>

#include "app/sizes.h"

namespace nacre::app {

void RunParser::add_options(CLI::App& verb, Common& common) {
  verb.add_option("--progress", progress_,
                  "auto: a bar where stderr is a terminal; json: lines of JSON on stderr; none")
      ->check(CLI::IsMember({"auto", "json", "none"}))
      ->capture_default_str();
  verb.add_option("--max-memory", max_memory_,
                  "Refuse or stop, with exit code 6, what takes more than this: 800M, 4Gi");
  verb.add_flag("--dry-run", common.dry_run,
                "Print about how long it would take and how much memory, and write nothing");
}

Result<void> RunParser::finish(Common& common) const {
  common.progress = progress_ == "json"   ? ProgressStyle::kJson
                    : progress_ == "none" ? ProgressStyle::kNone
                                          : ProgressStyle::kAuto;
  if (!max_memory_) return {};
  const Result<std::uint64_t> bytes = parse_size(*max_memory_);
  if (!bytes) return Error{ErrorCode::kBadInput, "--max-memory: " + bytes.error().message};
  common.max_memory_bytes = *bytes;
  return {};
}

}  // namespace nacre::app
