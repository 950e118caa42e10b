// SPDX-License-Identifier: GPL-3.0-or-later
//
// Each scan as it is and in other guises, each remeshed in a process of its own: how much the
// outcome changes. What is moved far away is written to a file and read again: such scans get an
// origin when they are read.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <sstream>

#include "app/report.h"
#include "bench/remesh_measure.h"
#include "bench/support.h"
#include "io/io.h"
#include "io/write.h"
#include "tests/support/transforms.h"
#include "wavelet/wavelet.h"

namespace nacre::bench {
namespace {

constexpr const char* kAsItIs = "as it is";
constexpr double kMostLossDb = 2;
constexpr double kFar = 1e6;

struct Settings {
  std::vector<std::string> meshes;
  std::vector<std::string> guises{transforms::kNames.begin(), transforms::kNames.end()};
  std::string row, guise = kAsItIs;  ///< set in the child
  double timeout_seconds = 900;
  std::size_t samples = 500'000;
  std::uint64_t seed = 1;
  remesh::Options remesh;
};

const std::vector<Table::Column> kColumns = {
    {"mesh", true},  {"guise", true},   {"base vertices"},   {"J"},
    {"PSNR dB"},     {"change dB"},     {"max %"},           {"worst level %"},
    {"folds found"}, {"surface", true}, {"same kind", true}, {"CPU s"},
    {"peak MB"},     {"verdict", true}};

/// What the child prints, one a line.
enum Cell : std::size_t {
  kBase,
  kLevels,
  kPsnr,
  kMax,
  kWorst,
  kFolds,
  kSurface,
  kCpu,
  kPeak,
  kCells
};

/// Far from zero in the file, so that reading gives it an origin.
Result<Scan> moved_in_its_file(Scan scan) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "scan.ply";
  scan.origin += Vec3(kFar, -kFar, kFar);
  const auto bytes = io::serialize_mesh(scan, io::MeshFormat::kPly);
  if (!bytes) return bytes.error();
  if (const Result<void> written = io::write_file(file, *bytes, false); !written)
    return written.error();
  auto back = io::read_scan(file);
  if (!back) return back.error();
  return std::move(back->scan);
}

Result<Scan> in_guise(const Settings& settings) {
  auto read = io::read_scan(settings.row);
  if (!read) return read.error();
  if (settings.guise == "moved") return moved_in_its_file(std::move(read->scan));
  return transforms::named(read->scan, settings.guise, settings.seed);
}

int run_row(const Settings& settings) {
  const auto fail = [](const Error& error) {
    fmt::print(stderr, "{}\n", error.message);
    return 1;
  };
  const auto scan = in_guise(settings);
  if (!scan) return fail(scan.error());
  const double cpu_begin = cpu_seconds();
  const auto remeshed = remesh::remesh(*scan, settings.remesh);
  const double cpu = cpu_seconds() - cpu_begin;
  const std::size_t peak_bytes = app::peak_resident_bytes();
  if (!remeshed) return fail(remeshed.error());
  const auto health = measure_health(*scan, *remeshed, settings.samples);
  if (!health) return fail(health.error());
  std::size_t folds = 0;
  for (const std::size_t of_level : health->folds) folds += of_level;
  std::array<std::string, kCells> cells;
  cells[kBase] = std::to_string(remeshed->mesh.base_vertex_count);
  cells[kLevels] = std::to_string(remeshed->mesh.level_count);
  cells[kPsnr] = fmt::format("{:.2f}", health->distance.psnr_db);
  cells[kMax] = fmt::format("{:.3f}", health->max_percent());
  cells[kWorst] = fmt::format("{:.2f}", 100 * health->worst_level);
  cells[kFolds] = std::to_string(folds);
  cells[kSurface] = health->topology_out.text();
  cells[kCpu] = fmt::format("{:.1f}", cpu);
  cells[kPeak] = fmt::format("{:.0f}", static_cast<double>(peak_bytes) * 1e-6);
  for (const std::string& cell : cells) fmt::print("{}\n", cell);
  return 0;
}

struct Outcome {
  bool ok = false;
  std::string failure;
  std::vector<std::string> cells;
  [[nodiscard]] double psnr_db() const { return std::strtod(cells[kPsnr].c_str(), nullptr); }
};

Outcome run_guise(const Settings& settings, const std::string& mesh, const std::string& guise) {
  const ChildRun child =
      run_child({"/proc/self/exe", "--row", mesh, "--guise", guise, "--samples",
                 std::to_string(settings.samples), "--seed", std::to_string(settings.seed),
                 "--levels", std::to_string(settings.remesh.levels), "--base-vertices",
                 std::to_string(settings.remesh.base_vertices)},
                settings.timeout_seconds);
  Outcome outcome;
  outcome.ok = child.ok();
  outcome.failure = child.outcome();
  std::istringstream in(child.out);
  for (std::string line; std::getline(in, line);) outcome.cells.push_back(line);
  outcome.cells.resize(kCells, "-");
  return outcome;
}

std::string verdict_of(const Outcome& plain, const Outcome& changed) {
  if (!changed.ok) return changed.failure;
  if (!plain.ok) return "nothing to compare with";
  if (changed.cells[kSurface] != plain.cells[kSurface]) return "another surface";
  if (!(changed.psnr_db() >= plain.psnr_db() - kMostLossDb)) return "worse";
  return "-";
}

/// Meshes without any error are alike.
double change_db(const Outcome& from, const Outcome& to) {
  return from.psnr_db() == to.psnr_db() ? 0 : to.psnr_db() - from.psnr_db();
}

void print_row(const Table& table, const std::string& mesh, const std::string& guise,
               const Outcome& plain, const Outcome& outcome, const std::string& verdict) {
  const auto& c = outcome.cells;
  const bool both = outcome.ok && plain.ok;
  table.print_row({mesh, guise, c[kBase], c[kLevels], c[kPsnr],
                   both ? fmt::format("{:+.2f}", change_db(plain, outcome)) : "-", c[kMax],
                   c[kWorst], c[kFolds], c[kSurface],
                   !both                                  ? "-"
                   : c[kSurface] == plain.cells[kSurface] ? "yes"
                                                          : "NO",
                   c[kCpu], c[kPeak], verdict});
}

int run_table(const Settings& settings) {
  const Table table(kColumns);
  table.print_header();
  std::vector<std::string> outside;
  std::size_t runs = 0;
  for (const std::string& file : settings.meshes) {
    const std::string mesh = std::filesystem::path(file).stem().string();
    const Outcome plain = run_guise(settings, file, kAsItIs);
    print_row(table, mesh, kAsItIs, plain, plain, plain.ok ? "" : plain.failure);
    if (!plain.ok) outside.push_back(mesh + ": " + plain.failure);
    for (const std::string& guise : settings.guises) {
      const Outcome outcome = run_guise(settings, file, guise);
      const std::string verdict = verdict_of(plain, outcome);
      ++runs;
      if (verdict != "-") outside.push_back(fmt::format("{}, {}: {}", mesh, guise, verdict));
      print_row(table, mesh, guise, plain, outcome, verdict);
    }
  }
  fmt::print(
      "\nOutside the bounds (PSNR at most {:.0f} dB below that of the scan as it is; the same "
      "pieces, boundary loops and genus), of {} runs:{}\n",
      kMostLossDb, runs, outside.empty() ? " nothing" : "");
  for (const std::string& line : outside) fmt::print("- {}\n", line);
  return outside.empty() ? 0 : 1;
}

int main_of(int argc, char** argv) {
  Settings settings;
  CLI::App app("Remeshes scans in other guises and tells how much changes", "remesh_invariance");
  app.add_option("MESH", settings.meshes, "Scans; default: all of the corpus");
  app.add_option("--guises", settings.guises)
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember(
          std::vector<std::string>(transforms::kNames.begin(), transforms::kNames.end())))
      ->capture_default_str();
  app.add_option("--seed", settings.seed, "Of rotation, order, flips and noise")
      ->capture_default_str();
  app.add_option("--row", settings.row, "Remesh one scan and print its cells, one a line");
  app.add_option("--guise", settings.guise, "With --row: in this guise");
  app.add_option("--timeout", settings.timeout_seconds, "Seconds for one run, measuring included")
      ->capture_default_str();
  app.add_option("--samples", settings.samples, "Area samples each way")->capture_default_str();
  app.add_option("--levels", settings.remesh.levels, "0: as remesh chooses");
  app.add_option("--base-vertices", settings.remesh.base_vertices, "0: as remesh chooses");
  CLI11_PARSE(app, argc, argv);
  settings.remesh.predict = wavelet::predict_at_need;
  if (!settings.row.empty()) return run_row(settings);
  if (settings.meshes.empty()) settings.meshes = corpus_meshes();
  print_head(argc, argv);
  return run_table(settings);
}

}  // namespace
}  // namespace nacre::bench

int main(int argc, char** argv) { return nacre::bench::main_of(argc, argv); }
