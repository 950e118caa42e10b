// SPDX-License-Identifier: GPL-3.0-or-later
//
// No list of encode's options here: words go to the parser of the command line, so that a new
// option of encode works in a manifest on the day it exists. Only the goals are named, because one
// replaces another, and what the batch sets itself.
#include "app/batch/option_rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <sstream>
#include <variant>

#include "app/batch/glob.h"
#include "app/cli.h"
#define TOML_HEADER_ONLY 1
#define TOML_EXCEPTIONS 0
#define TOML_ENABLE_FORMATTERS 0
#include <toml++/toml.h>

namespace nacre::app::batch {
namespace {

constexpr std::array<std::string_view, 6> kGoals = {
    "--size", "--bits-per-vertex", "--bits-per-semi-regular-vertex",
    "--psnr", "--max-error",       "--quality"};
constexpr std::array<std::string_view, 17> kOwn = {
    "-o",     "--output",  "-f",        "--force",    "-q",          "--quiet",
    "-v",     "--verbose", "--report",  "--dump",     "--work-dir",  "--threads",
    "--from", "--until",   "--dry-run", "--progress", "--max-memory"};
/// Marks an option that a rule takes away again.
constexpr const char* kRemoved = "\0removed";

Error bad(std::string message) { return {ErrorCode::kBadInput, std::move(message)}; }

/// "--size" of "--size=6k".
std::string_view name_of(const EncodeOption& option) {
  const std::string_view word = option.front();
  return word.starts_with("--") ? word.substr(0, word.find('=')) : word;
}

/// A minus before a digit is a number, not an option.
bool is_option(std::string_view word) {
  return word.size() > 1 && word[0] == '-' && !(word[1] >= '0' && word[1] <= '9') && word[1] != '.';
}

Result<std::string> value_word(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* integer = node.as_integer()) return fmt::format("{}", integer->get());
  if (const auto* real = node.as_floating_point()) return fmt::format("{}", real->get());
  return bad("is neither text, number nor true/false");
}

Result<OptionRule> rule_of(const toml::table& table, const std::string& file, bool top) {
  OptionRule rule;
  for (const auto& [key, node] : table) {
    const std::string name(key.str());
    if (top && name == "rule") continue;
    const std::size_t line = node.source().begin.line;
    if (!top && name == "match") {
      const auto* pattern = node.as_string();
      if (pattern == nullptr || pattern->get().empty()) {
        return bad(fmt::format("{}: line {}: 'match' must be a pattern in quotes", file, line));
      }
      rule.pattern = pattern->get();
      continue;
    }
    EncodeOption option = {"--" + name};
    if (const auto* flag = node.as_boolean()) {
      if (!flag->get()) option.emplace_back(kRemoved, 8);
    } else {
      Result<std::string> value = value_word(node);
      if (!value) {
        return bad(fmt::format("{}: line {}: '{}' {}", file, line, name, value.error().message));
      }
      option.push_back(*value);
    }
    rule.options.push_back(std::move(option));
  }
  if (!top && rule.pattern.empty()) {
    return bad(fmt::format("{}: line {}: a [[rule]] needs match = \"PATTERN\"", file,
                           table.source().begin.line));
  }
  return rule;
}

}  // namespace

Result<std::vector<EncodeOption>> split_options(const std::vector<std::string>& words) {
  std::vector<EncodeOption> options;
  for (const std::string& word : words) {
    if (is_option(word)) {
      options.push_back({word});
    } else if (options.empty()) {
      return bad(fmt::format("'{}' is no option of nacre encode", word));
    } else {
      options.back().push_back(word);
    }
  }
  return options;
}

Result<OptionRule> parse_rule(std::string_view text) {
  const std::size_t equals = text.find('=');
  if (equals == 0 || equals == std::string_view::npos) {
    return bad(fmt::format("--rule '{}': write PATTERN=OPTIONS, e.g. 'busts/**=--psnr 75'", text));
  }
  std::istringstream in{std::string(text.substr(equals + 1))};
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  Result<std::vector<EncodeOption>> options = split_options(words);
  if (!options) return bad(fmt::format("--rule '{}': {}", text, options.error().message));
  return OptionRule{std::string(text.substr(0, equals)), *options};
}

Result<std::vector<OptionRule>> read_rules(const std::filesystem::path& file) {
  const std::string name = file.string();
  std::ifstream in(file, std::ios::binary);
  std::stringstream text;
  text << in.rdbuf();
  if (!in) return Error{ErrorCode::kUnreadableFile, name + ": cannot be read; check the path"};
  const toml::parse_result parsed = toml::parse(text.str(), name);
  if (!parsed) {
    return Error{ErrorCode::kUnreadableFile,
                 fmt::format("{}: line {}: {}", name, parsed.error().source().begin.line,
                             parsed.error().description())};
  }
  const toml::table& table = parsed.table();
  std::vector<OptionRule> rules;
  Result<OptionRule> top = rule_of(table, name, true);
  if (!top) return top.error();
  rules.push_back(*top);
  const toml::node* node = table.get("rule");
  if (node == nullptr) return rules;
  const toml::array* list = node->as_array();
  if (list == nullptr || !list->is_homogeneous<toml::table>()) {
    return bad(fmt::format("{}: write each rule as [[rule]] with match = \"PATTERN\"", name));
  }
  for (const toml::node& entry : *list) {
    Result<OptionRule> rule = rule_of(*entry.as_table(), name, false);
    if (!rule) return rule.error();
    rules.push_back(*rule);
  }
  return rules;
}

std::vector<std::string> options_for(const std::vector<OptionRule>& rules, std::string_view path) {
  std::map<std::string, EncodeOption, std::less<>> by_name;
  for (const OptionRule& rule : rules) {
    if (!rule.pattern.empty() && !glob_match(rule.pattern, path)) continue;
    // Two goals of one rule contradict each other: both stay, and the parser refuses them.
    if (std::ranges::any_of(rule.options, [](const EncodeOption& option) {
          return std::ranges::find(kGoals, name_of(option)) != kGoals.end();
        })) {
      for (const std::string_view goal : kGoals) by_name.erase(std::string(goal));
    }
    for (const EncodeOption& option : rule.options) {
      const std::string name(name_of(option));
      if (option.back() == std::string_view(kRemoved, 8)) {
        by_name.erase(name);
      } else {
        by_name[name] = option;
      }
    }
  }
  std::vector<std::string> words;
  for (const auto& [name, option] : by_name) {
    words.insert(words.end(), option.begin(), option.end());
  }
  return words;
}

Result<EncodeCommand> encode_command(const std::vector<std::string>& options,
                                     const std::filesystem::path& scan,
                                     const std::filesystem::path& output) {
  for (const std::string& word : options) {
    const std::string_view name = std::string_view(word).substr(0, word.find('='));
    if (std::ranges::find(kOwn, name) != kOwn.end()) {
      return bad(fmt::format("{} is set by the batch itself; leave it out", name));
    }
  }
  std::vector<std::string> words = {"encode"};
  words.insert(words.end(), options.begin(), options.end());
  words.insert(words.end(), {"--output", output.string(), "--", scan.string()});
  Result<Command> parsed = parse_command_line(words);
  if (!parsed) return parsed.error();
  auto* command = std::get_if<EncodeCommand>(&*parsed);
  if (command == nullptr || command->scan != scan || command->output != output) {
    return bad("the options hold something that is none of an encoding");
  }
  return *command;
}

}  // namespace nacre::app::batch
