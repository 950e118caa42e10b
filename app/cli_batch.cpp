// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/cli_batch.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <string_view>
#include <utility>

#include "app/cli_number.h"
#include "app/sizes.h"

namespace nacre::app {
namespace {

constexpr const char* kFooter = R"(Examples:
  nacre batch scans/ out/                         every scan below scans/, in one line
  nacre batch scans/ out/ -- --size 50k           options of nacre encode for all of them
  nacre batch scans/ out/ --rule 'busts/**=--bits-per-vertex 2'
  nacre batch plan scans/ -o job/manifest.jsonl   in steps: the list of what to do, to look at,
  nacre batch run job/manifest.jsonl              the work, on one machine
  nacre batch run job/manifest.jsonl --shard 3/8  or an eighth of it on each of eight,
  nacre batch merge job/manifest.jsonl            and the summary
  nacre batch sbatch job/manifest.jsonl > job/nacre.sbatch   the same for Slurm
Run again, it does what is missing: scans that are new or changed, or whose options did.
A scan that fails stops no other. summary.html, .csv, .json and failed.jsonl say what happened.
Exit codes: 0 all done, 8 some scans failed, 75 interrupted (run it again), others as for encode.)";

constexpr const char* kRulesHelp =
    "TOML file of encode options: `size = \"50k\"` for all, [[rule]] tables with match = "
    "\"PATTERN\"";

Error usage_error(std::string message) { return {ErrorCode::kBadInput, std::move(message)}; }

/// "3/8" as two counts.
bool parse_shard(std::string_view text, int& shard, int& count) {
  const char* end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, shard);
  if (first.ec != std::errc() || first.ptr == end || *first.ptr != '/') return false;
  const auto second = std::from_chars(first.ptr + 1, end, count);
  return second.ec == std::errc() && second.ptr == end && shard >= 0 && shard < count;
}

}  // namespace

CLI::App* BatchParser::add_verb(CLI::App* app, const char* name, const char* description) {
  CLI::App* verb = app->add_subcommand(name, description);
  auto* quiet = verb->add_flag("-q,--quiet", quiet_, "Print warnings and errors only");
  verb->add_flag("-v,--verbose", verbose_, "Print more")->excludes(quiet);
  return verb;
}

void BatchParser::add_plan_options(CLI::App* verb, batch::PlanCommand& plan) {
  verb->add_option("--include", plan.include,
                   "Only scans that match: *.ply, busts/**, part?.stl; default: .ply .obj .off "
                   ".stl; may be repeated")
      ->allow_extra_args(false);
  verb->add_option("--exclude", plan.exclude, "No scans that match; may be repeated")
      ->allow_extra_args(false);
  verb->add_option("--options", plan.options_file, kRulesHelp);
  verb->add_option("--rule", plan.rules,
                   "PATTERN=OPTIONS: encode options for scans that match, over those of the file "
                   "and those after --; may be repeated, the last wins")
      ->allow_extra_args(false);
}

void BatchParser::add_run_options(CLI::App* verb, batch::RunCommand& run, bool sharded) {
  if (sharded) {
    verb->add_option("--shard", raw_.shard,
                     "K/N: only this one of N parts of about equal cost, K from 0 to N-1");
  }
  verb->add_option("--jobs", run.jobs, "Scans at once; default: one per thread")
      ->check(CLI::Range(1, 1024));
  verb->add_option("--threads", threads_,
                   "Threads, all scans together; default: all that the process may use")
      ->check(CLI::Range(1, 1024));
  verb->add_option("--max-memory", raw_.max_memory,
                   "Memory of all scans together, e.g. 8G; default: nine tenths of what is free");
  verb->add_option("--timeout", run.timeout_seconds, "Seconds after which a scan is given up")
      ->check(positive_number());
  verb->add_flag("--verify", run.verify,
                 "Read every input to see whether it changed; default: only if its size or time "
                 "did");
  verb->add_flag("--retry-failed", run.retry_failed, "Try scans again that were given up");
  verb->add_flag("-f,--force", run.overwrite,
                 "Encode everything again, and overwrite outputs of any origin");
}

