// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "app/batch/child.h"
#include "app/batch/command.h"
#include "app/batch/manifest.h"
#include "app/batch/record.h"
#include "app/batch/schedule.h"
#include "app/progress.h"
#include "base/result.h"

namespace nacre::app::batch {

/// Failed attempts after which a scan is given up.
inline constexpr int kMostAttempts = 3;

/// Encodes the items that are to do, each in a process of its own. Uses one thread itself.
class Runner {
 public:
  struct Outcome {
    std::size_t encoded = 0, failed = 0;
    bool interrupted = false;
    std::uint64_t peak_bytes = 0;  ///< of all processes together, sampled
  };

  /// All four must outlive it; `work` is this process's folder in the output root.
  Runner(const Manifest& manifest, const Store& store, const RunCommand& command,
         std::filesystem::path work, Console& console);

  /// Errors   kCannotWrite: no state can be kept, or no process started.
  [[nodiscard]] Result<Outcome> run(const std::vector<std::size_t>& items, const Limits& limits);

 private:
  struct Active {
    Child child;
    std::filesystem::path work;
    std::chrono::steady_clock::time_point begin;
    std::uint64_t peak_bytes = 0;
    bool over_memory = false, alone = false, timed_out = false;
  };

  Result<void> start_what_may();
  Result<void> start(const Job& job);
  Result<void> reap();
  Result<void> ended(std::size_t item, const ChildEnd& end, const Active& active);
  Result<void> failed(std::size_t item, const ChildEnd& end, const Active& active);
  void finished_well(std::size_t item, const Active& active);
  void watch();
  void watch_memory();
  void share_threads();
  void stop_all();
  [[nodiscard]] std::string place(std::size_t item) const;

  const Manifest& manifest_;
  const Store& store_;
  const RunCommand& command_;
  std::filesystem::path work_;
  Console& console_;
  Limits limits_;
  Schedule schedule_{{}, {}};
  std::map<std::size_t, Active> active_;  ///< by item
  std::size_t started_ = 0, total_ = 0;
  double seconds_done_ = 0, seconds_total_ = 0;
  bool stopping_ = false, killed_ = false;
  std::chrono::steady_clock::time_point stop_begin_;
  Outcome outcome_;
};

}  // namespace nacre::app::batch
