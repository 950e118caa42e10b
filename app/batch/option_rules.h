// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "app/options.h"
#include "base/result.h"

namespace nacre::app::batch {

/// One option of `nacre encode` as words: {"--size", "6k"}, or {"--some-flag"} alone.
using EncodeOption = std::vector<std::string>;

/// Encode options for the paths that a pattern (glob.h) names.
struct OptionRule {
  std::string pattern;  ///< empty: every path
  std::vector<EncodeOption> options;
};

/// Cuts words as they stand on a command line into options.
/// Errors   kBadInput for a word before the first option.
[[nodiscard]] Result<std::vector<EncodeOption>> split_options(
    const std::vector<std::string>& words);

/// "busts/**=--psnr 75 --levels 6". Words are cut at blanks; there is no quoting.
[[nodiscard]] Result<OptionRule> parse_rule(std::string_view text);

/// A TOML file whose keys are the long names of encode's options:
///
///     size = "50k"            # every scan
///     [[rule]]                # and, in this order, those that match
///     match = "busts/**"
///     psnr = 75
///
/// A true value is a flag; false leaves the option out, also one that an earlier rule gave.
/// Errors   kUnreadableFile with file and line; kBadInput for a value that is no option's.
[[nodiscard]] Result<std::vector<OptionRule>> read_rules(const std::filesystem::path& file);

/// The words for one path: all rules that match in their order, a later option in the place of an
/// earlier one of the same name, sorted by name. All goals count as one name.
[[nodiscard]] std::vector<std::string> options_for(const std::vector<OptionRule>& rules,
                                                   std::string_view path);

/// What `nacre encode SCAN -o OUTPUT` with these words is, read by the parser of the command line.
///
/// Errors   kBadInput: the parser's own message; an option that the batch sets itself.
[[nodiscard]] Result<EncodeCommand> encode_command(const std::vector<std::string>& options,
                                                   const std::filesystem::path& scan,
                                                   const std::filesystem::path& output);

}  // namespace nacre::app::batch
