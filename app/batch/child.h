// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

#include "base/result.h"

namespace nacre::app::batch {

/// How a child process ended.
struct ChildEnd {
  int exit_code = 0;  ///< 128 + signal if it was killed
  int signal = 0;
};

/// A piece of work in a process of its own: what it does to memory, and how it ends, is its own
/// affair. It dies with this process, whatever kills that, and is the first to go when the machine
/// runs out of memory.
class Child {
 public:
  /// Runs `work(threads)` in a copy of this process, which must have one thread, and leaves with
  /// its result as the exit code. stderr goes to a file. Errors   kCannotWrite: no process, no
  /// file.
  [[nodiscard]] static Result<Child> start(const std::function<int()>& work, int threads,
                                           const std::filesystem::path& stderr_file);

  /// How it ended, if it has.
  [[nodiscard]] std::optional<ChildEnd> poll();
  [[nodiscard]] std::uint64_t resident_bytes() const;
  void send(int signal) const;
  /// From now on; more or fewer, felt within a tenth of a second.
  void set_threads(int threads) { threads_->store(threads, std::memory_order_relaxed); }

 private:
  /// In memory that both processes see.
  using SharedInt = std::unique_ptr<std::atomic<int>, void (*)(std::atomic<int>*)>;
  Child(pid_t pid, SharedInt threads) : pid_(pid), threads_(std::move(threads)) {}

  pid_t pid_;
  SharedInt threads_;
};

/// Resident bytes of a process now; 0 if it is gone.
[[nodiscard]] std::uint64_t resident_bytes(pid_t pid);

}  // namespace nacre::app::batch
