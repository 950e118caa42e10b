// SPDX-License-Identifier: GPL-3.0-or-later
//
// Only this file and the other cli_*.cpp see CLI11: the header is heavy, and its exit codes (106,
// 108, ...) and its two-line messages are not ours. Every parse error leaves here as kBadInput with
// one line.
#include "app/cli.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "app/cli_batch.h"
#include "app/cli_completion.h"
#include "app/cli_number.h"
#include "app/cli_prefix.h"
#include "app/cli_run.h"
#include "app/cli_stages.h"
#include "app/sizes.h"

namespace nacre::app {
namespace {

constexpr std::array<std::string_view, 9> kVerbs = {
    "encode", "decode", "remesh", "compare", "info", "stage", "batch", "cut", "completion"};

constexpr const char* kDescription =
    "nacre: raw scanned triangle meshes to small bitstreams and back.\n"
    "The shape is kept, within a measured error; the original triangles and UV layout are not.";

constexpr const char* kFooter = R"(Examples:
  nacre encode scan.ply -o scan.ncr                 at --quality 75
  nacre encode scan.ply -o scan.ncr --size 50k      never more than 50,000 bytes
  nacre decode scan.ncr -o scan.glb                 also .ply .obj .off .stl
  nacre compare scan.ply scan.ncr --map error.ply   distances, and where they are
  nacre info scan.ncr                               levels, sections, bytes by part
  nacre cut scan.ncr --size 10k -o small.ncr        a smaller file without coding anew
  nacre batch scans/ out/                           a folder of scans, in parallel
`nacre VERB --help` explains the options of a verb.

Results go to stdout, everything else to stderr. Nothing is overwritten without -f.
Exit codes: 0 done, 1 unexpected failure, 2 wrong usage, 3 input unreadable, 4 geometry refused,
  5 goal not reachable, 6 over a limit, 7 .ncr corrupt, cut short or too new,
  8 some scans of a batch failed, 75 interrupted.)";

constexpr const char* kEncodeFooter = R"(Examples:
  nacre encode scan.ply -o scan.ncr --size 6k
  nacre encode scan.obj -o scan.ncr --psnr 80 --report report.json
  nacre encode scan.stl -o scan.ncr --max-error 0.1%     proved, for every point
  nacre encode messy.stl -o messy.ncr --repair strict    refuse a scan that needs real repair
  nacre encode scan.ply -o scan.ncr --work-dir w --dump all          every stage, to look at
  nacre encode scan.ply -o new.ncr --from w/05-normal-mesh --size 6k  on from there, edited or not
The summary's error and PSNR are measured on the decoded file against the scan as read.)";

constexpr const char* kDecodeFooter = R"(Examples:
  nacre decode scan.ncr -o scan.ply
  nacre decode scan.ncr -o preview.glb --level 3         a coarser mesh, 4 times fewer faces a level
  nacre decode scan.ncr -o rough.stl --max-error 0.5%    the coarsest level that is near enough
  nacre decode scan.ncr -o rough.stl --bytes 10k         what the first 10,000 bytes hold
Only the bytes of the level are read.)";

constexpr const char* kRemeshFooter = R"(Examples:
  nacre remesh scan.ply -o semi.ply --levels 5
  nacre remesh scan.ply -o semi.ply --work-dir steps --dump all   each step, coloured, to look at
The result is semi-regular: a base mesh, each triangle split 1 to 4 as many times as there are
levels, whose finer vertices lie on the scan along the normals of the coarser mesh.)";

constexpr const char* kCompareFooter = R"(Examples:
  nacre compare scan.ply scan.ncr
  nacre compare scan.ply other.obj --json | jq .psnr_db
  nacre compare scan.ply scan.ncr --certify               a maximum that is proved
  nacre compare scan.ply scan.ncr --map error.ply --map-max 0.05 --picture error.png)";

constexpr const char* kInfoFooter = R"(Examples:
  nacre info scan.ply      counts, size, topology, what cleaning would change
  nacre info scan.ncr      levels and bytes by part)";

constexpr const char* kCompletionFooter = R"(Examples:
  source <(nacre completion bash)
  nacre completion zsh > ~/.zfunc/_nacre
  nacre completion fish > ~/.config/fish/completions/nacre.fish
  nacre completion man | man -l -)";

