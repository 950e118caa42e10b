// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/options.h"
#include "base/result.h"

/// A dumped stage is a folder: its payload, files that a run can go on from, and stage.json, which
/// says what they are and what they were when they were written. See docs/STAGES.md.
namespace nacre::app {

inline constexpr const char* kStageSchema = "nacre-stage/1";
inline constexpr const char* kStageRecordName = "stage.json";

/// "05-normal-mesh"
[[nodiscard]] std::string stage_folder_name(DumpStage stage);

struct StageFile {
  std::string name;
  std::vector<std::uint8_t> bytes;
};
using StageFiles = std::vector<StageFile>;

struct StageRecord {
  struct File {
    std::string name, sha256;
    std::uint64_t bytes = 0;
  };
  DumpStage stage = DumpStage::kInput;
  std::string parent;   ///< hash of the stage before it; empty: of none that was dumped
  std::string hash;     ///< SHA-256 over the payload's names and hashes
  std::string key;      ///< of what it depends on: input, options, this build of nacre
  std::string options;  ///< JSON object: those that this stage depends on
  std::string facts;    ///< JSON object: what later stages report of it
  double seconds = 0;
  std::size_t peak_bytes = 0;
  std::vector<File> files;
};

/// A folder as it is now.
struct StageFolder {
  std::filesystem::path folder;
  StageRecord record;
  std::map<std::string, std::vector<std::uint8_t>> files;  ///< the payload
  std::vector<std::string> edited;  ///< names whose content is not what was written
  std::string hash;                 ///< record.hash, unless edited

  [[nodiscard]] bool is_edited(std::string_view name) const;
  /// Errors   kUnreadableFile: it is not there.
  [[nodiscard]] Result<std::span<const std::uint8_t>> file(const std::string& name) const;
};

/// Fills in the record's files and hash and writes all, the record last.
///
/// Returns  the hash. Errors   kCannotWrite, kBadInput as write_output().
[[nodiscard]] Result<std::string> write_stage(const std::filesystem::path& folder,
                                              StageRecord record, const StageFiles& files,
                                              bool overwrite);

/// Reads record and payload. A file that ends in .ply may be missing: the arrays say the same.
///
/// Errors   kUnreadableFile: no such folder, no record, or not of this schema; with the remedy.
[[nodiscard]] Result<StageFolder> open_stage(const std::filesystem::path& folder);

/// What a stage needs of the run's other stages, in the folder beside its own: 03 the map in 04; 07
/// and 08 the mesh in 06. None for the others.
///
/// Errors   as open_stage(), with what it is needed for.
[[nodiscard]] Result<std::optional<StageFolder>> open_beside(const StageFolder& stage);

/// The record alone. Errors   as open_stage().
[[nodiscard]] Result<StageRecord> read_record(const std::filesystem::path& folder);

/// What the stages of a run depend on.
class StageKeys {
 public:
  /// `origin`: hash of what the run starts from.
  void set_origin(std::string origin) { origin_ = std::move(origin); }
  void set_options(DumpStage stage, std::string json) { options_[index(stage)] = std::move(json); }
  [[nodiscard]] const std::string& options(DumpStage stage) const { return options_[index(stage)]; }
  /// Equal for two runs only if the stage is the same in both.
  [[nodiscard]] std::string key(DumpStage stage) const;

 private:
  static std::size_t index(DumpStage stage) { return static_cast<std::size_t>(stage); }
  std::string origin_;
  std::array<std::string, kDumpStageNames.size()> options_;
};

}  // namespace nacre::app
