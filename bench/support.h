// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "metric/metric.h"

/// What the benchmarks share: tables as they are printed, child processes, the corpus.
namespace nacre::bench {

/// Prints the command line that was run and the threads it may use, as the head of a table.
void print_head(int argc, const char* const* argv);

/// A markdown table whose rows are printed as they come.
class Table {
 public:
  struct Column {
    std::string name;
    bool is_text = false;  ///< left-aligned
  };
  explicit Table(std::vector<Column> columns) : columns_(std::move(columns)) {}
  void print_header() const;
  /// Missing cells at the end stay empty.
  void print_row(const std::vector<std::string>& cells) const;

 private:
  std::vector<Column> columns_;
};

/// How a child process ended and what it took.
struct ChildRun {
  int exit_code = -1;  ///< -1: it did not exit by itself
  int signal = 0;
  bool timed_out = false;
  double seconds = 0;  ///< wall time
  std::size_t peak_bytes = 0;
  std::string out, err;  ///< all it wrote

  [[nodiscard]] bool ok() const { return exit_code == 0; }
  /// "ok", "exit 5: the last line of stderr", "signal 11 (Segmentation fault)", "over 300 s".
  [[nodiscard]] std::string outcome() const;
};

/// Runs a program to its end, or kills it after `timeout_seconds`. Peak memory counts this
/// process's own as it was at the start, so callers stay small.
[[nodiscard]] ChildRun run_child(const std::vector<std::string>& arguments, double timeout_seconds);

/// A folder under the system's temporary one that is removed with its contents.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// All scans of the corpus folder (tests/support/corpus.h), small files first; empty without one.
[[nodiscard]] std::vector<std::string> corpus_meshes();

/// 20 log10(bounding box diagonal / larger one-sided maximum).
[[nodiscard]] double psnr_of_maximum_db(const metric::Comparison& comparison);

}  // namespace nacre::bench
