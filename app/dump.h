// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/dump_mesh.h"
#include "app/folds.h"
#include "app/options.h"
#include "base/result.h"
#include "remesh/observer.h"

namespace nacre::app {

/// Writes the steps of a run to a folder each, as soon as they are there: a run that fails later
/// leaves them to be looked at. Each folder has PLY files and a picture.png of them.
///
/// A run is not stopped by a dump that cannot be written: the first such error waits for finish().
class Dumper {
 public:
  /// Nothing is made yet. With `overwrite`, files of the same names are replaced.
  Dumper(DumpSettings settings, bool overwrite);

  /// The cheap checks, before any work. Errors   kBadInput: a step's folder has files and not
  /// `overwrite`. kCannotWrite: the folder cannot be made or written.
  [[nodiscard]] Result<void> check() const;

  void input(const Scan& scan);
  /// Empty where no step of the remesher is wanted. Must not outlive the dumper.
  [[nodiscard]] remesh::Observer observer();
  /// Writes what is left; the first error of all writing.
  [[nodiscard]] Result<void> finish();

 private:
  struct Named {
    std::string name;  ///< of the file
    DumpMesh dump;
  };
  [[nodiscard]] std::filesystem::path folder_of(DumpStage stage) const;
  void cleaned(const remesh::CleanScan& cleaned);
  void base(const Scan& scan, const remesh::Parameterisation& map);
  void normal_mesh(const SemiRegularMesh& mesh, std::span<const std::uint8_t> kind);
  void flush_base();
  void write(DumpStage stage, const std::vector<Named>& meshes);
  void write_file(const std::filesystem::path& file,
                  const Result<std::vector<std::uint8_t>>& bytes);
  void fail(const Result<void>& result);

  DumpSettings settings_;
  bool overwrite_ = false;
  Result<void> first_error_;
  std::optional<FoldCheck> scan_;  // the cleaned one
  std::size_t base_faces_ = 0;     // of the parts seen so far
  DumpMesh base_, parameterisation_;
};

}  // namespace nacre::app
