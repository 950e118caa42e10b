// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/cli_completion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <vector>

namespace nacre::app {
namespace {

struct OptionFacts {
  std::vector<std::string> names;   ///< "--output", "-o"
  std::vector<std::string> values;  ///< all there are; empty: any
  std::string description, value_name;
  bool takes_value = false;
};

struct VerbFacts {
  std::string name, description, footer;
  std::vector<OptionFacts> options;
  std::vector<std::string> positionals, words;  ///< words: verbs of its own and values
};

/// CLI11 names the values of a set in the type: "TEXT:{a,b,c}".
std::vector<std::string> values_in(const std::string& type) {
  std::vector<std::string> values;
  const std::size_t open = type.find('{'), close = type.find('}', open);
  if (open == std::string::npos || close == std::string::npos) return values;
  std::string word;
  for (std::size_t i = open + 1; i <= close; ++i) {
    if (type[i] != ',' && type[i] != '}') {
      word += type[i];
      continue;
    }
    values.push_back(std::exchange(word, {}));
  }
  return values;
}

std::string one_line(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  return text;
}

OptionFacts facts_of(const CLI::Option& option) {
  OptionFacts facts;
  for (const std::string& name : option.get_lnames()) facts.names.push_back("--" + name);
  for (const std::string& name : option.get_snames()) facts.names.push_back("-" + name);
  facts.takes_value = option.get_items_expected_max() > 0;
  facts.description = one_line(option.get_description());
  if (facts.takes_value) facts.values = values_in(option.get_type_name());
  return facts;
}

VerbFacts facts_of(const CLI::App& verb) {
  VerbFacts facts;
  facts.name = verb.get_name();
  facts.description = one_line(verb.get_description());
  facts.footer = verb.get_footer();
  for (const CLI::Option* option : verb.get_options()) {
    if (option->get_positional()) {
      facts.positionals.push_back(option->get_name());
      for (std::string& value : values_in(option->get_type_name()))
        facts.words.push_back(std::move(value));
    } else {
      facts.options.push_back(facts_of(*option));
    }
  }
  for (const CLI::App* inner : verb.get_subcommands({})) {
    if (!inner->get_name().empty()) facts.words.push_back(inner->get_name());  // else a group
    for (const CLI::Option* option : inner->get_options()) {
      OptionFacts of_inner = facts_of(*option);
      if (option->get_positional() || std::ranges::any_of(facts.options, [&](const OptionFacts& o) {
            return o.names == of_inner.names;
          }))
        continue;
      facts.options.push_back(std::move(of_inner));
    }
  }
  return facts;
}

std::vector<VerbFacts> verbs_of(const CLI::App& app) {
  std::vector<VerbFacts> verbs;
  for (const CLI::App* verb : app.get_subcommands({})) verbs.push_back(facts_of(*verb));
  return verbs;
}

std::vector<std::string> names_of(const std::vector<VerbFacts>& verbs) {
  std::vector<std::string> names;
  for (const VerbFacts& verb : verbs) names.push_back(verb.name);
  return names;
}

std::string bash_script(const std::vector<VerbFacts>& verbs) {
  std::string out = fmt::format(
      "# bash completion of nacre: source it, or put it into\n"
      "# ~/.local/share/bash-completion/completions/nacre\n"
      "_nacre() {{\n"
      "  local current=\"${{COMP_WORDS[COMP_CWORD]}}\" previous=\"${{COMP_WORDS[COMP_CWORD-1]}}\"\n"
      "  local verb=\"${{COMP_WORDS[1]}}\" words=\"\"\n"
      "  if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
      "    COMPREPLY=($(compgen -W \"{} --help --version\" -- \"$current\"))\n"
      "    return\n  fi\n  case \"$verb\" in\n",
      fmt::join(names_of(verbs), " "));
  for (const VerbFacts& verb : verbs) {
    std::vector<std::string> words = verb.words;
    std::string values;
    for (const OptionFacts& option : verb.options) {
      words.insert(words.end(), option.names.begin(), option.names.end());
      if (option.values.empty()) continue;
      values +=
          fmt::format("        {}) COMPREPLY=($(compgen -W \"{}\" -- \"$current\")); return;;\n",
                      fmt::join(option.names, "|"), fmt::join(option.values, " "));
    }
    out += fmt::format("    {})\n", verb.name);
    if (!values.empty()) out += "      case \"$previous\" in\n" + values + "      esac\n";
    out += fmt::format("      words=\"{}\";;\n", fmt::join(words, " "));
  }
  return out +
         "  esac\n"
         "  if [[ \"$current\" == -* ]]; then\n"
         "    COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n"
         "  else\n"
         "    COMPREPLY=($(compgen -W \"${words//-*([^ ])/}\" -- \"$current\") $(compgen -f -- "
         "\"$current\"))\n"
         "  fi\n"
         "}\n"
         "shopt -s extglob\n"
         "complete -o filenames -F _nacre nacre\n";
}

/// For zsh between single quotes and brackets.
std::string zsh_text(std::string text) {
  std::string out;
  for (const char c : text) {
    if (c == '\'') {
      out += "'\\''";
    } else if (c == '[' || c == ']' || c == ':') {
      out += std::string("\\") + c;
    } else {
      out += c;
    }
  }
  return out;
}

std::string zsh_script(const std::vector<VerbFacts>& verbs) {
  std::string out =
      "#compdef nacre\n# zsh completion of nacre: save it as _nacre in a folder of $fpath\n"
      "_nacre() {\n  local -a verbs\n  verbs=(\n";
  for (const VerbFacts& verb : verbs)
    out += fmt::format("    '{}:{}'\n", verb.name, zsh_text(verb.description));
  out +=
      "  )\n  if (( CURRENT == 2 )); then _describe verb verbs; return; fi\n"
      "  local verb=$words[2]\n  shift words; (( CURRENT-- ))\n  case $verb in\n";
  for (const VerbFacts& verb : verbs) {
    out += fmt::format("    {})\n      _arguments \\\n", verb.name);
    for (const OptionFacts& option : verb.options) {
      for (const std::string& name : option.names) {
        const std::string value = !option.takes_value ? ""
                                  : option.values.empty()
                                      ? ":value:_files"
                                      : fmt::format(":value:({})", fmt::join(option.values, " "));
        out += fmt::format("        '{}[{}]{}' \\\n", name, zsh_text(option.description), value);
      }
    }
    out += verb.words.empty() ? "        '*:file:_files';;\n"
                              : fmt::format("        '1:word:({})' '*:file:_files';;\n",
                                            fmt::join(verb.words, " "));
  }
  return out + "  esac\n}\n_nacre \"$@\"\n";
}

std::string fish_text(std::string text) {
  std::string out;
  for (const char c : text)
    out += c == '\'' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return out;
}

std::string fish_script(const std::vector<VerbFacts>& verbs) {
  std::string out =
      "# fish completion of nacre: save it as ~/.config/fish/completions/nacre.fish\n";
  for (const VerbFacts& verb : verbs)
    out += fmt::format("complete -c nacre -n __fish_use_subcommand -f -a {} -d '{}'\n", verb.name,
                       fish_text(verb.description));
  for (const VerbFacts& verb : verbs) {
    const std::string when =
        fmt::format("complete -c nacre -n '__fish_seen_subcommand_from {}'", verb.name);
    if (!verb.words.empty()) out += fmt::format("{} -a '{}'\n", when, fmt::join(verb.words, " "));
    for (const OptionFacts& option : verb.options) {
      std::string line = when;
      for (const std::string& name : option.names)
        line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      if (option.takes_value) line += option.values.empty() ? " -r" : " -x";
      if (!option.values.empty()) line += fmt::format(" -a '{}'", fmt::join(option.values, " "));
      out += fmt::format("{} -d '{}'\n", line, fish_text(option.description));
    }
  }
  return out;
}

/// For roff: backslashes and hyphens, and no line that begins with a dot or a quote.
std::string roff(const std::string& text) {
  std::string out;
  bool begins = true;
  for (const char c : text) {
    if (begins && (c == '.' || c == '\'')) out += "\\&";
    begins = c == '\n';
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else {
      out += c;
    }
  }
  return out;
}

std::string manual_page(const CLI::App& app, const std::vector<VerbFacts>& verbs) {
  std::string out =
      ".\\\" Written by `nacre completion man`.\n.TH NACRE 1 \"\" \"nacre\" \"User Commands\"\n"
      ".SH NAME\nnacre \\- raw scanned triangle meshes to small bitstreams and back\n"
      ".SH SYNOPSIS\n.B nacre\n.I VERB\n.RI [ OPTIONS ]\n.SH DESCRIPTION\n" +
      roff(one_line(app.get_description())) + "\n";
  for (const VerbFacts& verb : verbs) {
    std::string synopsis;
    for (const std::string& name : verb.positionals) synopsis += " " + name;
    out += fmt::format(".SH NACRE {}\n.B nacre {}{}\n.PP\n{}.\n", roff(verb.name), roff(verb.name),
                       roff(synopsis), roff(verb.description));
    for (const OptionFacts& option : verb.options) {
      const std::string values =
          option.values.empty() ? "" : fmt::format(" (one of {})", fmt::join(option.values, ", "));
      out +=
          fmt::format(".TP\n.B {}{}\n{}\n", roff(fmt::format("{}", fmt::join(option.names, ", "))),
                      option.takes_value ? " VALUE" : "", roff(option.description + values));
    }
    if (!verb.footer.empty()) out += ".PP\n.nf\n" + roff(verb.footer) + "\n.fi\n";
  }
  return out + ".SH EXAMPLES AND EXIT CODES\n.nf\n" + roff(app.get_footer()) + "\n.fi\n";
}

}  // namespace

std::string completion_script(const CLI::App& app, std::string_view shell) {
  const std::vector<VerbFacts> verbs = verbs_of(app);
  if (shell == "bash") return bash_script(verbs);
  if (shell == "zsh") return zsh_script(verbs);
  if (shell == "fish") return fish_script(verbs);
  return manual_page(app, verbs);
}

}  // namespace nacre::app
