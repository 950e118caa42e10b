// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "app/options.h"
#include "base/result.h"

namespace CLI {
class App;
}

/// The options that choose a prefix of a .ncr file, and the verb `cut`.
namespace nacre::app {

/// "0.05" in model units, "0.02%" of the diagonal.
///
/// Errors   kBadInput for anything that is no positive number.
[[nodiscard]] Result<ErrorGoal> parse_error_goal(const std::string& text);

class PrefixParser {
 public:
  /// --level, --max-error, and the size by the name given; at most one of them.
  void add_options(CLI::App& verb, const char* size_option, const char* size_help);
  /// Errors   kBadInput.
  [[nodiscard]] Result<PrefixChoice> finish() const;

  /// The verb, with a PrefixParser's options of its own; -o, -f and the rest come from elsewhere.
  void add_cut(CLI::App& verb, CutCommand& command);
  [[nodiscard]] Result<CutCommand> finish_cut(CutCommand command) const;

 private:
  int level_ = -1;
  std::string size_option_;
  std::optional<std::string> size_, max_error_;
};

inline constexpr const char* kCutFooter = R"(Examples:
  nacre cut scan.ncr --size 50k -o small.ncr      as fine as 50,000 bytes hold, without coding anew
  nacre cut scan.ncr --level 3 -o coarse.ncr
  nacre cut scan.ncr --max-error 0.5% -o rough.ncr    the coarsest level that is near enough
A file is a chain of levels, coarse to fine; what is cut off is its end. `nacre info` lists the
levels, with their errors if the file has a level table.)";

}  // namespace nacre::app
