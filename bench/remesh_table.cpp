// SPDX-License-Identifier: GPL-3.0-or-later
//
// One row per scan: what cleaning did, what the normal mesh is like. Each scan is remeshed in a
// process of its own (this program again, with --row), so that a crash or a hang is a row and
// memory is that scan's alone.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <map>
#include <sstream>
#include <utility>

#include "app/files.h"
#include "app/report.h"
#include "bench/support.h"
#include "io/io.h"
#include "wavelet/wavelet.h"

namespace nacre::bench {
namespace {

struct Settings {
  std::vector<std::string> meshes;
  std::string row;  ///< set in the child
  double timeout_seconds = 300;
  std::size_t samples = 1'000'000;
  remesh::Options remesh;
};

const std::vector<Table::Column> kColumns = {{"mesh", true},
                                             {"triangles"},
                                             {"pieces (closed)"},
                                             {"boundary loops"},
                                             {"genus"},
                                             {"cleaning", true},
                                             {"base vertices"},
                                             {"J"},
                                             {"topology kept", true},
                                             {"remeshing PSNR dB"},
                                             {"PSNR of max dB"},
                                             {"max % of diagonal"},
                                             {"normal-only %"},
                                             {"worst level %"},
                                             {"folds per level"},
                                             {"fallbacks", true},
                                             {"remesh s"},
                                             {"peak MB"},
                                             {"peak B / triangle"},
                                             {"whole run", true}};

std::string cleaning_text(const remesh::CleanReport& clean) {
  std::vector<std::string> parts;
  for (const remesh::CleanAction& action : clean.actions)
    parts.push_back(fmt::format("{} {}", action.count, action.kind));
  return parts.empty() ? "none" : fmt::format("{}", fmt::join(parts, ", "));
}

std::string fallback_text(const std::vector<remesh::PieceReport>& pieces) {
  std::map<std::string, int> count;
  for (const remesh::PieceReport& piece : pieces)
    if (!piece.fallback.empty()) ++count[piece.fallback];
  std::vector<std::string> parts;
  for (const auto& [what, times] : count) parts.push_back(fmt::format("{} x {}", times, what));
  return parts.empty() ? "none" : fmt::format("{}", fmt::join(parts, "; "));
}

struct TopologyFacts {
  long long euler = 0;
  std::size_t boundary_loops = 0;
};

TopologyFacts facts_of_base(const SemiRegularMesh& mesh) {
  const auto topology = Topology::build(mesh.base_triangles, mesh.base_vertex_count, 1);
  if (!topology) return {};
  const LevelTopology& base = topology->level(0);
  TopologyFacts facts;
  facts.euler = static_cast<long long>(base.vertex_count) -
                static_cast<long long>(base.edges.size()) +
                static_cast<long long>(base.triangles.size());
  // A manifold's boundary vertex has one boundary edge that leaves it.
  std::vector<std::uint32_t> next(base.vertex_count, kNone);
  for (const Edge& edge : base.edges)
    if (edge.is_boundary()) next[edge.vertex[0]] = edge.vertex[1];
  for (std::uint32_t v = 0; v < base.vertex_count; ++v) {
    if (next[v] == kNone) continue;
    ++facts.boundary_loops;
    for (std::uint32_t w = v; w != kNone;) w = std::exchange(next[w], kNone);
  }
  return facts;
}

std::string topology_text(const remesh::Remesh& remesh) {
  const remesh::CleanReport& clean = remesh.clean;
  const long long euler = 2 * static_cast<long long>(clean.pieces) - 2LL * clean.genus -
                          static_cast<long long>(clean.boundary_loops);
  const TopologyFacts base = facts_of_base(remesh.mesh);
  if (base.euler == euler && base.boundary_loops == clean.boundary_loops) return "yes";
  return fmt::format("NO: Euler characteristic {} -> {}, loops {} -> {}", euler, base.euler,
                     clean.boundary_loops, base.boundary_loops);
}

/// The cells of `kColumns` but the last, one a line.
void print_cells(const std::string& file, std::size_t triangles, const remesh::Remesh& r,
                 const metric::Comparison& distance, double seconds, std::size_t peak_bytes) {
  double normal = 0, all = 0, worst = 1;
  std::vector<std::size_t> folds;
  for (const remesh::BandReport& band : r.bands) {
    const auto vertices = static_cast<double>(band.vertices);
    normal += static_cast<double>(band.normal_only);
    all += vertices;
    worst = std::min(worst, static_cast<double>(band.normal_only) / std::max(vertices, 1.0));
    folds.push_back(band.folded_triangles);
  }
  const auto line = [](const std::string& text) { fmt::print("{}\n", text); };
  line(std::filesystem::path(file).stem().string());
  line(std::to_string(triangles));
  line(fmt::format("{} ({})", r.clean.pieces, r.clean.closed_pieces));
  line(std::to_string(r.clean.boundary_loops));
  line(std::to_string(r.clean.genus));
  line(cleaning_text(r.clean));
  line(std::to_string(r.mesh.base_vertex_count));
  line(std::to_string(r.mesh.level_count));
  line(topology_text(r));
  line(fmt::format("{:.2f}", distance.psnr_db));
  line(fmt::format("{:.2f}", psnr_of_maximum_db(distance)));
  line(fmt::format("{:.3f}", 100 * app::max_error(distance) / distance.bbox_diagonal));
  line(fmt::format("{:.2f}", 100 * normal / std::max(all, 1.0)));
  line(fmt::format("{:.2f}", 100 * worst));
  line(fmt::format("{}", fmt::join(folds, " ")));
  line(fallback_text(r.pieces));
  line(fmt::format("{:.1f}", seconds));
  line(fmt::format("{:.0f}", static_cast<double>(peak_bytes) * 1e-6));
  line(fmt::format("{:.0f}", static_cast<double>(peak_bytes) / static_cast<double>(triangles)));
}

int run_row(const Settings& settings) {
  const auto fail = [](const Error& error) {
    fmt::print(stderr, "{}\n", error.message);
    return 1;
  };
  const auto read = io::read_scan(settings.row);
  if (!read) return fail(read.error());
  const auto begin = std::chrono::steady_clock::now();
  const auto remeshed = remesh::remesh(read->scan, settings.remesh);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (!remeshed) return fail(remeshed.error());
  const std::size_t peak_bytes = app::peak_resident_bytes();
  const auto triangles = app::to_triangles(remeshed->mesh);
  if (!triangles) return fail(triangles.error());
  const auto distance = metric::compare(read->scan, *triangles, {.samples = settings.samples});
  if (!distance) return fail(distance.error());
  print_cells(settings.row, read->scan.triangles.size(), *remeshed, *distance, seconds, peak_bytes);
  return 0;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

int run_table(const Settings& settings, const std::vector<std::string>& passed_on) {
  const Table table(kColumns);
  table.print_header();
  int failures = 0;
  for (const std::string& mesh : settings.meshes) {
    std::vector<std::string> arguments = {"/proc/self/exe", "--row", mesh};
    arguments.insert(arguments.end(), passed_on.begin(), passed_on.end());
    const ChildRun child = run_child(arguments, settings.timeout_seconds);
    std::vector<std::string> cells = lines_of(child.out);
    if (!child.ok()) {
      ++failures;
      cells = {std::filesystem::path(mesh).stem().string()};
    }
    cells.resize(kColumns.size() - 1, "-");
    cells.push_back(fmt::format("{}, {:.1f} s, {:.0f} MB", child.outcome(), child.seconds,
                                static_cast<double>(child.peak_bytes) * 1e-6));
    table.print_row(cells);
  }
  return failures == 0 ? 0 : 1;
}

int main_of(int argc, char** argv) {
  Settings settings;
  CLI::App app("Remeshes scans and tells how healthy the results are", "remesh_table");
  app.add_option("MESH", settings.meshes, "Scans; default: all of the corpus");
  app.add_option("--row", settings.row, "Remesh one scan and print its cells, one a line");
  app.add_option("--timeout", settings.timeout_seconds, "Seconds for one scan, measuring included")
      ->capture_default_str();
  app.add_option("--samples", settings.samples, "Area samples each way")->capture_default_str();
  app.add_option("--levels", settings.remesh.levels, "0: as remesh chooses");
  app.add_option("--base-vertices", settings.remesh.base_vertices, "0: as remesh chooses");
  CLI11_PARSE(app, argc, argv);
  settings.remesh.predict = wavelet::predict;
  if (!settings.row.empty()) return run_row(settings);
  if (settings.meshes.empty()) settings.meshes = corpus_meshes();
  print_head(argc, argv);
  return run_table(settings, {"--samples", std::to_string(settings.samples), "--levels",
                              std::to_string(settings.remesh.levels), "--base-vertices",
                              std::to_string(settings.remesh.base_vertices)});
}

}  // namespace
}  // namespace nacre::bench

int main(int argc, char** argv) { return nacre::bench::main_of(argc, argv); }
