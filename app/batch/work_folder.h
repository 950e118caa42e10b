// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "base/result.h"

namespace nacre::app::batch {

/// A folder for one process's unfinished files, below Store::work(). It is locked for as long as
/// the process or a child of it lives; what is found unlocked was left by a killed one.
class WorkFolder {
 public:
  /// Errors   kCannotWrite.
  [[nodiscard]] static Result<WorkFolder> make(const std::filesystem::path& below);
  ~WorkFolder();
  WorkFolder(WorkFolder&& other) noexcept;
  WorkFolder& operator=(WorkFolder&&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  WorkFolder(std::filesystem::path path, int lock) : path_(std::move(path)), lock_(lock) {}
  std::filesystem::path path_;
  int lock_ = -1;
};

/// Removes what killed processes left. Those of this machine go at once; of another machine, whose
/// locks a network file system may not show, after a day.
void remove_abandoned(const std::filesystem::path& below);

/// How many processes have work there now, as far as locks tell.
[[nodiscard]] int count_live(const std::filesystem::path& below);

}  // namespace nacre::app::batch
