// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>

#include "base/result.h"

namespace nacre::app {

/// Watches the process's resident size. Past `limit` it asks the run to stop, as a signal would; if
/// the size goes on growing to half as much again, the process leaves at once with exit code 6.
/// The first look is taken before the constructor returns: a limit below what the program itself
/// takes is always found.
/// Outputs are written last and by rename, so nothing half-made stays behind.
class MemoryGuard {
 public:
  /// limit 0: watches nothing.
  explicit MemoryGuard(std::uint64_t limit);
  ~MemoryGuard();
  MemoryGuard(const MemoryGuard&) = delete;
  MemoryGuard& operator=(const MemoryGuard&) = delete;

  [[nodiscard]] bool exceeded() const { return exceeded_; }
  /// kLimitExceeded, with the remedy.
  [[nodiscard]] Error error() const;

 private:
  /// The resident size, having asked the run to stop if it is past the limit.
  std::uint64_t look();
  void watch();

  std::uint64_t limit_;
  std::atomic<bool> exceeded_{false}, done_{false};
  std::thread thread_;
};

}  // namespace nacre::app
