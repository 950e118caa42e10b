// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <string_view>

namespace nacre {

/// What a long stage needs from its caller besides its input. Copy freely; all members are optional.
/// The thread count is that of the TBB arena the caller runs the stage in.
struct RunContext {
  /// Told the stage's name and its share done, 0 .. 1; called from one thread at a time.
  std::function<void(std::string_view stage, double fraction)> progress;
  /// Once true, stages return kCancelled at the next opportunity.
  const std::atomic<bool>* cancel = nullptr;

  [[nodiscard]] bool cancelled() const { return cancel != nullptr && cancel->load(); }
  void report(std::string_view stage, double fraction) const {
    if (progress) progress(stage, fraction);
  }
};

}  // namespace nacre
