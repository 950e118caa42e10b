// SPDX-License-Identifier: GPL-3.0-or-later
//
// PSNR of whole files of given sizes, measured on the decoded bytes against the raw scan.
#include <fmt/format.h>
#include <fmt/os.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <optional>

#include "app/files.h"
#include "app/report.h"
#include "app/sizes.h"
#include "base/parallel.h"
#include "bench/support.h"
#include "codec/codec.h"
#include "codec/comparators.h"
#include "io/io.h"
#include "wavelet/wavelet.h"

namespace nacre::bench {
namespace {

struct Settings {
  std::vector<std::string> meshes, bytes = {"2k", "4k", "8k", "16k", "32k"};
  std::vector<double> bits_per_input_vertex = {1, 2, 4, 8};
  std::string profile = "best", csv;
  std::size_t samples = 1'000'000;
  remesh::Options remesh;
};

struct Goal {
  std::string name;
  std::size_t bytes = 0;
};

/// A scan, its normal mesh, and what measuring against the scan needs.
struct Prepared {
  std::string name;
  Scan scan;
  std::size_t input_vertices = 0;
  metric::Surface surface;
  remesh::Remesh remesh;
  metric::Comparison remesh_distance;
};

struct Row {
  Goal goal;
  std::optional<Error> error;
  codec::EncodeReport coded;
  metric::Comparison distance;

