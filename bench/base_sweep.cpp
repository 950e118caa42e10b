// SPDX-License-Identifier: GPL-3.0-or-later
//
// How many base vertices and levels a file of a given size should have: every combination, coded
// and measured. The rule in app/rate_rule.cpp is fitted to this table.
#include <fmt/format.h>
#include <fmt/os.h>

#include <CLI/CLI.hpp>
#include <cmath>

#include "app/sizes.h"
#include "base/parallel.h"
#include "bench/remesh_cache.h"
#include "bench/support.h"
#include "codec/codec.h"
#include "io/io.h"

namespace nacre::bench {
namespace {

struct Settings {
  std::vector<std::string> meshes, bytes = {"550", "1k", "2k", "4k", "8k", "16k", "32k", "64k"};
  std::vector<int> base_vertices = {30, 60, 100, 200, 400};
  CacheOptions cache;
  int finest = 1;  // levels beyond 2.5 triangles for each one of the scan
  int coarsest = 1;
  std::size_t samples = 200'000;
};

/// The mesh without its finest levels: those of a coarser mesh are a prefix.
SemiRegularMesh cut_to(const SemiRegularMesh& mesh, int levels) {
  const auto topology =
      Topology::build(mesh.base_triangles, mesh.base_vertex_count, mesh.level_count);
  SemiRegularMesh out = mesh;
  out.level_count = levels;
  out.positions.resize(topology->level(levels).vertex_count);
  return out;
}

struct Point {
  std::size_t target = 0;
  int levels = 0;
  std::size_t bytes = 0;
  double psnr = 0;
};

void code(const PreparedScan& scan, std::size_t samples, Point& out) {
  codec::EncodeOptions options;
  options.profile = codec::Profile::kBest;
  options.effort = codec::Effort::kFast;
  options.target_bytes = out.target;
  const auto encoded = codec::encode(cut_to(scan.mesh, out.levels), options);
  if (!encoded) return;
  const auto decoded = codec::decode(encoded->bytes);
  if (!decoded) return;
  const auto distance = distance_to_scan(scan, *decoded, samples);
  if (!distance) return;
  out.bytes = encoded->bytes.size();
  out.psnr = distance->psnr_db;
}

int default_levels(std::size_t scan_triangles, int base_vertices) {
  const double least = std::max(2.5 * static_cast<double>(scan_triangles), 160e3);
  return static_cast<int>(std::ceil(std::log2(least / (2.0 * base_vertices)) / 2));
}

void sweep(const std::string& file, int base_vertices, const Settings& settings,
           const Table& table) {
  const auto read = io::read_scan(file);
  CacheOptions cache = settings.cache;
  cache.base_vertices = base_vertices;
  const int usual = default_levels(read ? read->scan.triangles.size() : 0, base_vertices);
  cache.levels = usual + settings.finest;
  const auto scan = prepare_scan(file, cache);
  if (!scan) {
    fmt::print(stderr, "{}: {}\n", file, scan.error().message);
    return;
  }
  for (int levels = usual - settings.coarsest; levels <= cache.levels; ++levels) {
    const auto distance = distance_to_scan(*scan, cut_to(scan->mesh, levels), settings.samples);
    std::vector<Point> points;
    for (const std::string& text : settings.bytes) {
      const auto bytes = app::parse_size(text);
      if (bytes) points.push_back({*bytes, levels, 0, 0});
    }
    parallel_for_each_index(
        points.size(), [&](std::size_t i) { code(*scan, settings.samples, points[i]); }, 1);
    for (const Point& p : points) {
      table.print_row({scan->name, fmt::format("{}", scan->mesh.base_vertex_count),
                       fmt::format("{}", levels), fmt::format("{:+d}", levels - usual),
                       fmt::format("{:.2f}", distance ? distance->psnr_db : 0),
                       fmt::format("{}", p.target), fmt::format("{}", p.bytes),
                       fmt::format("{:.2f}", p.psnr)});
    }
    std::fflush(stdout);
  }
}

int run(int argc, const char* const* argv) {
  Settings settings;
  CLI::App app{"PSNR for numbers of base vertices, levels and bytes."};
  std::string folder;
  app.add_option("meshes", settings.meshes, "scans")->required();
  app.add_option("--bytes", settings.bytes, "sizes of whole files")->delimiter(',');
  app.add_option("--base-vertices", settings.base_vertices, "numbers to try")->delimiter(',');
  app.add_option("--samples", settings.samples, "of the measurement");
  app.add_option("--cache", folder, "folder for normal meshes");
  app.add_option("--finest", settings.finest, "levels beyond the usual");
  app.add_option("--coarsest", settings.coarsest, "levels below the usual");
  CLI11_PARSE(app, argc, argv);
  settings.cache.folder = folder;
  print_head(argc, argv);
  const Table table({{"mesh", true},
                     {"base vertices"},
                     {"levels"},
                     {"of the usual"},
                     {"remesh dB"},
                     {"target"},
                     {"bytes"},
                     {"PSNR"}});
  table.print_header();
  for (const std::string& file : settings.meshes)
    for (const int base_vertices : settings.base_vertices)
      sweep(file, base_vertices, settings, table);
  return 0;
}

}  // namespace
}  // namespace nacre::bench

int main(int argc, char** argv) { return nacre::bench::run(argc, argv); }
