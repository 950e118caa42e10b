// SPDX-License-Identifier: GPL-3.0-or-later
//
// Every option given wrongly, with the built command: exit code, one line, and what it says. A word
// that begins with @ is a file in the scratch folder, where scan.ply is. What options ask for that
// a scan or a stream cannot give is in refusal_test, prefix_test, goal_test and stage_run_test.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "run_command.h"

namespace nacre::app::test {
namespace {

struct Wrong {
  const char* arguments;  ///< behind the verb
  const char* words;      ///< that the message must have
  int exit_code = 2;
};

/// Behind what every verb but batch and completion needs.
const std::vector<Wrong> kCommon = {
    {"-q -v", "--quiet excludes --verbose"},
    {"--threads 0", "--threads: Value 0 not in range 1 to 1024"},
    {"--threads many", "--threads: Value many not in range"},
    {"--frobnicate", "unknown option '--frobnicate' (see nacre"},
    {"--thread 2", "unknown option '--thread', did you mean '--threads'?"},
};

/// Of encode and remesh.
const std::vector<Wrong> kRemeshing = {
    {"", "SCAN is required"},
    {"a.ply", "-o is required: the file to write (or --until, to stop before it)"},
    {"a.ply -o", "--output: 1 required"},
    {"a.ply b.ply -o c", "not expected: b.ply"},
    {"a -o b --levels 0", "--levels: Value 0 not in range 1 to 12"},
    {"a -o b --levels 13", "--levels: Value 13 not in range 1 to 12"},
    {"a -o b --levels few", "--levels: Value few not in range"},
    {"a -o b --base-vertices 3", "--base-vertices: Value 3 not in range 4 to 1000000"},
    {"a -o b --repair most", "--repair: most not in {safe,strict,none,aggressive}"},
    {"a -o b --samples 10", "--samples: Value 10 not in range 1000 to 1000000000"},
    {"a -o b --progress loud", "--progress: loud not in {auto,json,none}"},
    {"a -o b --max-memory lots", "--max-memory: 'lots' is not a size: write bytes, or 6k"},
    {"a -o b --max-memory 0", "--max-memory: '0' is not a size"},
    {"a --until frogs --work-dir w", "--until: frogs not in {input,clean,"},
    {"a --until base", "--until needs --work-dir, the folder to write the stage to"},
    {"a -o b --until base --work-dir w", "--until stops before the output is made; leave out -o"},
    {"a --until base --work-dir w --report r.json", "leave out --report"},
    {"a -o b --work-dir w --dump frogs", "--dump: frogs not in {input,clean,"},
    {"a -o b --dump all", "--dump needs --work-dir, the folder to write to"},
    {"a -o b --work-dir w", "--work-dir needs --dump, the stages to write there"},
    {"@scan.ply --until clean --work-dir @scan.ply", "scan.ply: is not a folder", 1},
    {"@scan.ply --until clean --work-dir @full", "02-clean: is not empty; use -f"},
    {"@scan.ply --until normal-mesh --work-dir @w --from @none",
     "none: is not the folder of a stage, like DIR/05-normal-mesh", 3},
    {"@scan.ply --until normal-mesh --work-dir @w --from @full", "full: has no stage.json", 3},
};

const std::map<std::string, std::vector<Wrong>> kOfVerb = {
    {"encode",
     {
         {"@scan.ply -o @out.ply", "out.ply: the name of this output must end in .ncr"},
         {"@scan.ply -o @no/out.ncr", "no/out.ncr: its folder does not exist", 1},
         {"a -o b.ncr --quality 101", "--quality: '101' is not a quality from 0 to 100"},
         {"a -o b.ncr --quality nan", "--quality: 'nan' is not a quality"},
         {"a -o b.ncr --size 4q", "--size: '4q' is not a size: write bytes, or 6k (= 6000)"},
         {"a -o b.ncr --size 0", "--size: '0' is not a size"},
         {"a -o b.ncr --psnr 0", "--psnr: '0' is not a PSNR from 1 to 400 dB"},
         {"a -o b.ncr --psnr inf", "--psnr: 'inf' is not a PSNR"},
         {"a -o b.ncr --max-error 5x", "--max-error: '5x' is not an error: 0.05 (model units)"},
         {"a -o b.ncr --max-error 0%", "--max-error: '0%' is not an error"},
         {"a -o b.ncr --bits-per-vertex 0", "--bits-per-vertex: '0' is not a positive number"},
         {"a -o b.ncr --bits-per-semi-regular-vertex -1",
          "--bits-per-semi-regular-vertex: '-1' is not a positive number"},
         {"a -o b.ncr --size 4k --psnr 70", "at most 1 options be given from [--quality,--size,"},
         {"a -o b.ncr --profile worst", "--profile: worst not in {best,paper,nmc,eqmc}"},
         {"a -o b.ncr --effort heroic", "--effort: heroic not in {normal,fast}"},
         {"a -o b.ncr --transform haar", "--transform: haar not in {butterfly,loop}"},
         {"a -o b.ncr --theta 91", "--theta: '91' is not an angle from 0 to 90"},
         {"a -o b.ncr --level-table maybe", "--level-table: maybe not in {auto,on,off}"},
         {"@scan.ply -o @out.ncr --report @r.txt",
          "r.txt: the name of this output must end in .json"},
         {"@scan.ply -o @out.ncr --report @no/r.html", "no/r.html: its folder does not exist", 1},
         {"a -o b.ncr --semi-regular --repair none", "--repair excludes --semi-regular"},
         {"a -o b.ncr --semi-regular --base-vertices 9", "excludes --semi-regular"},
         {"a --semi-regular --until base --work-dir w",
          "--semi-regular has no stages between input and normal-mesh"},
         {"a -o b.ncr --reference c", "--reference requires --semi-regular"},
         {"@scan.ply -o @out.ncr --semi-regular --reference @none.ply", "none.ply: no such file",
          3},
         {"@scan.ply -o @out.ncr --semi-regular --reference @flat.ply",
          "flat.ply: no face has an area", 4},
         {"@scan.ply -o @out.ncr --profile eqmc --work-dir @w --dump symbols",
          "profile eqmc has no symbols"},
         {"@scan.ply -o @out.ncr --max-memory 100M", "over --max-memory 100 MB; give it more", 6},
     }},
    {"remesh",
     {
         {"@scan.ply -o @out.step", "out.step"},
         {"@scan.ply -o @out.ply --report @r.html",
          "r.html: the name of this output must end in .json"},
         {"a -o b.ply --work-dir w --dump symbols", "--dump: symbols not in {input,clean,"},
         {"a --work-dir w --until steps", "--until: steps not in {input,clean,"},
         {"a -o b.ply --size 4k", "unknown option '--size'"},
         {"@scan.ply -o @out.ply --max-memory 100M", "over --max-memory 100 MB; give it more", 6},
     }},
    {"decode",
     {
         {"", "FILE is required"},
         {"a.ncr", "--output is required"},
         {"a.ncr b.ncr -o c.ply", "not expected: b.ncr"},
         {"a.ncr -o @out.step", "out.step"},
         {"a.ncr -o @no/out.ply", "no/out.ply: its folder does not exist", 1},
         {"@none.ncr -o @out.ply", "none.ncr: no such file", 3},
         {"a.ncr -o b.ply --level 31", "--level: Value 31 not in range 0 to 30"},
         {"a.ncr -o b.ply --level fine", "--level: Value fine not in range"},
         {"a.ncr -o b.ply --bytes -3", "--bytes: '-3' is not a size"},
         {"a.ncr -o b.ply --max-error near", "--max-error: 'near' is not an error"},
         {"a.ncr -o b.ply --level 1 --bytes 1k", "--level excludes --bytes"},
         {"a.ncr -o b.ply --level 1 --max-error 1", "--level excludes --max-error"},
         {"a.ncr -o b.ply --bytes 1k --max-error 1", "--bytes excludes --max-error"},
     }},
    {"cut",
     {
         {"", "FILE is required"},
         {"a.ncr --level 1", "--output is required"},
         {"a.ncr -o b.ncr", "where to cut? name one of --size, --level and --max-error"},
         {"a.ncr -o @out.ply --level 1", "out.ply: the name of this output must end in .ncr"},
         {"@none.ncr -o @out.ncr --level 1", "none.ncr: no such file", 3},
         {"a.ncr -o b.ncr --level 31", "--level: Value 31 not in range 0 to 30"},
         {"a.ncr -o b.ncr --size none", "--size: 'none' is not a size"},
         {"a.ncr -o b.ncr --max-error -1%", "--max-error: '-1%' is not an error"},
         {"a.ncr -o b.ncr --level 1 --size 1k", "--level excludes --size"},
         {"a.ncr -o b.ncr --size 1k --max-error 1", "--size excludes --max-error"},
     }},
    {"compare",
     {
         {"", "A is required"},
         {"a", "B is required"},
         {"a b c", "not expected: c"},
         {"@scan.ply @none.ply", "none.ply: no such file", 3},
         {"@scan.ply @flat.ply", "flat.ply: no face has an area", 4},
         {"a b --samples 10", "--samples: Value 10 not in range 1000 to 1000000000"},
         {"a b --certify-tolerance 2", "--certify-tolerance requires --certify"},
         {"a b --certify --certify-tolerance 101", "'101' is not a percentage from 0 to 100"},
         {"@scan.ply @scan.ply --map @m.obj", "m.obj: the name of this output must end in .ply"},
         {"@scan.ply @scan.ply --map @no/m.ply", "no/m.ply: its folder does not exist", 1},
         {"@scan.ply @scan.ply --picture @p.jpg", "p.jpg: the name of this output must end in"},
         {"a b --map-max 1", "--map-max needs --map or --picture"},
         {"a b --map m.ply --map-max 0", "--map-max: '0' is not a positive number"},
         {"a b --up z", "--up requires --picture"},
         {"a b --picture p.png --up w", "--up: w not in {x,y,z}"},
         {"a b --azimuth 9", "--azimuth requires --picture"},
         {"a b --picture p.png --azimuth 361", "'361' is not an angle from -360 to 360"},
         {"a b --elevation 9", "--elevation requires --picture"},
         {"a b --picture p.png --elevation nan", "'nan' is not an angle from -90 to 90"},
     }},
    {"info",
     {
         {"", "FILE is required"},
         {"a b", "not expected: b"},
         {"@none.ncr", "none.ncr: no such file", 3},
     }},
    {"stage",
     {
         {"", "ACTION is required"},
         {"show w", "ACTION: show not in {list,diff}"},
         {"list", "DIR is required"},
         {"list v w", "stage list takes one folder (see nacre stage --help)"},
         {"diff w", "stage diff takes two folders (see nacre stage --help)"},
         {"list @none", "none: is not a folder", 3},
         {"list @full", "full: has no stages; write some with --work-dir and --dump", 3},
     }},
    {"completion",
     {
         {"", "SHELL is required"},
         {"tcsh", "SHELL: tcsh not in {bash,zsh,fish,man}"},
     }},
    {"batch",
     {
         {"", "which scans, and where to? nacre batch IN OUT, or one of plan,"},
         {"in", "which scans, and where to?"},
         {"in out -q -v", "--quiet excludes --verbose"},
         {"in out --job 3", "unknown option '--job', did you mean '--jobs'?"},
         {"@none @out", "none: no such folder or list of scans", 3},
         {"in out --jobs 0", "--jobs: Value 0 not in range 1 to 1024"},
         {"in out --threads 0", "--threads: Value 0 not in range 1 to 1024"},
         {"in out --max-memory lots", "--max-memory: 'lots' is not a size"},
         {"in out --timeout 0", "--timeout: '0' is not a positive number"},
         {"in out --rule x", "--rule 'x': write PATTERN=OPTIONS"},
         {"in out --options @none.toml", "none.toml: cannot be read", 3},
         {"@scans @out -- --levels 77", "--levels"},
     }},
    {"batch plan",
     {
         {"", "IN is required"},
         {"in", "--output is required"},
         {"@scans -o @m.jsonl --rule x", "--rule 'x': write PATTERN=OPTIONS"},
         {"@scans -o @m.jsonl --options @none.toml", "none.toml: cannot be read", 3},
     }},
    {"batch run",
     {
         {"", "MANIFEST is required"},
         {"@none.jsonl", "none.jsonl", 3},
         {"m --shard 8/8", "--shard '8/8' is not K/N with 0 <= K < N, e.g. 0/8 up to 7/8"},
         {"m --jobs many", "--jobs: Value many not in range 1 to 1024"},
         {"m --threads 1025", "--threads: Value 1025 not in range 1 to 1024"},
         {"m --max-memory 0", "--max-memory: '0' is not a size"},
         {"m --timeout nan", "--timeout: 'nan' is not a positive number"},
         {"m -- --size 4k", "encode options after -- belong to nacre batch plan, or to IN OUT"},
     }},
    {"batch status", {{"", "MANIFEST is required"}, {"@none.jsonl", "none.jsonl", 3}}},
    {"batch merge", {{"", "MANIFEST is required"}, {"@none.jsonl", "none.jsonl", 3}}},
    {"batch sbatch",
     {
         {"", "MANIFEST is required"},
         {"@none.jsonl", "none.jsonl", 3},
         {"m --shards 0", "--shards: Value 0 not in range 1 to 1000000"},
         {"m --cpus 0", "--cpus: Value 0 not in range 1 to 1024"},
         {"m --max-memory lots", "--max-memory: 'lots' is not a size"},
     }},
};

/// What can be anything: patterns, and names that another test makes wrong.
const std::set<std::string> kAnyValue = {"--include", "--exclude", "--output-dir", "--output"};

std::vector<std::string> split(const std::string& line) {
  std::istringstream in(line);
  return {std::istream_iterator<std::string>(in), {}};
}

struct Case {
  std::string arguments;
  const char* words;
  int exit_code;
};

std::vector<Case> cases_of(const std::string& verb) {
  std::vector<Case> cases;
  const auto add = [&](const std::vector<Wrong>& wrongs, const std::string& before) {
    for (const Wrong& wrong : wrongs)
      cases.push_back({before + wrong.arguments, wrong.words, wrong.exit_code});
  };
  add(kOfVerb.at(verb), "");
  if (verb == "encode" || verb == "remesh") add(kRemeshing, "");
  const bool is_plain = !verb.starts_with("batch") && verb != "completion";
  if (is_plain)
    add(kCommon, verb == "info"      ? "a "
                 : verb == "compare" ? "a b "
                 : verb == "stage"   ? "list a "
                                     : "a -o b ");
  return cases;
}

/// The options of a verb that take a value, from its --help.
std::set<std::string> options_with_value(const std::string& verb) {
  std::vector<std::string> arguments = split(verb);
  arguments.emplace_back("--help");
  std::istringstream help(run(arguments).out);
  static const std::regex definition("^ +(-[a-z],)?(--[a-z-]+) (TEXT|INT|UINT|FLOAT).*");
  std::set<std::string> options;
  std::smatch match;
  for (std::string line; std::getline(help, line);)
    if (std::regex_match(line, match, definition)) options.insert(match[2]);
  return options;
}

class OptionErrors : public testing::TestWithParam<std::string> {
 protected:
  OptionErrors() {
    save(scratch_, "scan.ply", shapes::sphere(2));
    Scan flat = shapes::tetrahedron();
    for (Vec3& p : flat.positions) p = {p[0], 0, 0};
    save(scratch_, "flat.ply", flat);
    std::filesystem::create_directories(scratch_.file("full/02-clean"));
    scratch_.write("full/02-clean/mine.txt", "precious");
    std::filesystem::create_directory(scratch_.file("scans"));
    save(scratch_, "scans/a.ply", shapes::sphere(1));
  }