  [[nodiscard]] double allocation_ratio() const {
    return coded.predicted_distortion / coded.measured_distortion;
  }
  [[nodiscard]] double normal_only_percent() const {
    double normal = 0, all = 0;
    for (const codec::BandReport& band : coded.bands) {
      normal += band.normal_only_fraction * static_cast<double>(band.vertices);
      all += static_cast<double>(band.vertices);
    }
    return 100 * normal / std::max(all, 1.0);
  }
};

Result<std::vector<Goal>> goals_of(const Settings& settings, std::size_t input_vertices) {
  std::vector<Goal> goals;
  for (const std::string& text : settings.bytes) {
    const auto bytes = app::parse_size(text);
    if (!bytes) return bytes.error();
    goals.push_back({text + "B", *bytes});
  }
  for (const double bits : settings.bits_per_input_vertex) {
    const double bytes = std::floor(bits * static_cast<double>(input_vertices) / 8);
    goals.push_back({fmt::format("{} b/iv", bits), static_cast<std::size_t>(bytes)});
  }
  std::stable_sort(goals.begin(), goals.end(),
                   [](const Goal& a, const Goal& b) { return a.bytes < b.bytes; });
  return goals;
}

Result<metric::Comparison> measure(const Prepared& prepared, const SemiRegularMesh& mesh,
                                   std::size_t samples) {
  const auto triangles = app::to_triangles(mesh);
  if (!triangles) return triangles.error();
  return metric::compare(prepared.scan, prepared.surface, *triangles, {.samples = samples});
}

Result<Prepared> prepare(const std::string& file, const Settings& settings) {
  auto read = io::read_scan(file);
  if (!read) return read.error();
  auto surface = metric::Surface::build(read->scan);
  if (!surface) return surface.error();
  auto remeshed = remesh::remesh(read->scan, settings.remesh);
  if (!remeshed) return remeshed.error();
  const std::size_t input_vertices = app::input_facts(file, *read).goal_vertices;
  Prepared prepared{std::filesystem::path(file).stem().string(),
                    std::move(read->scan),
                    input_vertices,
                    std::move(*surface),
                    std::move(*remeshed),
                    {}};
  const auto distance = measure(prepared, prepared.remesh.mesh, settings.samples);
  if (!distance) return distance.error();
  prepared.remesh_distance = *distance;
  return prepared;
}

Row run_goal(const Prepared& prepared, const Goal& goal, const Settings& settings) {
  Row row;
  row.goal = goal;
  codec::EncodeOptions options;
  options.target_bytes = goal.bytes;
  options.profile = codec::profile_of_name(settings.profile).value_or(codec::Profile::kBest);
  const auto encoded = codec::encode(prepared.remesh.mesh, options);
  if (!encoded) {
    row.error = encoded.error();
    return row;
  }
  row.coded = encoded->report;
  row.coded.bytes = encoded->bytes.size();
  const auto decoded = codec::decode(
      encoded->bytes, {.comparators = codec::decode_comparator_bands});
  const auto distance = decoded ? measure(prepared, *decoded, settings.samples)
                                : Result<metric::Comparison>(decoded.error());
  if (!distance) {
    row.error = distance.error();
    return row;
  }
  row.distance = *distance;
  return row;
}

double bits_per(std::size_t bytes, std::size_t vertices) {
  return 8.0 * static_cast<double>(bytes) / static_cast<double>(vertices);
}

void print_rows(const Table& table, const Prepared& prepared, const std::vector<Row>& rows) {
  const SemiRegularMesh& mesh = prepared.remesh.mesh;
  for (const Row& row : rows) {
    if (row.error) {
      table.print_row({prepared.name, row.goal.name, std::to_string(row.goal.bytes), "-", "", "",
                       "", row.error->message});
      continue;
    }
    const std::size_t bytes = row.coded.bytes;
    table.print_row(
        {prepared.name, row.goal.name, std::to_string(row.goal.bytes), std::to_string(bytes),
         fmt::format("{:.3f}", bits_per(bytes, prepared.input_vertices)),
         fmt::format("{:.3f}", bits_per(bytes, mesh.positions.size())),
         fmt::format("{:.2f}", row.distance.psnr_db),
         fmt::format("{:.2f}", psnr_of_maximum_db(row.distance)),
         fmt::format("{:.3f}", row.allocation_ratio()), fmt::format("{}", row.coded.bytes_base),
         fmt::format("{:.2f}", row.normal_only_percent())});
  }
}

void print_mesh_line(const Prepared& prepared) {
  const remesh::Remesh& r = prepared.remesh;
  double normal = 0, all = 0;
  for (const remesh::BandReport& band : r.bands) {
    normal += static_cast<double>(band.normal_only);
    all += static_cast<double>(band.vertices);
  }
  fmt::print(
      "{}: {} input vertices; base {} vertices, J = {}, {} semi-regular vertices; remeshing PSNR "
      "{:.2f} dB, of the maximum {:.2f} dB; {:.2f} % of the details normal-only\n\n",
      prepared.name, prepared.input_vertices, r.mesh.base_vertex_count, r.mesh.level_count,
      r.mesh.positions.size(), prepared.remesh_distance.psnr_db,
      psnr_of_maximum_db(prepared.remesh_distance), 100 * normal / std::max(all, 1.0));
}

void print_csv(fmt::ostream& csv, const Prepared& prepared, const Row& row,
               const Settings& settings) {
  if (row.error) return;
  const metric::Comparison& d = row.distance;
  const SemiRegularMesh& mesh = prepared.remesh.mesh;
  csv.print(
      "{},{},{},{},{:.6f},{:.6f},{:.4f},{:.4f},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.6g},"
      "{:.6g},{},{},{:.4f},{:.4f},{}\n",
      prepared.name, settings.profile, row.goal.bytes, row.coded.bytes,
      bits_per(row.coded.bytes, prepared.input_vertices),
      bits_per(row.coded.bytes, mesh.positions.size()), d.psnr_db, psnr_of_maximum_db(d),
      d.a_to_b.rms, d.b_to_a.rms, d.a_to_b.maximum, d.b_to_a.maximum, d.bbox_diagonal,
      row.coded.predicted_distortion, row.coded.measured_distortion, mesh.base_vertex_count,
      mesh.level_count, row.normal_only_percent(), prepared.remesh_distance.psnr_db,
      settings.samples);
}

constexpr const char* kCsvHead =
    "mesh,profile,target_bytes,bytes,bits_per_input_vertex,bits_per_semiregular_vertex,psnr_db,"
    "psnr_of_maximum_db,rms_a_to_b,rms_b_to_a,max_a_to_b,max_b_to_a,bbox_diagonal,"
    "predicted_distortion,measured_distortion,base_vertices,levels,normal_only_percent,"
    "remesh_psnr_db,samples\n";

/// What the codec promises (docs and DESIGN section 3), checked on these rows.
std::vector<std::string> broken_promises(const std::string& mesh, const std::vector<Row>& rows) {
  std::vector<std::string> out;
  const Row* before = nullptr;
  for (const Row& row : rows) {
    if (row.error) continue;
    const std::string where = fmt::format("{} at {}", mesh, row.goal.name);
    const std::size_t bytes = row.coded.bytes, target = row.goal.bytes;
    if (bytes > target) out.push_back(fmt::format("{}: {} bytes, over the target", where, bytes));
    if (target >= 2000 && bytes * 100 < target * 99)
      out.push_back(
          fmt::format("{}: {:.2f} % of the target unused", where,
                      100.0 * static_cast<double>(target - bytes) / static_cast<double>(target)));
    if (std::abs(row.allocation_ratio() - 1) > 0.05)
      out.push_back(
          fmt::format("{}: predicted / measured error {:.3f}", where, row.allocation_ratio()));
    if (before != nullptr && before->distance.psnr_db > row.distance.psnr_db)
      out.push_back(fmt::format("{}: PSNR {:.3f} dB, {:.3f} dB with fewer bytes", where,
                                row.distance.psnr_db, before->distance.psnr_db));
    before = &row;
  }
  return out;
}

int run(const Settings& settings) {
  std::optional<fmt::ostream> csv;
  if (!settings.csv.empty()) {
    csv.emplace(fmt::output_file(settings.csv));
    csv->print("{}", kCsvHead);
  }
  const Table table({{"mesh", true},
                     {"goal", true},
                     {"target bytes"},
                     {"bytes"},
                     {"bits / input vertex"},
                     {"bits / semi-regular vertex"},
                     {"PSNR dB"},
                     {"PSNR of max dB"},
                     {"predicted / measured"},
                     {"base bytes"},
                     {"normal-only % coded"}});
  std::vector<std::string> broken;
  int failures = 0;
  for (const std::string& file : settings.meshes) {
    const auto prepared = prepare(file, settings);
    if (!prepared) {
      fmt::print("{}: {}\n\n", file, prepared.error().message);
      ++failures;
      continue;
    }
    const auto goals = goals_of(settings, prepared->input_vertices);
    if (!goals) {
      fmt::print(stderr, "rate_table: {}\n", goals.error().message);
      return 2;
    }
    std::vector<Row> rows(goals->size());
    parallel_for_each_index(
        rows.size(), [&](std::size_t i) { rows[i] = run_goal(*prepared, (*goals)[i], settings); },
        1);
    print_mesh_line(*prepared);
    table.print_header();
    print_rows(table, *prepared, rows);
    fmt::print("\n");
    if (csv)
      for (const Row& row : rows) print_csv(*csv, *prepared, row, settings);
    for (std::string& line : broken_promises(prepared->name, rows)) broken.push_back(line);
  }
  fmt::print(
      "Outside the bounds (size within 1 % below the target from 2 kB up, prediction within "
      "5 %, PSNR rising with bytes): {}\n",
      broken.empty() ? "nothing" : "");
  for (const std::string& line : broken) fmt::print("- {}\n", line);
  return failures == 0 ? 0 : 1;
}

int main_of(int argc, char** argv) {
  Settings settings;
  CLI::App app("Measures PSNR against the raw scan at several file sizes", "rate_table");
  app.add_option("MESH", settings.meshes, "Scans")->required();
  app.add_option("--profile", settings.profile)
      ->check(CLI::IsMember({"best", "paper", "nmc", "eqmc"}))
      ->capture_default_str();
  auto* bytes = app.add_option("--bytes", settings.bytes, "Whole-file sizes, e.g. 2k,4k")
                    ->delimiter(',')
                    ->capture_default_str();
  auto* bits = app.add_option("--bits-per-vertex", settings.bits_per_input_vertex,
                              "Sizes in bits per input vertex")
                   ->delimiter(',')
                   ->capture_default_str();
  app.add_option("--samples", settings.samples, "Area samples each way")->capture_default_str();
  app.add_option("--levels", settings.remesh.levels, "0: as remesh chooses");
  app.add_option("--base-vertices", settings.remesh.base_vertices, "0: as remesh chooses");
  app.add_option("--csv", settings.csv, "Also write all figures here");
  CLI11_PARSE(app, argc, argv);
  // One kind of goal named means only that kind.
  if (bytes->count() > 0 && bits->count() == 0) settings.bits_per_input_vertex.clear();
  if (bits->count() > 0 && bytes->count() == 0) settings.bytes.clear();
  settings.remesh.predict = wavelet::predict_at_need;
  print_head(argc, argv);
  return run(settings);
}

}  // namespace
}  // namespace nacre::bench

int main(int argc, char** argv) { return nacre::bench::main_of(argc, argv); }
