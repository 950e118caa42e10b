// SPDX-License-Identifier: GPL-3.0-or-later
//
// Time and memory of remeshing against the size of the scan, and against CGAL's own edge-collapse
// simplification of the same mesh. One scan is simplified by CGAL (small sizes) or split 1 to 4 and
// perturbed (large ones); making it, remeshing it and simplifying it are a process each.
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <sstream>
#include <utility>

#include "app/allocator.h"
#include "app/report.h"
#include "app/sizes.h"
#include "base/topology.h"
#include "bench/remesh_measure.h"
#include "bench/support.h"
#include "io/io.h"
#include "io/write.h"
#include "tests/support/corpus.h"
#include "tests/support/transforms.h"
#include "wavelet/wavelet.h"

namespace nacre::bench {
namespace {

namespace fs = std::filesystem;
using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

constexpr std::size_t kBaseVertices = 200;  // where CGAL's simplification stops
constexpr double kNoise = 0.02;             // of the mean edge, after each split
constexpr double kMostBytesPerTriangle = 1000;

struct Settings {
  std::string source;
  std::vector<std::string> sizes = {"10k", "30k", "100k", "300k", "1M", "4M"};
  std::vector<std::string> as_they_are;
  std::string make, remesh_file, simplify_file;  ///< set in the children
  std::size_t triangles = 0;
  double timeout_seconds = 3600;
  bool without_cgal = false;
  remesh::Options remesh;
};

/// Refused by nothing: cleaned scans are manifolds.
Mesh to_cgal(const Scan& scan) {
  Mesh mesh;
  for (const Vec3& p : scan.positions) mesh.add_vertex({p[0], p[1], p[2]});
  for (const Triangle& t : scan.triangles)
    mesh.add_face(Mesh::Vertex_index(t[0]), Mesh::Vertex_index(t[1]), Mesh::Vertex_index(t[2]));
  return mesh;
}

Scan from_cgal(Mesh& mesh) {
  mesh.collect_garbage();
  Scan scan;
  for (const auto v : mesh.vertices()) {
    const auto& p = mesh.point(v);
    scan.positions.emplace_back(p.x(), p.y(), p.z());
  }
  for (const auto f : mesh.faces()) {
    auto h = mesh.halfedge(f);
    Triangle t{};
    for (std::uint32_t& corner : t) {
      corner = mesh.target(h);
      h = mesh.next(h);
    }
    scan.triangles.push_back(t);
  }
  return scan;
}

/// CGAL's defaults: cost and placement of Lindstrom and Turk.
void collapse_edges(Mesh& mesh, std::size_t edges) {
  namespace sms = CGAL::Surface_mesh_simplification;
  sms::edge_collapse(mesh, sms::Count_stop_predicate<Mesh>(edges));
}

Result<Scan> split(const Scan& scan) {
  const auto topology =
      Topology::build(scan.triangles, static_cast<std::uint32_t>(scan.positions.size()), 1);
  if (!topology) return topology.error();
  Scan out{scan.positions, topology->level(1).triangles, scan.origin};
  for (const Edge& e : topology->level(0).edges)
    out.positions.push_back((scan.positions[e.vertex[0]] + scan.positions[e.vertex[1]]) / 2);
  return out;
}

/// The source with about that many triangles.
Result<Scan> of_size(const std::string& source, std::size_t triangles) {
  const auto read = io::read_scan(source);
  if (!read) return read.error();
  auto cleaned = remesh::clean(read->scan);
  if (!cleaned) return cleaned.error();
  Scan scan = std::move(cleaned->scan);
  int splits = 0;
  while ((triangles >> (2 * splits)) > scan.triangles.size()) ++splits;
  const std::size_t coarse = triangles >> (2 * splits);
  Mesh mesh = to_cgal(scan);
  collapse_edges(mesh, coarse * 3 / 2);  // of a closed mesh, nearly of others
  scan = from_cgal(mesh);
  for (int i = 0; i < splits; ++i) {
    auto finer = split(scan);
    if (!finer) return finer.error();
    scan = transforms::with_noise(std::move(*finer), kNoise, static_cast<std::uint64_t>(i));
  }
  return scan;
}

struct Cost {
  std::size_t triangles = 0, peak_bytes = 0;
  double cpu_seconds = 0, wall_seconds = 0;
};

template <class Work>
int measured(std::size_t triangles, const Work& work) {
  const auto begin = std::chrono::steady_clock::now();
  const double cpu_begin = cpu_seconds();
  const Result<void> done = work();
  const double wall =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (!done) {
    fmt::print(stderr, "{}\n", done.error().message);
    return 1;
  }
  fmt::print("{} {} {:.3f} {:.3f}\n", triangles, app::peak_resident_bytes(),
             cpu_seconds() - cpu_begin, wall);
  return 0;
}

int run_child_job(const Settings& settings) {
  const auto fail = [](const Error& error) {
    fmt::print(stderr, "{}\n", error.message);
    return 1;
  };
  if (!settings.make.empty()) {
    const auto scan = of_size(settings.source, settings.triangles);
    if (!scan) return fail(scan.error());
    const auto bytes = io::serialize_mesh(*scan, io::MeshFormat::kPly);
    if (!bytes) return fail(bytes.error());
    const Result<void> written = io::write_file(settings.make, *bytes, true);
    return written ? 0 : fail(written.error());
  }
  const bool remeshing = settings.simplify_file.empty();
  const auto read = io::read_scan(remeshing ? settings.remesh_file : settings.simplify_file);
  if (!read) return fail(read.error());
  if (remeshing) {
    return measured(read->scan.triangles.size(), [&]() -> Result<void> {
      const auto remeshed = remesh::remesh(read->scan, settings.remesh);
      return remeshed ? Result<void>() : remeshed.error();
    });
  }
  auto cleaned = remesh::clean(read->scan);
  if (!cleaned) return fail(cleaned.error());
  return measured(read->scan.triangles.size(), [&]() -> Result<void> {
    Mesh mesh = to_cgal(cleaned->scan);
    collapse_edges(mesh, 3 * kBaseVertices);
    return {};
  });
}

std::optional<Cost> cost_of(const ChildRun& child) {
  Cost cost;
  std::istringstream in(child.out);
  in >> cost.triangles >> cost.peak_bytes >> cost.cpu_seconds >> cost.wall_seconds;
  if (!child.ok() || !in) return std::nullopt;
  return cost;
}

const std::vector<Table::Column> kColumns = {{"scan", true},
                                             {"triangles"},
                                             {"CPU s"},
                                             {"wall s"},
                                             {"CPU µs / triangle"},
                                             {"exponent of CPU"},
                                             {"CPU / (n log n), first = 1"},
                                             {"peak MB"},
                                             {"peak B / triangle"},
                                             {"exponent of peak"},
                                             {"CGAL CPU s"},
                                             {"CPU ratio"},
                                             {"CGAL wall s"},
                                             {"wall ratio"},
                                             {"notes", true}};

double n_log_n(const Cost& cost) {
  const auto n = static_cast<double>(cost.triangles);
  return n * std::log(n);
}

class Rows {
 public:
  Rows(const Settings& settings) : settings_(settings), table_(kColumns) {}

