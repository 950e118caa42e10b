// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/cli_prefix.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <utility>

#include "app/sizes.h"

namespace nacre::app {

Result<ErrorGoal> parse_error_goal(const std::string& text) {
  ErrorGoal goal;
  std::string_view number = text;
  goal.is_percent = number.ends_with('%');
  if (goal.is_percent) number.remove_suffix(1);
  while (goal.is_percent && number.ends_with(' ')) number.remove_suffix(1);
  const char* end = number.data() + number.size();
  const auto parsed = std::from_chars(number.data(), end, goal.value);
  if (parsed.ec == std::errc() && parsed.ptr == end && goal.value > 0 && goal.value < 1e300)
    return goal;
  return Error{ErrorCode::kBadInput,
               fmt::format("'{}' is not an error: 0.05 (model units) or 0.02% (of the bounding "
                           "box's diagonal)",
                           text)};
}

void PrefixParser::add_options(CLI::App& verb, const char* size_option, const char* size_help) {
  size_option_ = size_option;
  auto* level = verb.add_option("--level", level_, "No further than this level, 0 = base mesh");
  level->check(CLI::Range(0, 30));
  auto* size = verb.add_option(size_option, size_, size_help)->excludes(level);
  verb.add_option("--max-error", max_error_,
                  "The coarsest level within this distance of the scan, both ways: 0.05 in model "
                  "units, or 0.02% of the diagonal; needs a level table (see nacre info)")
      ->excludes(level)
      ->excludes(size);
}

Result<PrefixChoice> PrefixParser::finish() const {
  PrefixChoice choice;
  choice.level = level_;
  if (size_) {
    const Result<std::uint64_t> bytes = parse_size(*size_);
    if (!bytes) return Error{ErrorCode::kBadInput, size_option_ + ": " + bytes.error().message};
    choice.bytes = *bytes;
  }
  if (max_error_) {
    const Result<ErrorGoal> goal = parse_error_goal(*max_error_);
    if (!goal) return Error{ErrorCode::kBadInput, "--max-error: " + goal.error().message};
    choice.max_error = *goal;
  }
  return choice;
}

void PrefixParser::add_cut(CLI::App& verb, CutCommand& command) {
  verb.add_option("FILE", command.stream, "The .ncr file")->required();
  verb.add_option("-o,--output", command.output, "The .ncr file to write")->required();
  add_options(verb, "--size", "The whole file, never exceeded: 6061, 6k (= 6000), 6Ki (= 6144)");
  verb.add_flag("--partial", command.partial,
                "Accept a file cut short: make a whole one of what is there");
}

Result<CutCommand> PrefixParser::finish_cut(CutCommand command) const {
  const Result<PrefixChoice> choice = finish();
  if (!choice) return choice.error();
  command.choice = *choice;
  if (command.choice.is_all() && !command.partial) {
    return Error{
        ErrorCode::kBadInput,
        "where to cut? name one of --size, --level and --max-error (see nacre cut --help)"};
  }
  return command;
}

}  // namespace nacre::app
