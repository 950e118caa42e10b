// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "app/batch/option_rules.h"
#include "scratch.h"

namespace nacre::app::batch {
namespace {

using Words = std::vector<std::string>;

class Options : public testing::Test {
 protected:
  Result<std::vector<OptionRule>> read(const std::string& text) {
    scratch.write("job.toml", text);
    return read_rules(scratch.file("job.toml"));
  }
  app::test::Scratch scratch;
};

TEST_F(Options, LaterRulesReplaceEarlierOnes) {
  const auto rules = read(R"(
size = "50k"
levels = 5
[[rule]]
match = "busts/**"
bits-per-vertex = 2.5
[[rule]]
match = "*.stl"
repair = "strict"
levels = false
)");
  ASSERT_TRUE(rules.has_value()) << rules.error().message;
  EXPECT_EQ(options_for(*rules, "a.ply"), (Words{"--levels", "5", "--size", "50k"}));
  EXPECT_EQ(options_for(*rules, "busts/a.ply"),
            (Words{"--bits-per-vertex", "2.5", "--levels", "5"}));
  EXPECT_EQ(options_for(*rules, "busts/a.stl"),
            (Words{"--bits-per-vertex", "2.5", "--repair", "strict"}));
}

TEST_F(Options, RulesOfTheCommandLine) {
  const auto rule = parse_rule("a=b/*=--size 6k --levels=3");
  ASSERT_FALSE(rule.has_value()) << "the pattern ends at the first =";
  const auto fine = parse_rule("b/*=--size 6k --levels=3");
  ASSERT_TRUE(fine.has_value());
  EXPECT_EQ(options_for({*fine}, "b/x.ply"), (Words{"--levels=3", "--size", "6k"}));
  EXPECT_TRUE(options_for({*fine}, "c/x.ply").empty());
  EXPECT_FALSE(parse_rule("=--size 6k").has_value());
  EXPECT_FALSE(parse_rule("*.ply").has_value());
  const auto words = split_options({"--theta", "-1.5", "--partial", "-x", "3"});
  ASSERT_TRUE(words.has_value());
  EXPECT_EQ(words->size(), 3u) << "a negative number is a value";
  EXPECT_FALSE(split_options({"6k"}).has_value());
}

TEST_F(Options, BrokenFilesAreRefusedWithTheirLine) {
  const auto message = [&](const std::string& text) {
    const auto rules = read(text);
    EXPECT_FALSE(rules.has_value()) << text;
    return rules ? "" : rules.error().message;
  };
  EXPECT_NE(message("size = \n").find("job.toml: line 1"), std::string::npos);
  EXPECT_NE(message("\nsize = [1]\n").find("line 2: 'size'"), std::string::npos);
  EXPECT_NE(message("\n[[rule]]\nsize = 1\n").find("line 2: a [[rule]] needs"), std::string::npos);
  EXPECT_NE(message("rule = 3\n").find("[[rule]]"), std::string::npos);
  EXPECT_NE(message("[[rule]]\nmatch = 3\n").find("'match'"), std::string::npos);
  const auto none = read_rules(scratch.file("none.toml"));
  ASSERT_FALSE(none.has_value());
  EXPECT_EQ(none.error().code, ErrorCode::kUnreadableFile);
}

TEST_F(Options, EncodesOwnParserReadsThem) {
  const auto command = encode_command({"--size", "6k", "--levels", "3"}, "/in/-a b.ply", "/o.ncr");
  ASSERT_TRUE(command.has_value()) << command.error().message;
  EXPECT_EQ(command->goal, (Goal{Goal::Kind::kSize, 6000}));
  EXPECT_EQ(command->remesh.levels, 3);
  EXPECT_EQ(command->scan, "/in/-a b.ply");
  EXPECT_EQ(command->output, "/o.ncr");
  const auto refused = [](const Words& words) {
    const auto result = encode_command(words, "/in/a.ply", "/o.ncr");
    EXPECT_FALSE(result.has_value()) << words.front();
    if (result) return;
    EXPECT_EQ(result.error().code, ErrorCode::kBadInput);
  };
  refused({"--sise", "6k"});
  refused({"--size", "6k", "--bits-per-vertex", "2"});
  refused({"--levels", "77"});
  refused({"--report", "x.json"});
  refused({"--output=/etc/x.ncr"});
  refused({"-f"});
  refused({"--help"});
  refused({"more.ply"});
}

}  // namespace
}  // namespace nacre::app::batch