  void print_header() const { table_.print_header(); }
  [[nodiscard]] bool failed() const { return failed_; }

  /// `in_series`: to be compared with the row before.
  void add(const std::string& name, const std::string& file, bool in_series, double most_wall) {
    const ChildRun remeshing = run_child(
        {"/proc/self/exe", "--remesh", file, "--levels", std::to_string(settings_.remesh.levels),
         "--base-vertices", std::to_string(settings_.remesh.base_vertices)},
        settings_.timeout_seconds);
    const std::optional<Cost> cost = cost_of(remeshing);
    if (!cost) {
      failed_ = true;
      table_.print_row({name, "-", "-", "-", "-", "-", "-", "-", "-", "-", "-", "-", "-", "-",
                        remeshing.outcome()});
      return;
    }
    std::optional<Cost> cgal;
    if (!settings_.without_cgal)
      cgal = cost_of(run_child({"/proc/self/exe", "--simplify", file}, settings_.timeout_seconds));
    print(name, *cost, cgal, in_series, most_wall);
    if (!in_series) return;
    if (!first_) first_ = cost;
    before_ = cost;
  }

 private:
  void print(const std::string& name, const Cost& cost, const std::optional<Cost>& cgal,
             bool in_series, double most_wall) {
    const auto n = static_cast<double>(cost.triangles);
    const double bytes_per_triangle = static_cast<double>(cost.peak_bytes) / n;
    std::string cpu_exponent = "-", peak_exponent = "-", against = "-";
    if (in_series && before_) {
      const double growth = std::log(n / static_cast<double>(before_->triangles));
      cpu_exponent =
          fmt::format("{:.2f}", std::log(cost.cpu_seconds / before_->cpu_seconds) / growth);
      peak_exponent = fmt::format("{:.2f}", std::log(static_cast<double>(cost.peak_bytes) /
                                                     static_cast<double>(before_->peak_bytes)) /
                                                growth);
      against = fmt::format(
          "{:.2f}", cost.cpu_seconds / n_log_n(cost) / (first_->cpu_seconds / n_log_n(*first_)));
    }
    std::string notes;
    if (most_wall > 0 && cost.wall_seconds > most_wall)
      notes += fmt::format("over {:.0f} s; ", most_wall);
    if (bytes_per_triangle > kMostBytesPerTriangle)
      notes += fmt::format("over {:.0f} B / triangle; ", kMostBytesPerTriangle);
    table_.print_row({name, std::to_string(cost.triangles), fmt::format("{:.1f}", cost.cpu_seconds),
                      fmt::format("{:.1f}", cost.wall_seconds),
                      fmt::format("{:.1f}", 1e6 * cost.cpu_seconds / n), cpu_exponent, against,
                      fmt::format("{:.0f}", static_cast<double>(cost.peak_bytes) * 1e-6),
                      fmt::format("{:.0f}", bytes_per_triangle), peak_exponent,
                      cgal ? fmt::format("{:.1f}", cgal->cpu_seconds) : "-",
                      cgal ? fmt::format("{:.2f}", cost.cpu_seconds / cgal->cpu_seconds) : "-",
                      cgal ? fmt::format("{:.1f}", cgal->wall_seconds) : "-",
                      cgal ? fmt::format("{:.2f}", cost.wall_seconds / cgal->wall_seconds) : "-",
                      notes.empty() ? "-" : notes.substr(0, notes.size() - 2)});
  }

