// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "app/options.h"
#include "base/result.h"

namespace CLI {
class App;
}

/// The options of stage dumps, and the verb `stage`.
namespace nacre::app {

class StageParser {
 public:
  /// --dump, --work-dir, --from, --until; the first `stages` of kDumpStageNames can be named.
  void add_options(CLI::App& verb, DumpSettings& settings, std::size_t stages);
  /// Errors   kBadInput, with the remedy: options that do not go together. `has_output`: -o;
  ///          `has_report`: --report.
  [[nodiscard]] Result<void> finish(DumpSettings& settings, std::size_t stages, bool has_output,
                                    bool has_report) const;

  void add_verb(CLI::App& verb);
  [[nodiscard]] Result<StageCommand> finish_verb() const;

 private:
  std::vector<std::string> dump_;
  std::string until_;
  std::string action_;
  std::vector<std::string> folders_;
  bool json_ = false;
};

inline constexpr const char* kStageFooter = R"(Examples:
  nacre encode scan.ply -o scan.ncr --work-dir w --dump all
  nacre stage list w                        what is there, what was edited, time and memory
  nacre stage diff w other                  the first stage that differs, and by how much
  nacre stage diff w/05-normal-mesh other/05-normal-mesh)";

}  // namespace nacre::app
