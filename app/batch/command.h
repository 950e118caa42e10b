// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

/// What a `nacre batch` command line asks for, as plain values.
namespace nacre::app::batch {

/// Which scans, where their outputs go, and how each is encoded.
struct PlanCommand {
  std::filesystem::path source;      ///< a folder, or a text file with one scan a line; "-": stdin
  std::filesystem::path manifest;    ///< to write
  std::filesystem::path output_dir;  ///< empty: "ncr" beside the manifest
  /// Patterns over the path below `source`, see glob.h. No `include`: every known extension.
  std::vector<std::string> include, exclude;
  std::filesystem::path options_file;       ///< TOML, see option_rules.h; empty: none
  std::vector<std::string> rules;           ///< "PATTERN=OPTIONS", after those of the file
  std::vector<std::string> encode_options;  ///< for all, e.g. {"--size", "6k"}
  bool overwrite = false;                   ///< the manifest
};

struct RunCommand {
  std::filesystem::path manifest;
  int shard = 0, shard_count = 1;           ///< 0 <= shard < shard_count
  int jobs = 0;                             ///< scans at once; 0: as many as threads
  int threads = 0;                          ///< all scans together; 0: the affinity mask's
  std::optional<std::uint64_t> max_memory;  ///< bytes of all scans together; none: most of the free
  double timeout_seconds = 0;               ///< for one scan; 0: none
  bool verify = false;        ///< hash every input again, though its size and time are as recorded
  bool retry_failed = false;  ///< forget earlier failed attempts
  bool overwrite = false;     ///< encode everything again, over outputs of any origin
};

struct StatusCommand {
  std::filesystem::path manifest;
  bool verify = false;
  bool json = false;
};

struct MergeCommand {
  std::filesystem::path manifest;
  std::filesystem::path folder;  ///< for summary.* and failed.jsonl; empty: the output folder
};

struct SbatchCommand {
  std::filesystem::path manifest;
  int shards = 0;                           ///< 0: from the estimated cost
  int cpus = 1;                             ///< of each shard
  std::optional<std::uint64_t> max_memory;  ///< of each shard; none: from the largest scan
};

/// `nacre batch IN OUT`: plan, run and merge.
struct FolderCommand {
  PlanCommand plan;
  RunCommand run;
};

using Verb = std::variant<PlanCommand, RunCommand, StatusCommand, MergeCommand, SbatchCommand,
                          FolderCommand>;

}  // namespace nacre::app::batch
