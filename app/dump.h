// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/dump_mesh.h"
#include "app/folds.h"
#include "app/options.h"
#include "app/stage_files.h"
#include "base/result.h"
#include "remesh/observer.h"

namespace nacre::app {

/// Writes the stages of a run to a folder each, as soon as they are there: a run that fails later
/// leaves them to be looked at. Each folder has arrays and stage.json to go on from, PLY files and
/// a picture.png of them to look at. Also knows where a run starts and stops.
///
/// A run is not stopped by a dump that cannot be written: the first such error waits for finish().
/// A stage that is there already, from the same input and options, is left alone; so are those up
/// to where the run starts.
class Dumper {
 public:
  /// Nothing is made yet. With `overwrite`, files of the same names are replaced.
  Dumper(DumpSettings settings, bool overwrite);

  /// The cheap checks, before any work; opens the stage to start from. Errors   kBadInput: a
  /// step's folder has files that no run has dumped and not `overwrite`, or curves were edited to
  /// start from. kCannotWrite: the folder cannot be made or written. kUnreadableFile: what to start
  /// from is no stage.
  [[nodiscard]] Result<void> check();
  /// With the options (JSON) that this stage depends on.
  void set_options(DumpStage stage, std::string json) { keys_.set_options(stage, std::move(json)); }
  /// What all depends on. Errors   kBadInput: a stage is there from another input, other options,
  /// or was edited, and not `overwrite`.
  [[nodiscard]] Result<void> begin(const Scan& scan);

  /// Where the run starts if not at the scan.
  [[nodiscard]] const StageFolder* entry() const { return entry_ ? &*entry_ : nullptr; }
  /// The stage beside the entry that it needs, see open_beside(); null: none.
  [[nodiscard]] const StageFolder* beside() const { return beside_ ? &*beside_ : nullptr; }
  [[nodiscard]] bool starts_at_or_after(DumpStage stage) const {
    return entry_ && entry_->record.stage >= stage;
  }
  [[nodiscard]] bool stops_after(DumpStage stage) const { return settings_.until == stage; }
  [[nodiscard]] bool wants(DumpStage stage) const { return settings_.wants(stage); }
  /// The latest stage of the remesher that is there already and need not be made again; none if
  /// an earlier one is asked for and is not there.
  [[nodiscard]] std::optional<StageFolder> reusable() const;

  /// What later records repeat; to be kept up to date.
  [[nodiscard]] StageFacts& facts() { return facts_; }

  void input(const Scan& scan);
  /// Empty where no step of the remesher is wanted. Must not outlive the dumper.
  [[nodiscard]] remesh::Observer observer();
  /// Where the remesher was entered behind its cleaning: the surface that folds are judged by.
  void surface(const Scan& cleaned);
  void coefficients(const SemiRegularMesh& mesh, wavelet::Transform transform);
  void coded(const codec::Encoded& encoded, const codec::EncodeOptions& options);
  /// Writes what has waited for facts.
  void flush();
  /// Writes what is left; the first error of all writing.
  [[nodiscard]] Result<void> finish();

 private:
  struct Named {
    std::string name;  ///< of the file
    DumpMesh dump;
  };
  /// All of a stage: what it is to go on from, and what it looks like.
  struct Pending {
    StageFiles files;
    std::vector<Named> meshes;
    double seconds = 0;
    [[nodiscard]] bool empty() const { return files.empty() && meshes.empty(); }
  };
  [[nodiscard]] std::filesystem::path folder_of(DumpStage stage) const;
  [[nodiscard]] bool is_to_be_written(DumpStage stage) const;
  [[nodiscard]] bool is_current(DumpStage stage) const;
  [[nodiscard]] Result<void> open_entry();
  [[nodiscard]] Result<void> check_folder(DumpStage stage, bool known_key) const;
  void cleaned(const remesh::CleanScan& cleaned);
  void base(const Scan& scan, const remesh::Parameterisation& map);
  void normal_mesh(const SemiRegularMesh& mesh, std::span<const std::uint8_t> kind);
  void write(DumpStage stage, Pending pending);
  void write_pictures(DumpStage stage, const std::vector<Named>& meshes);
  void write_file(const std::filesystem::path& file,
                  const Result<std::vector<std::uint8_t>>& bytes);
  void fail(const Result<void>& result);
  [[nodiscard]] double lap();

  DumpSettings settings_;
  bool overwrite_ = false;
  Result<void> first_error_;
  std::optional<StageFolder> entry_, beside_;
  StageKeys keys_;
  StageFacts facts_;
  std::string last_hash_;
  std::optional<FoldCheck> scan_;  // the cleaned one
  std::size_t base_faces_ = 0;     // of the parts seen so far
  Pending base_, parameterisation_, normal_mesh_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace nacre::app