  const Settings& settings_;
  Table table_;
  std::optional<Cost> first_, before_;
  bool failed_ = false;
};

/// Seconds on two cores that a scan may take; 0: no bound is stated.
double most_wall_seconds(const std::string& name) {
  return name == "horse" ? 6 : name == "dragon" ? 60 : 0;
}

int run(const Settings& settings) {
  Rows rows(settings);
  rows.print_header();
  const TemporaryFolder folder;
  bool failed = false;
  for (const std::string& text : settings.sizes) {
    const auto size = app::parse_size(text);
    if (!size) {
      fmt::print(stderr, "remesh_scaling: {}\n", size.error().message);
      return 2;
    }
    const std::string file = (folder.path() / "scan.ply").string();
    const ChildRun made = run_child({"/proc/self/exe", "--source", settings.source, "--make", file,
                                     "--triangles", std::to_string(*size)},
                                    settings.timeout_seconds);
    if (!made.ok()) {
      fmt::print(stderr, "remesh_scaling: {}: {}\n", text, made.outcome());
      failed = true;
      continue;
    }
    rows.add(fs::path(settings.source).stem().string() + " " + text, file, true, 0);
  }
  for (const std::string& file : settings.as_they_are) {
    const std::string name = fs::path(file).stem().string();
    rows.add(name + ", as it is", file, false, most_wall_seconds(name));
  }
  fmt::print(
      "\nCGAL: edge collapse with Lindstrom and Turk's cost and placement down to {} vertices, one "
      "thread. Peak: of the whole process, the scan included.\n",
      kBaseVertices);
  return failed || rows.failed() ? 1 : 0;
}

int main_of(int argc, char** argv) {
  app::set_up_allocator();
  Settings settings;
  CLI::App app("Time and memory of remeshing against size", "remesh_scaling");
  app.add_option("--source", settings.source, "The scan whose sizes are made; default: horse");
  app.add_option("--sizes", settings.sizes, "Triangles, e.g. 10k,100k,1M")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->capture_default_str();
  app.add_option("MESH", settings.as_they_are,
                 "Scans measured as they are, behind the series; default: horse and dragon");
  app.add_flag("--without-cgal", settings.without_cgal, "Leave out CGAL's simplification");
  app.add_option("--timeout", settings.timeout_seconds, "Seconds for one process")
      ->capture_default_str();
  app.add_option("--levels", settings.remesh.levels, "0: as remesh chooses");
  app.add_option("--base-vertices", settings.remesh.base_vertices, "0: as remesh chooses");
  app.add_option("--make", settings.make, "Write the source with --triangles triangles here");
  app.add_option("--triangles", settings.triangles, "With --make");
  app.add_option("--remesh", settings.remesh_file, "Remesh this file and print what it took");
  app.add_option("--simplify", settings.simplify_file, "Simplify this file and print what it took");
  CLI11_PARSE(app, argc, argv);
  settings.remesh.predict = wavelet::predict_at_need;
  if (!settings.make.empty() || !settings.remesh_file.empty() || !settings.simplify_file.empty())
    return run_child_job(settings);
  if (settings.source.empty()) settings.source = corpus::mesh("horse.ply").string();
  if (settings.as_they_are.empty())
    settings.as_they_are = {corpus::mesh("horse.ply").lexically_normal().string(),
                            corpus::mesh("dragon.ply").lexically_normal().string()};
  print_head(argc, argv);
  return run(settings);
}

}  // namespace
}  // namespace nacre::bench

int main(int argc, char** argv) { return nacre::bench::main_of(argc, argv); }