  void expect_refused(const std::string& arguments, const std::string& words, int exit_code) {
    std::vector<std::string> all = split(GetParam());
    for (const std::string& word : split(arguments))
      all.push_back(word.starts_with('@') ? scratch_.file(word.substr(1)).string() : word);
    const std::string line = "nacre " + GetParam() + " " + arguments;
    const auto before = scratch_.listing();
    const Outcome outcome = run(all);
    EXPECT_EQ(outcome.exit_code, exit_code) << line << ": " << outcome.err;
    EXPECT_EQ(outcome.out, "") << line;
    EXPECT_TRUE(outcome.err.starts_with("nacre: ")) << line << ": " << outcome.err;
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << line << ": " << outcome.err;
    EXPECT_LT(outcome.err.size(), 400u) << line << ": " << outcome.err;
    EXPECT_NE(outcome.err.find(words), std::string::npos) << line << ": " << outcome.err;
    EXPECT_EQ(scratch_.listing(), before) << line;
  }

  Scratch scratch_;
};

TEST_P(OptionErrors, HaveTheirCodeAndMessage) {
  for (const Case& wrong : cases_of(GetParam()))
    expect_refused(wrong.arguments, wrong.words, wrong.exit_code);
}

TEST_P(OptionErrors, AValueThatIsMissingIsSaid) {
  for (const std::string& option : options_with_value(GetParam()))
    expect_refused(option, option + ": 1 required", 2);
}

/// A new option must come with its errors.
TEST_P(OptionErrors, AreKnownOfEveryOption) {
  std::set<std::string> tried;
  for (const Case& wrong : cases_of(GetParam()))
    for (const std::string& word : split(wrong.arguments)) tried.insert(word);
  for (const std::string& option : options_with_value(GetParam()))
    EXPECT_TRUE(tried.contains(option) || kAnyValue.contains(option))
        << GetParam() << " " << option;
}

std::vector<std::string> verbs() {
  std::vector<std::string> names;
  for (const auto& [name, wrongs] : kOfVerb) names.push_back(name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Verbs, OptionErrors, testing::ValuesIn(verbs()), [](const auto& verb) {
  std::string name = verb.param;
  std::ranges::replace(name, ' ', '_');
  return name;
});

}  // namespace
}  // namespace nacre::app::test