void BatchParser::add_to(CLI::App& app) {
  batch_ = add_verb(&app, "batch", "Encode many scans: a folder, or a share of it on a cluster");
  batch_->footer(kFooter);
  batch_->require_subcommand(0, 1);
  batch_->add_option("IN", folder_.plan.source,
                     "A folder of scans, or a text file with one scan a line (- for stdin)");
  batch_->add_option("OUT", out_dir_, "The folder for the outputs; mirrors IN");
  add_plan_options(batch_, folder_.plan);
  add_run_options(batch_, folder_.run, false);

  CLI::App* plan = add_verb(batch_, "plan", "Write the list of what to do: one JSON line per scan");
  plan->add_option("IN", plan_.source, "A folder of scans, or a list of them (- for stdin)")
      ->required();
  plan->add_option("-o,--output", plan_.manifest, "The manifest to write")->required();
  plan->add_option("--output-dir", plan_.output_dir,
                   "The folder for the outputs; default: `ncr` beside the manifest");
  add_plan_options(plan, plan_);
  plan->add_flag("-f,--force", plan_.overwrite, "Overwrite the manifest");

  CLI::App* run = add_verb(batch_, "run", "Encode what the manifest lists and is not done yet");
  run->add_option("MANIFEST", run_.manifest, "Made by nacre batch plan")->required();
  add_run_options(run, run_, true);

  CLI::App* status = add_verb(batch_, "status", "Say how far it is, and what failed");
  status->add_option("MANIFEST", status_.manifest)->required();
  status->add_flag("--verify", status_.verify, "Read every input to see whether it changed");
  status->add_flag("--json", status_.json, "Print JSON");

  CLI::App* merge =
      add_verb(batch_, "merge", "Write summary.html, summary.csv, summary.json and failed.jsonl");
  merge->add_option("MANIFEST", merge_.manifest)->required();
  merge->add_option("-o,--output", merge_.folder, "Folder for them; default: that of the outputs");

  CLI::App* sbatch = add_verb(batch_, "sbatch", "Print a Slurm array script for the manifest");
  sbatch->add_option("MANIFEST", sbatch_.manifest)->required();
  sbatch->add_option("--shards", sbatch_.shards, "Array tasks; default: about 15 minutes each")
      ->check(CLI::Range(1, 1'000'000));
  sbatch->add_option("--cpus", sbatch_.cpus, "Processors of each task")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  sbatch->add_option("--max-memory", raw_.max_memory,
                     "Memory of each task, e.g. 4Gi; default: what the largest scan needs");
}

Result<void> BatchParser::finish_run(batch::RunCommand& run) const {
  run.threads = threads_;
  if (raw_.shard && !parse_shard(*raw_.shard, run.shard, run.shard_count)) {
    return usage_error(
        fmt::format("--shard '{}' is not K/N with 0 <= K < N, e.g. 0/8 up to 7/8", *raw_.shard));
  }
  if (!raw_.max_memory) return {};
  Result<std::uint64_t> bytes = parse_size(*raw_.max_memory);
  if (!bytes) return usage_error("--max-memory: " + bytes.error().message);
  run.max_memory = *bytes;
  return {};
}

Result<BatchCommand> BatchParser::finish(std::vector<std::string> encode_options) {
  BatchCommand command;
  command.common.verbosity = quiet_     ? Verbosity::kQuiet
                             : verbose_ ? Verbosity::kVerbose
                                        : Verbosity::kNormal;
  const std::vector<CLI::App*> verbs = batch_->get_subcommands();
  const std::string verb = verbs.empty() ? "" : verbs.front()->get_name();
  if (!encode_options.empty() && !verb.empty() && verb != "plan") {
    return usage_error("encode options after -- belong to nacre batch plan, or to IN OUT");
  }
  if (verb == "plan") {
    plan_.encode_options = std::move(encode_options);
    command.verb = plan_;
  } else if (verb == "run") {
    if (Result<void> ok = finish_run(run_); !ok) return ok.error();
    command.verb = run_;
  } else if (verb == "status") {
    command.verb = status_;
  } else if (verb == "merge") {
    command.verb = merge_;
  } else if (verb == "sbatch") {
    batch::RunCommand sizes;
    if (Result<void> ok = finish_run(sizes); !ok) return ok.error();
    sbatch_.max_memory = sizes.max_memory;
    command.verb = sbatch_;
  } else {
    if (folder_.plan.source.empty() || out_dir_.empty()) {
      return usage_error(
          "which scans, and where to? nacre batch IN OUT, or one of plan, run, status, merge, "
          "sbatch (see nacre batch --help)");
    }
    if (Result<void> ok = finish_run(folder_.run); !ok) return ok.error();
    folder_.plan.output_dir = out_dir_;
    folder_.plan.manifest = folder_.plan.output_dir / ".nacre" / "manifest.jsonl";
    folder_.plan.encode_options = std::move(encode_options);
    command.verb = folder_;
  }
  return command;
}

}  // namespace nacre::app