Error usage_error(std::string message) { return {ErrorCode::kBadInput, std::move(message)}; }

/// Insertions, deletions, substitutions and swaps of neighbours that turn one word into the other.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substitution = d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, substitution});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
      }
    }
  }
  return d[a.size()][b.size()];
}

/// ", did you mean 'x'?" for the nearest known word if it is near enough; else empty.
template <class Words>
std::string did_you_mean(std::string_view word, const Words& known) {
  std::string_view best;
  std::size_t best_distance = 3;  // two slips at most ...
  for (const auto& candidate : known) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < best_distance && distance * 2 < word.size()) {  // ... and less than half of it
      best_distance = distance;
      best = candidate;
    }
  }
  return best.empty() ? "" : fmt::format(", did you mean '{}'?", best);
}

/// PSNR that these find differs by a few hundredths of a decibel from that of the usual number.
constexpr std::size_t kFastSamples = 200'000;

/// Option values that need a conversion of our own before they are a command.
struct Raw {
  std::string transform = "butterfly", profile = "best", effort = "normal", repair = "safe",
              up = "y", level_table = "auto";
  std::optional<std::string> size, max_error;
  std::optional<double> bits_per_vertex, bits_per_semi_regular_vertex, psnr, quality;
  std::optional<std::size_t> samples;
  bool quiet = false, verbose = false;
};

struct Parser {
  CLI::App app{kDescription, "nacre"};
  Raw raw;
  EncodeCommand encode;
  DecodeCommand decode;
  RemeshCommand remesh;
  CompareCommand compare;
  InfoCommand info;
  PrefixParser decode_prefix, cut_prefix;
  CutCommand cut;
  StageParser stages, remesh_stages, stage_verb;
  Common stage_common;
  RunParser run_options, remesh_run_options;
  std::string completion_shell;
  BatchParser batch;

  Parser() {
    app.footer(kFooter);
    app.require_subcommand(1);
    app.set_help_flag("-h,--help", "Print this help");
    app.set_version_flag("--version", std::string("nacre ") + NACRE_VERSION, "Print the version");
    add_encode();
    add_decode();
    add_remesh();
    add_compare();
    add_info();
    add_cut();
    stage_verb.add_verb(
        *add_verb("stage", "List or compare dumped stages", kStageFooter, stage_common));
    batch.add_to(app);
    add_completion();
  }

 private:
  CLI::App* add_verb(const char* name, const char* description, const char* footer,
                     Common& common) {
    CLI::App* verb = app.add_subcommand(name, description);
    verb->footer(footer);
    auto* quiet = verb->add_flag("-q,--quiet", raw.quiet, "Print warnings and errors only");
    verb->add_flag("-v,--verbose", raw.verbose, "Print more, e.g. the cost of each stage")
        ->excludes(quiet);
    verb->add_option("--threads", common.threads,
                     "Threads; default: all that the process may use. Never changes the result")
        ->check(CLI::Range(1, 1024));
    return verb;
  }

  void add_completion() {
    CLI::App* verb =
        app.add_subcommand("completion", "Print completions for a shell, or the manual page");
    verb->footer(kCompletionFooter);
    verb->add_option("SHELL", completion_shell, "bash, zsh, fish, or man for the manual page")
        ->required()
        ->check(CLI::IsMember({"bash", "zsh", "fish", "man"}));
  }

  static void add_overwrite(CLI::App* verb, Common& common) {
    verb->add_flag("-f,--force", common.overwrite, "Overwrite outputs that exist");
  }

