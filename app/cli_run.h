// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "app/options.h"
#include "base/result.h"

namespace CLI {
class App;
}

namespace nacre::app {

/// The options of long runs: --progress, --max-memory, --dry-run.
class RunParser {
 public:
  void add_options(CLI::App& verb, Common& common);
  /// Errors   kBadInput: no size.
  [[nodiscard]] Result<void> finish(Common& common) const;

 private:
  std::string progress_ = "auto";
  std::optional<std::string> max_memory_;
};

}  // namespace nacre::app
