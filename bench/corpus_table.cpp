// SPDX-License-Identifier: GPL-3.0-or-later
//
// Every scan through the `nacre` command as a user runs it: encode, decode, compare.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "bench/support.h"

namespace nacre::bench {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

struct Settings {
  std::vector<std::string> meshes;
  std::string profile = "best", nacre = NACRE_COMMAND, size;
  double bits_per_input_vertex = 4;
  double timeout_seconds = 300;
};

const std::vector<Table::Column> kColumns = {{"mesh", true},
                                             {"file bytes"},
                                             {"bytes"},
                                             {"ratio"},
                                             {"bits / input vertex"},
                                             {"PSNR dB"},
                                             {"max error %"},
                                             {"remeshing PSNR dB"},
                                             {"cleaning", true},
                                             {"fallbacks"},
                                             {"encode s"},
                                             {"peak MB"},
                                             {"decode s"},
                                             {"decode peak MB"},
                                             {"exit codes", true}};

std::string megabytes(std::size_t bytes) {
  return fmt::format("{:.0f}", static_cast<double>(bytes) * 1e-6);
}

std::string cleaning_text(const Json& report) {
  std::vector<std::string> parts;
  for (const Json& action : report["clean"]["actions"])
    parts.push_back(fmt::format("{} {}", action["count"].get<std::size_t>(),
                                action["kind"].get<std::string>()));
  return parts.empty() ? "none" : fmt::format("{}", fmt::join(parts, ", "));
}

std::size_t fallback_count(const Json& report) {
  return static_cast<std::size_t>(std::count_if(
      report["pieces"].begin(), report["pieces"].end(),
      [](const Json& piece) { return !piece["fallback"].get<std::string>().empty(); }));
}

std::string number(const Json& value, int digits) {
  return value.is_number() ? fmt::format("{:.{}f}", value.get<double>(), digits) : "-";
}

/// The three runs on one scan.
struct Runs {
  ChildRun encode, decode, compare;
  Json report, distance;  ///< what encode and compare said; null if they failed
};

Json read_json(const std::string& text) { return Json::parse(text, nullptr, false); }

Runs run_mesh(const std::string& mesh, const Settings& settings) {
  const TemporaryFolder folder;
  const std::string stream = folder.path() / "out.ncr", report = folder.path() / "report.json",
                    surface = folder.path() / "out.ply";
  std::vector<std::string> encode = {settings.nacre, "encode", mesh,       "-o",
                                     stream,         "-q",     "--report", report};
  if (settings.size.empty()) {
    encode.insert(encode.end(),
                  {"--bits-per-vertex", fmt::format("{}", settings.bits_per_input_vertex)});
  } else {
    encode.insert(encode.end(), {"--size", settings.size});
  }
  encode.insert(encode.end(), {"--profile", settings.profile});
  Runs runs;
  runs.encode = run_child(encode, settings.timeout_seconds);
  if (!runs.encode.ok()) return runs;
  runs.report = read_json(run_child({"cat", report}, settings.timeout_seconds).out);
  runs.decode =
      run_child({settings.nacre, "decode", stream, "-o", surface, "-q"}, settings.timeout_seconds);
  if (!runs.decode.ok()) return runs;
  runs.compare = run_child({settings.nacre, "compare", mesh, surface, "--json", "-q"},
                           settings.timeout_seconds);
  if (runs.compare.ok()) runs.distance = read_json(runs.compare.out);
  return runs;
}

void print_mesh(const Table& table, const std::string& mesh, const Runs& runs) {
  const std::string name = fs::path(mesh).stem().string();
  const auto file_bytes = static_cast<double>(fs::file_size(mesh));
  std::vector<std::string> cells = {name, fmt::format("{:.0f}", file_bytes)};
  if (runs.report.is_object()) {
    const auto bytes = runs.report["bytes"].get<std::size_t>();
    cells.push_back(std::to_string(bytes));
    cells.push_back(fmt::format("{:.0f}", file_bytes / static_cast<double>(bytes)));
    cells.push_back(number(runs.report["bits_per_input_vertex"], 3));
    if (runs.distance.is_object()) {
      const double diagonal = runs.distance["bbox_diagonal"].get<double>();
      const double largest = std::max(runs.distance["max_a_to_b"].get<double>(),
                                      runs.distance["max_b_to_a"].get<double>());
      cells.push_back(number(runs.distance["psnr_db"], 2));
      cells.push_back(fmt::format("{:.3f}", 100 * largest / diagonal));
    } else {
      cells.insert(cells.end(), {"-", "-"});
    }
    cells.push_back(number(runs.report["remesh_psnr_db"], 2));
    cells.push_back(cleaning_text(runs.report));
    cells.push_back(std::to_string(fallback_count(runs.report)));
  }
  cells.resize(10, "-");
  cells.push_back(fmt::format("{:.1f}", runs.encode.seconds));
  cells.push_back(megabytes(runs.encode.peak_bytes));
  cells.push_back(runs.encode.ok() ? fmt::format("{:.2f}", runs.decode.seconds) : "-");
  cells.push_back(runs.encode.ok() ? megabytes(runs.decode.peak_bytes) : "-");
  std::string codes = "encode " + runs.encode.outcome();
  if (runs.encode.ok()) codes += ", decode " + runs.decode.outcome();
  if (runs.decode.ok()) codes += ", compare " + runs.compare.outcome();
  if (runs.compare.ok()) codes = "0 0 0";
  cells.push_back(codes);
  table.print_row(cells);
}

int main_of(int argc, char** argv) {
  Settings settings;
  CLI::App app("Encodes and decodes scans with the nacre command", "corpus_table");
  app.add_option("MESH", settings.meshes, "Scans; default: all of the corpus");
  auto* bits =
      app.add_option("--bits-per-vertex", settings.bits_per_input_vertex)->capture_default_str();
  app.add_option("--size", settings.size, "Whole-file size instead, e.g. 16k")->excludes(bits);
  app.add_option("--profile", settings.profile, "As nacre encode takes it")->capture_default_str();
  app.add_option("--timeout", settings.timeout_seconds, "Seconds for one command")
      ->capture_default_str();
  app.add_option("--nacre", settings.nacre, "The command")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  if (settings.meshes.empty()) settings.meshes = corpus_meshes();
  print_head(argc, argv);
  const Table table(kColumns);
  table.print_header();
  int failures = 0;
  for (const std::string& mesh : settings.meshes) {
    const Runs runs = run_mesh(mesh, settings);
    if (!runs.compare.ok()) ++failures;
    print_mesh(table, mesh, runs);
  }
  return failures == 0 ? 0 : 1;
}

}  // namespace
}  // namespace nacre::bench

int main(int argc, char** argv) { return nacre::bench::main_of(argc, argv); }
