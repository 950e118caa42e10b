// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>

#include "run_command.h"

namespace nacre::app::test {
namespace {

const std::vector<std::string> kVerbs = {"encode", "decode", "remesh", "compare",   "info",
                                         "cut",    "stage",  "batch",  "completion"};

/// "--output" and the like, wherever they stand.
std::set<std::string> long_options(const std::string& text) {
  static const std::regex option("--[a-z][a-z-]*[a-z]");
  return {std::sregex_token_iterator(text.begin(), text.end(), option), {}};
}

/// Those that a verb's --help defines: they begin a line.
std::set<std::string> options_of(const std::string& verb) {
  std::set<std::string> options;
  std::istringstream help(run({verb, "--help"}).out);
  static const std::regex definition("^ +(-[a-z],)?(--[a-z-]+).*");
  std::smatch match;
  for (std::string line; std::getline(help, line);)
    if (std::regex_match(line, match, definition)) options.insert(match[2]);
  return options;
}

std::string section(const std::string& page, const std::string& verb) {
  const std::size_t begin = page.find(".SH NACRE " + verb + "\n");
  if (begin == std::string::npos) return "";
  return page.substr(begin, page.find("\n.SH ", begin + 1) - begin);
}

/// The page as it is kept in the repository, hyphens as they are typed.
std::string manual_page() {
  std::ifstream in(NACRE_MANUAL_PAGE);
  std::string page{std::istreambuf_iterator<char>(in), {}};
  for (std::size_t at = 0; (at = page.find("\\-", at)) != std::string::npos; ++at)
    page.erase(at, 1);
  return page;
}

TEST(ManualPage, HasTheOptionsThatHelpHas) {
  const std::string page = manual_page();
  ASSERT_FALSE(page.empty());
  for (const std::string& verb : kVerbs) {
    const std::string of_verb = section(page, verb);
    ASSERT_FALSE(of_verb.empty()) << verb << ": nacre completion man > docs/nacre.1";
    const std::set<std::string> in_page = long_options(of_verb), in_help = options_of(verb);
    EXPECT_FALSE(in_help.empty()) << verb;
    for (const std::string& option : in_help)
      EXPECT_TRUE(in_page.contains(option))
          << verb << " " << option << ": nacre completion man > docs/nacre.1";
    if (verb == "batch") continue;  // its page has the options of its own verbs too
    std::istringstream lines(of_verb);
    for (std::string line; std::getline(lines, line);)
      if (line.starts_with(".B --")) {
        EXPECT_TRUE(in_help.contains(*long_options(line).begin()))
            << verb << " has no " << line << " any more: nacre completion man > docs/nacre.1";
      }
  }
}

TEST(Completion, ScriptsNameEveryVerbAndOption) {
  for (const char* shell : {"bash", "zsh", "fish"}) {
    const Outcome outcome = run({"completion", shell});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    for (const std::string& verb : kVerbs)
      EXPECT_NE(outcome.out.find(verb), std::string::npos) << shell << " " << verb;
    for (const std::string& option : options_of("encode")) {
      const std::string name = shell == std::string("fish") ? "-l " + option.substr(2) : option;
      EXPECT_NE(outcome.out.find(name), std::string::npos) << shell << " " << option;
    }
  }
  EXPECT_EQ(run({"completion", "tcsh"}).exit_code, 2);
  EXPECT_EQ(run({"completion"}).exit_code, 2);
}

TEST(Completion, BashCompletes) {
  const Scratch scratch;
  scratch.write("nacre.bash", run({"completion", "bash"}).out);
  const auto completed = [&](const std::string& words, int index) {
    scratch.write("try.bash", "source " + scratch.file("nacre.bash").string() + "\nCOMP_WORDS=(" +
                                  words + ")\nCOMP_CWORD=" + std::to_string(index) +
                                  "\n_nacre\nprintf '%s ' \"${COMPREPLY[@]}\"\n");
    const std::string command = "bash " + scratch.file("try.bash").string() + " > " +
                                scratch.file("reply").string() + " 2>&1";
    EXPECT_EQ(std::system(command.c_str()), 0);
    return scratch.read("reply");
  };
  EXPECT_EQ(completed("nacre enc", 1), "encode ");
  EXPECT_EQ(completed("nacre encode --until st", 3), "steps stream ");
  EXPECT_EQ(completed("nacre encode --semi", 2), "--semi-regular ");
  EXPECT_EQ(completed("nacre stage di", 2), "diff ");
}

}  // namespace
}  // namespace nacre::app::test
