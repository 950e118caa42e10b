// SPDX-License-Identifier: GPL-3.0-or-later
//
// What --quality means: bytes, PSNR and maximum error over the corpus. The figures that
// app/goal.cpp takes for usual are medians of this table.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "bench/support.h"

namespace nacre::bench {
namespace {

struct Settings {
  std::vector<std::string> meshes;
  std::vector<double> qualities = {0, 25, 50, 62.5, 75, 87.5, 100};
  std::string nacre = NACRE_COMMAND;
  double timeout_seconds = 600;
};

struct Row {
  double bytes = 0, bits_per_vertex = 0, psnr_db = 0, max_percent = 0;
};

std::optional<Row> run_quality(const std::string& mesh, double quality, const Settings& settings) {
  const TemporaryFolder folder;
  const std::string stream = folder.path() / "out.ncr", report = folder.path() / "report.json";
  const ChildRun run = run_child({settings.nacre, "encode", mesh, "-o", stream, "--report", report,
                                  "--quality", fmt::format("{}", quality)},
                                 settings.timeout_seconds);
  if (!run.ok()) {
    fmt::print(stderr, "{} at {}: {}\n", mesh, quality, run.outcome());
    return std::nullopt;
  }
  std::ifstream file(report);
  const auto json = nlohmann::json::parse(file, nullptr, false);
  return Row{json["bytes"], json["bits_per_input_vertex"], json["psnr_db"],
             json["max_error_percent"]};
}

template <class Value>
double median(const std::vector<Row>& rows, const Value& value) {
  std::vector<double> values;
  for (const Row& row : rows) values.push_back(value(row));
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

int main_of(int argc, char** argv) {
  Settings settings;
  CLI::App app("Bytes and errors at qualities", "quality_table");
  app.add_option("MESH", settings.meshes, "Scans; default: all of the corpus");
  app.add_option("--qualities", settings.qualities, "0 .. 100")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--timeout", settings.timeout_seconds, "Seconds for one run")
      ->capture_default_str();
  app.add_option("--nacre", settings.nacre, "The command")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  if (settings.meshes.empty()) settings.meshes = corpus_meshes();
  print_head(argc, argv);
  const Table table({{"mesh", true},
                     {"quality"},
                     {"bytes"},
                     {"bits per input vertex"},
                     {"PSNR dB"},
                     {"max error %"}});
  table.print_header();
  const auto print = [&](const std::string& name, double quality, const Row& row) {
    table.print_row({name, fmt::format("{:g}", quality), fmt::format("{:.0f}", row.bytes),
                     fmt::format("{:.3f}", row.bits_per_vertex), fmt::format("{:.2f}", row.psnr_db),
                     fmt::format("{:.3f}", row.max_percent)});
    std::fflush(stdout);
  };
  std::vector<std::vector<Row>> all(settings.qualities.size());
  for (const std::string& mesh : settings.meshes) {
    for (std::size_t i = 0; i < settings.qualities.size(); ++i) {
      const auto row = run_quality(mesh, settings.qualities[i], settings);
      if (!row) continue;
      all[i].push_back(*row);
      print(std::filesystem::path(mesh).stem().string(), settings.qualities[i], *row);
    }
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].empty()) continue;
    const auto& rows = all[i];
    print("median", settings.qualities[i],
          {median(rows, [](const Row& r) { return r.bytes; }),
           median(rows, [](const Row& r) { return r.bits_per_vertex; }),
           median(rows, [](const Row& r) { return r.psnr_db; }),
           median(rows, [](const Row& r) { return r.max_percent; })});
  }
  return 0;
}

}  // namespace
}  // namespace nacre::bench

int main(int argc, char** argv) { return nacre::bench::main_of(argc, argv); }