  template <class Samples>
  static CLI::Option* add_samples(CLI::App* verb, Samples& samples) {
    return verb
        ->add_option("--samples", samples, "Area samples per direction of the distance measurement")
        ->check(CLI::Range(std::size_t{1000}, std::size_t{1'000'000'000}))
        ->capture_default_str();
  }

  void add_remesh_options(CLI::App* verb, RemeshSettings& settings) {
    verb->add_option("--levels", settings.levels,
                     "How often the base mesh is split; default: enough to resolve the scan")
        ->check(CLI::Range(1, 12));
    verb->add_option("--base-vertices", settings.base_vertices,
                     "Vertices of the base mesh, all pieces together; default: from the scan")
        ->check(CLI::Range(4, 1'000'000));
    verb->add_option("--repair", raw.repair,
                     "safe: weld, drop degenerate faces, split non-manifold places, orient, and "
                     "list it all; strict: weld only, else refuse; none: refuse any change; "
                     "aggressive: also fill pin holes, cut tiny handles, drop specks")
        ->check(CLI::IsMember({"safe", "strict", "none", "aggressive"}))
        ->capture_default_str();
  }

  void add_goals(CLI::App* verb) {
    auto* goals = verb->add_option_group("Goal", "What the file shall be; at most one");
    goals
        ->add_option(
            "--quality", raw.quality,
            "0 .. 100, default 75: the finest step is the scan's diagonal / 2^(4 + Q / 12.5)")
        ->check(number_within(0, 100, "a quality from 0 to 100"));
    goals->add_option("--size", raw.size,
                      "The whole file, never exceeded: 6061, 6k (= 6000), 6Ki (= 6144), 1.5M");
    goals
        ->add_option("--psnr", raw.psnr,
                     "The smallest file that has this PSNR against the scan, dB")
        ->check(number_within(1, 400, "a PSNR from 1 to 400 dB"));
    goals->add_option("--max-error", raw.max_error,
                      "The smallest file no point of which, nor of the scan, is farther from the "
                      "other surface: 0.05 (model units), 0.02% (of the scan's diagonal). Proved");
    goals
        ->add_option("--bits-per-vertex", raw.bits_per_vertex,
                     "Bits of the whole file per vertex of the input file (STL, which repeats "
                     "them: per distinct vertex)")
        ->check(positive_number());
    goals
        ->add_option("--bits-per-semi-regular-vertex", raw.bits_per_semi_regular_vertex,
                     "The same per vertex of the finest level")
        ->check(positive_number());
    goals->require_option(0, 1);
  }

  void add_encode() {
    CLI::App* verb = add_verb("encode", "Compress a scan (PLY, OBJ, OFF, STL) to a .ncr file",
                              kEncodeFooter, encode.common);
    verb->add_option("SCAN", encode.scan, "The scan to compress")->required();
    verb->add_option("-o,--output", encode.output, "The .ncr file to write");
    add_goals(verb);
    verb->add_option(
            "--profile", raw.profile,
            "Coder: best, paper (ICASSP 2006, lattice VQ), or for comparison nmc (zerotrees), "
            "eqmc (variance classes)")
        ->check(CLI::IsMember({"best", "paper", "nmc", "eqmc"}))
        ->capture_default_str();
    verb->add_option(
            "--effort", raw.effort,
            "How long profile best searches: normal, or fast for a few per cent more bytes")
        ->check(CLI::IsMember({"normal", "fast"}))
        ->capture_default_str();
    verb->add_option("--transform", raw.transform, "Wavelets: butterfly or loop")
        ->check(CLI::IsMember({"butterfly", "loop"}))
        ->capture_default_str();
    verb->add_option("--theta", encode.theta_degrees,
                     "Details within this angle of the normal (degrees) lose their tangential part")
        ->check(number_within(0, 90, "an angle from 0 to 90"))
        ->capture_default_str();
    add_remesh_options(verb, encode.remesh);
    add_samples(verb, raw.samples)
        ->default_str(fmt::format("{}, or {} with --effort fast", encode.samples, kFastSamples));
    verb->add_flag("--certify", encode.certify,
                   "Prove the maximum error, as --max-error does, and keep the bound in the file");
    verb->add_option("--level-table", raw.level_table,
                     "Keep PSNR and maximum error of each level in the file: on, off, or auto: "
                     "where that takes at most 1 % of it and the effort is normal")
        ->check(CLI::IsMember({"auto", "on", "off"}))
        ->capture_default_str();
    verb->add_option("--report", encode.report,
                     "Write all figures of the run to this .json file, or a page with pictures and "
                     "plots to this .html file");
    auto* semi_regular = verb->add_flag(
        "--semi-regular", encode.remesh.semi_regular,
        "The input is semi-regular already (another remesher's): find its 1 to 4 splits, whatever "
        "the order of its triangles, and code it as it is");
    semi_regular->excludes(verb->get_option("--base-vertices"))
        ->excludes(verb->get_option("--repair"));
    verb->add_option("--reference", encode.reference,
                     "The scan to measure against instead of the semi-regular mesh itself")
        ->needs(semi_regular);
    stages.add_options(*verb, encode.dump, kDumpStageNames.size());
    run_options.add_options(*verb, encode.common);
    add_overwrite(verb, encode.common);
  }

  void add_decode() {
    CLI::App* verb =
        add_verb("decode", "Turn a .ncr file into a mesh file", kDecodeFooter, decode.common);
    verb->add_option("FILE", decode.stream, "The .ncr file")->required();
    verb->add_option("-o,--output", decode.output, "The mesh to write: .ply .obj .off .stl .glb")
        ->required();
    decode_prefix.add_options(*verb, "--bytes",
                              "The finest level that so many bytes hold: 6061, 6k, 6Ki");
    verb->add_flag("--partial", decode.partial,
                   "Accept a file cut short: decode its last whole level");
    add_overwrite(verb, decode.common);
  }

  void add_cut() {
    CLI::App* verb = add_verb("cut", "Make a smaller .ncr file of one, without coding anew",
                              kCutFooter, cut.common);
    cut_prefix.add_cut(*verb, cut);
    add_overwrite(verb, cut.common);
  }

  void add_remesh() {
    CLI::App* verb = add_verb("remesh", "Turn a scan into a semi-regular normal mesh",
                              kRemeshFooter, remesh.common);
    verb->add_option("SCAN", remesh.scan, "The scan")->required();
    verb->add_option("-o,--output", remesh.output, "The mesh to write: .ply .obj .off .stl .glb");
    add_remesh_options(verb, remesh.remesh);
    add_samples(verb, remesh.samples);
    verb->add_option("--report", remesh.report, "Write all figures of the run to this .json file");
    remesh_stages.add_options(*verb, remesh.dump, kRemeshStages);
    remesh_run_options.add_options(*verb, remesh.common);
    add_overwrite(verb, remesh.common);
  }

  void add_compare() {
    CLI::App* verb = add_verb("compare", "Measure the distance between two surfaces, both ways",
                              kCompareFooter, compare.common);
    verb->add_option("A", compare.a, "The reference: a scan or a .ncr file")->required();
    verb->add_option("B", compare.b, "The other: a scan or a .ncr file")->required();
    verb->add_flag("--json", compare.json, "Print JSON (psnr_db is null for equal surfaces)");
    auto* certify = verb->add_flag("--certify", compare.certify,
                                   "Prove the maximum: bounds that hold for every point of both "
                                   "surfaces, not samples alone");
    verb->add_option("--certify-tolerance", compare.certify_percent,
                     "How far these bounds may be apart, in per cent of the value")
        ->check(number_within(0, 100, "a percentage from 0 to 100"))
        ->capture_default_str()
        ->needs(certify);
    verb->add_option("--map", compare.map,
                     "Write A as PLY with each vertex's distance to B, as float "
                     "`quality` and as colour");
    auto* picture =
        verb->add_option("--picture", compare.picture, "Write a PNG: A, B, and the distances on A");
    verb->add_option("--map-max", compare.map_max,
                     "Distance at the top of the colour scale, model units; default: the largest "
                     "for --map, the 99.5th percentile for --picture")
        ->check(positive_number());
    verb->add_option("--up", raw.up, "The picture's upward axis: x, y or z")
        ->check(CLI::IsMember({"x", "y", "z"}))
        ->capture_default_str()
        ->needs(picture);
    verb->add_option("--azimuth", compare.view.azimuth_deg, "Turn of the picture's camera, degrees")
        ->check(number_within(-360, 360, "an angle from -360 to 360"))
        ->capture_default_str()
        ->needs(picture);
    verb->add_option("--elevation", compare.view.elevation_deg, "Its height, degrees")
        ->check(number_within(-90, 90, "an angle from -90 to 90"))
        ->capture_default_str()
        ->needs(picture);
    add_samples(verb, compare.samples);
    add_overwrite(verb, compare.common);
  }

  void add_info() {
    CLI::App* verb =
        add_verb("info", "Say what a scan or a .ncr file is", kInfoFooter, info.common);
    verb->add_option("FILE", info.file, "A scan (PLY, OBJ, OFF, STL) or a .ncr file")->required();
    verb->add_flag("--json", info.json, "Print JSON");
  }
};

remesh::RepairPolicy repair_policy(const std::string& name) {
  using remesh::RepairPolicy;
  for (const auto policy :
       {RepairPolicy::kStrict, RepairPolicy::kNone, RepairPolicy::kAggressive}) {
    if (name == name_of(policy)) return policy;
  }
  return RepairPolicy::kSafe;
}

void set_verbosity(const Raw& raw, Common& common) {
  common.verbosity = raw.quiet     ? Verbosity::kQuiet
                     : raw.verbose ? Verbosity::kVerbose
                                   : Verbosity::kNormal;
}

/// The one that was named, if any was.
Result<std::optional<Goal>> goal_of(const Raw& raw) {
  using Kind = Goal::Kind;
  if (raw.size) {
    const Result<std::uint64_t> bytes = parse_size(*raw.size);
    if (!bytes) return usage_error("--size: " + bytes.error().message);
    return std::optional(Goal{Kind::kSize, static_cast<double>(*bytes)});
  }
  if (raw.max_error) {
    const Result<ErrorGoal> error = parse_error_goal(*raw.max_error);
    if (!error) return usage_error("--max-error: " + error.error().message);
    return std::optional(
        Goal{error->is_percent ? Kind::kMaxErrorPercent : Kind::kMaxError, error->value});
  }
  if (raw.bits_per_vertex)
    return std::optional(Goal{Kind::kBitsPerInputVertex, *raw.bits_per_vertex});
  if (raw.bits_per_semi_regular_vertex)
    return std::optional(Goal{Kind::kBitsPerSemiRegularVertex, *raw.bits_per_semi_regular_vertex});
  if (raw.psnr) return std::optional(Goal{Kind::kPsnr, *raw.psnr});
  if (raw.quality) return std::optional(Goal{Kind::kQuality, *raw.quality});
  return std::optional<Goal>();
}

Result<Command> finish_encode(const Raw& raw, const StageParser& stages, EncodeCommand command) {
  const bool has_output = !command.output.empty() || command.common.dry_run;
  Result<void> fine =
      stages.finish(command.dump, kDumpStageNames.size(), has_output, !command.report.empty());
  if (!fine) return fine.error();
  if (command.remesh.semi_regular && command.dump.until > DumpStage::kInput &&
      command.dump.until < DumpStage::kNormalMesh)
    return usage_error("--semi-regular has no stages between input and normal-mesh to stop after");
  const Result<std::optional<Goal>> goal = goal_of(raw);
  if (!goal) return goal.error();
  command.has_goal = goal->has_value();
  command.goal = goal->value_or(Goal{});
  command.profile = codec::profile_of_name(raw.profile).value_or(command.profile);
  if (raw.effort == "fast") {
    command.effort = codec::Effort::kFast;
    command.remesh.few_trials = true;
    command.samples = kFastSamples;
    // Certifying each level takes about as long as fast coding.
    command.level_table = LevelTableMode::kOff;
  }
  command.samples = raw.samples.value_or(command.samples);
  if (raw.level_table == "on") command.level_table = LevelTableMode::kOn;
  if (raw.level_table == "off") command.level_table = LevelTableMode::kOff;
  if (raw.transform == "loop") command.transform = wavelet::Transform::kLoop;
  command.remesh.repair = repair_policy(raw.repair);
  set_verbosity(raw, command.common);
  return Command(std::move(command));
}

Result<Command> finish_compare(const Raw& raw, CompareCommand command) {
  if (command.map_max && command.map.empty() && command.picture.empty()) {
    return usage_error("--map-max needs --map or --picture");
  }
  command.view.up = raw.up == "x" ? View::Up::kX : raw.up == "z" ? View::Up::kZ : View::Up::kY;
  set_verbosity(raw, command.common);
  return Command(std::move(command));
}

Result<Command> finish(Parser& parser, std::string_view verb) {
  const Raw& raw = parser.raw;
  if (verb == "encode") {
    const Result<void> fine = parser.run_options.finish(parser.encode.common);
    return fine ? finish_encode(raw, parser.stages, parser.encode) : fine.error();
  }
  if (verb == "completion")
    return Command(PrintText{completion_script(parser.app, parser.completion_shell)});
  if (verb == "compare") return finish_compare(raw, parser.compare);
  if (verb == "decode") {
    Result<PrefixChoice> choice = parser.decode_prefix.finish();
    if (!choice) return choice.error();
    parser.decode.choice = *choice;
    set_verbosity(raw, parser.decode.common);
    return Command(parser.decode);
  }
  if (verb == "cut") {
    set_verbosity(raw, parser.cut.common);
    Result<CutCommand> cut = parser.cut_prefix.finish_cut(parser.cut);
    if (!cut) return cut.error();
    return Command(std::move(*cut));
  }
  if (verb == "remesh") {
    parser.remesh.remesh.repair = repair_policy(raw.repair);
    const bool has_output = !parser.remesh.output.empty() || parser.remesh.common.dry_run;
    Result<void> fine = parser.remesh_stages.finish(parser.remesh.dump, kRemeshStages, has_output,
                                                    !parser.remesh.report.empty());
    if (fine) fine = parser.remesh_run_options.finish(parser.remesh.common);
    if (!fine) return fine.error();
    set_verbosity(raw, parser.remesh.common);
    return Command(parser.remesh);
  }
  if (verb == "stage") {
    Result<StageCommand> command = parser.stage_verb.finish_verb();
    if (!command) return command.error();
    command->common = parser.stage_common;
    set_verbosity(raw, command->common);
    return Command(std::move(*command));
  }
  set_verbosity(raw, parser.info.common);
  return Command(parser.info);
}

/// The first argument that looks like an option and is none of the verb's, with a suggestion.
std::string describe_unknown(const CLI::App& verb, std::span<const std::string> arguments,
                             const std::string& otherwise) {
  std::vector<std::string> known;
  std::vector<const CLI::Option*> options = verb.get_options();
  for (const CLI::App* group : verb.get_subcommands([](const CLI::App*) { return true; })) {
    const auto more = group->get_options();
    options.insert(options.end(), more.begin(), more.end());
  }
  for (const CLI::Option* option : options) {
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
    for (const std::string& name : option->get_snames()) known.push_back("-" + name);
  }
  for (const std::string& argument : arguments) {
    if (argument == "--") break;
    const std::string name = argument.substr(0, argument.find('='));
    if (!name.starts_with("--") || std::ranges::find(known, name) != known.end()) continue;
    return fmt::format("unknown option '{}'{}", name, did_you_mean(name, known));
  }
  return otherwise;
}

std::string one_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::ranges::replace(text, '\n', ' ');
  return text;
}

}  // namespace

Result<Command> parse_command_line(std::span<const std::string> arguments) {
  Parser parser;
  if (arguments.empty()) {
    return usage_error(
        "what shall it do? encode, decode, remesh, compare, info, cut, stage or batch (see nacre "
        "--help)");
  }
  const std::string& verb = arguments.front();
  const bool known = std::ranges::find(kVerbs, verb) != kVerbs.end();
  if (!known && verb != "-h" && verb != "--help" && verb != "--version") {
    const std::string what = verb.starts_with("-") ? "the verb comes first, found" : "unknown verb";
    return usage_error(
        fmt::format("{} '{}'{} (see nacre --help)", what, verb, did_you_mean(verb, kVerbs)));
  }
  // Behind "--" a batch has options of encode, which are not its own.
  const auto encode_options =
      verb == "batch" ? std::ranges::find(arguments, "--") : arguments.end();
  const std::span<const std::string> words(arguments.begin(), encode_options);
  CLI::App* selected = known ? parser.app.get_subcommand(verb) : &parser.app;
  const std::string hint =
      fmt::format("(see nacre{}{} --help)", known ? " " : "", known ? verb : "");
  try {
    std::vector<std::string> reversed(words.rbegin(), words.rend());  // as CLI11 wants them
    parser.app.parse(reversed);
  } catch (const CLI::CallForHelp&) {
    return Command(
        PrintText{selected == &parser.app ? parser.app.help() : selected->help("nacre")});
  } catch (const CLI::CallForVersion& version) {
    return Command(PrintText{one_line(version.what()) + "\n"});
  } catch (const CLI::ParseError& error) {
    const std::string what = describe_unknown(*selected, words.subspan(1), error.what());
    return usage_error(fmt::format("{} {}", one_line(what), hint));
  }
  if (verb == "batch") {
    std::vector<std::string> rest(encode_options, arguments.end());
    if (!rest.empty()) rest.erase(rest.begin());
    Result<BatchCommand> batch = parser.batch.finish(std::move(rest));
    if (!batch) return batch.error();
    return Command(std::move(*batch));
  }
  return finish(parser, verb);
}

}  // namespace nacre::app
