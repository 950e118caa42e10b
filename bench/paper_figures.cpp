// SPDX-License-Identifier: GPL-3.0-or-later
//
// [LVQ] Figs 4 and 5 on this remesh: PSNR over bits per semi-regular vertex for Venus and Horse, of
// the paper's coder, those it compares itself with, and the best one: all on one normal mesh with
// as many vertices as the paper's, and the best one on the mesh that `nacre encode` makes for the
// size. And Fig. 3: a band's measured (R, D) points with the spline through them.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>

#include "alloc/alloc.h"
#include "bench/coded_point.h"
#include "bench/support.h"
#include "bench/svg_plot.h"
#include "tests/support/corpus.h"

namespace nacre::bench {
namespace {

using codec::Profile;

/// A scan, and the normal mesh that its coders share; 0: as remesh chooses.
struct Subject {
  std::string file;
  int base_vertices = 0, levels = 0;
};

/// With the numbers of vertices of [LVQ] Table 2: 163,842 and 112,642.
std::vector<Subject> subjects_of_the_paper() {
  return {{corpus::mesh("venus.off"), 162, 5}, {corpus::mesh("horse.ply"), 112, 5}};
}

/// The best profile as the command has it, with its choice of base mesh and levels.
constexpr const char* kCommand = "nacre encode";

struct Settings {
  std::vector<std::string> meshes;
  int base_vertices = 0, levels = 0;
  std::vector<double> bits = {0.25, 0.35, 0.5, 0.7, 1, 1.4, 2, 2.8, 4};
  std::vector<std::string> profiles = {"paper", "nmc", "eqmc", "best"};
  int band = -1;
  double band_bits = 1;  ///< per semi-regular vertex, of the coding whose samples are shown
  std::size_t samples = 1'000'000;
  CacheOptions cache;
  std::string svg, nacre = NACRE_COMMAND;
};

std::vector<Profile> profiles_of(const Settings& settings) {
  std::vector<Profile> out;
  for (const std::string& name : settings.profiles) out.push_back(*codec::profile_of_name(name));
  return out;
}

std::size_t bytes_at(const PreparedScan& scan, double bits) {
  return static_cast<std::size_t>(bits * static_cast<double>(scan.mesh.positions.size()) / 8);
}

/// A curve of the figure: its points by rate.
struct Curve {
  std::string name;
  std::vector<CodedPoint> points;
};

std::vector<Curve> curves_of(const PreparedScan& scan, const std::string& file,
                             const Settings& settings, const std::vector<std::size_t>& sizes) {
  const auto points = code_points(scan, profiles_of(settings), sizes, settings.samples);
  std::vector<Curve> curves;
  for (std::size_t k = 0; k < settings.profiles.size(); ++k) {
    const auto first = points.begin() + static_cast<std::ptrdiff_t>(k * sizes.size());
    curves.push_back(
        {settings.profiles[k], {first, first + static_cast<std::ptrdiff_t>(sizes.size())}});
  }
  curves.push_back({kCommand, command_points(scan, file, settings.nacre, sizes, settings.samples)});
  return curves;
}

void plot_rates(const PreparedScan& scan, const std::vector<Curve>& curves,
                const Settings& settings) {
  Plot plot{scan.name, "bits per semi-regular vertex (whole file)", "PSNR, dB", false, false, {}};
  for (const Curve& curve : curves) {
    Series series{curve.name, {}, true, true};
    for (const CodedPoint& p : curve.points)
      if (!p.error)
        series.points.emplace_back(
            8 * p.point.bytes / static_cast<double>(scan.mesh.positions.size()), p.point.psnr_db);
    plot.series.push_back(std::move(series));
  }
  write_text(std::filesystem::path(settings.svg) / ("figure-rates-" + scan.name + ".svg"),
             to_svg(plot));
}

/// Figs 4 and 5.
void print_rates(const PreparedScan& scan, const std::string& file, const Settings& settings) {
  std::vector<std::size_t> sizes;
  for (const double bits : settings.bits) sizes.push_back(bytes_at(scan, bits));
  const std::vector<Curve> curves = curves_of(scan, file, settings, sizes);
  std::vector<Table::Column> columns = {{"bits / semi-regular vertex"}, {"bytes"}};
  for (const Curve& curve : curves) columns.push_back({curve.name + " dB"});
  for (const Curve& curve : curves) columns.push_back({curve.name + ", max error, dB"});
  const Table table(columns);
  table.print_header();
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    std::vector<std::string> row = {fmt::format("{:.2f}", settings.bits[i]),
                                    std::to_string(sizes[i])};
    for (double RatePoint::*figure : {&RatePoint::psnr_db, &RatePoint::psnr_of_maximum_db})
      for (const Curve& curve : curves) {
        const CodedPoint& p = curve.points[i];
        row.push_back(p.error ? "-" : fmt::format("{:.2f}", p.point.*figure));
      }
    table.print_row(row);
  }
  fmt::print("\n");
  if (!settings.svg.empty()) plot_rates(scan, curves, settings);
}

/// Fig. 3.
Result<void> print_band(const PreparedScan& scan, const Settings& settings) {
  codec::EncodeOptions options;
  options.profile = Profile::kPaper;
  options.target_bytes = bytes_at(scan, settings.band_bits);
  const auto encoded = codec::encode(scan.mesh, options);
  if (!encoded) return encoded.error();
  const auto band = static_cast<std::size_t>(settings.band);
  if (band >= encoded->report.bands.size())
    return Error{ErrorCode::kBadInput,
                 fmt::format("bands are 0 to {}", encoded->report.bands.size() - 1)};
  const auto& samples = encoded->report.bands[band].samples;
  const auto curve = alloc::RateDistortionCurve::fit(samples);
  if (!curve) return curve.error();
  fmt::print("{}, band {}: samples of the real coder and the {} through them\n\n", scan.name, band,
             curve->is_spline() ? "smoothing spline" : "convex hull");
  const Table table({{"step"}, {"bits / vertex of the band"}, {"D"}, {"curve's D"}});
  table.print_header();
  Series measured{"measured", {}, false, true}, line{"spline", {}, true, false};
  for (const alloc::Sample& s : samples) {
    table.print_row({fmt::format("{:.4g}", s.step), fmt::format("{:.4f}", s.bits),
                     fmt::format("{:.4g}", s.distortion),
                     fmt::format("{:.4g}", curve->distortion(s.bits))});
    if (s.distortion > 0) measured.points.emplace_back(s.bits, s.distortion);
  }
  fmt::print("\n");
  for (int i = 0; i <= 400; ++i) {
    const double bits =
        curve->min_bits() + (curve->max_bits() - curve->min_bits()) * std::pow(i / 400.0, 2);
    if (curve->distortion(bits) > 0) line.points.emplace_back(bits, curve->distortion(bits));
  }
  if (!curve->is_spline()) line.name = "convex hull";
  if (settings.svg.empty()) return {};
  const Plot plot{fmt::format("{}, band {}", scan.name, band),
                  "R, bits per vertex of the band",
                  "D, mean squared error per vertex of the band",
                  false,
                  true,
                  {measured, line}};
  write_text(
      std::filesystem::path(settings.svg) / fmt::format("figure-band-{}-{}.svg", scan.name, band),
      to_svg(plot));
  return {};
}

int run(const Settings& settings) {
  int failures = 0;
  std::vector<Subject> subjects;
  for (const std::string& file : settings.meshes)
    subjects.push_back({file, settings.base_vertices, settings.levels});
  if (subjects.empty()) subjects = subjects_of_the_paper();
  for (const auto& [file, base_vertices, levels] : subjects) {
    const auto fail = [&, file = file](const Error& error) {
      fmt::print("{}: {}\n\n", file, error.message);
      ++failures;
    };
    CacheOptions mesh = settings.cache;
    mesh.base_vertices = base_vertices;
    mesh.levels = levels;
    const auto scan = prepare_scan(file, mesh);
    if (!scan) {
      fail(scan.error());
      continue;
    }
    const auto remeshed = distance_to_scan(*scan, scan->mesh, settings.samples);
    if (remeshed)
      fmt::print(
          "{}: {} input vertices; base {} vertices, J = {}, {} semi-regular vertices; remeshing "
          "PSNR {:.2f} dB\n\n",
          scan->name, scan->input_vertices, scan->mesh.base_vertex_count, scan->mesh.level_count,
          scan->mesh.positions.size(), remeshed->psnr_db);
    if (settings.band >= 0) {
      if (const auto done = print_band(*scan, settings); !done) fail(done.error());
    } else {
      print_rates(*scan, file, settings);
    }
    std::fflush(stdout);
  }
  return failures == 0 ? 0 : 1;
}

int main_of(int argc, char** argv) {
  Settings settings;
  CLI::App app("Figures 3, 4 and 5 of the paper, on this remesh", "paper_figures");
  app.add_option("MESH", settings.meshes,
                 "Scans; default: venus and horse of the corpus, with the paper's vertex counts");
  app.add_option("--base-vertices", settings.base_vertices,
                 "Of the mesh that the coders share; 0: as remesh chooses")
      ->needs("MESH");
  app.add_option("--levels", settings.levels, "Its levels; 0: as remesh chooses")->needs("MESH");
  app.add_option("--bits", settings.bits, "Whole-file rates, in bits per semi-regular vertex")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--profiles", settings.profiles)
      ->delimiter(',')
      ->check(CLI::IsMember({"best", "paper", "nmc", "eqmc"}))
      ->capture_default_str();
  app.add_option("--band", settings.band, "Figure 3 instead: the points and the spline of a band");
  app.add_option("--band-bits", settings.band_bits,
                 "Figure 3: rate of the coding, in bits per semi-regular vertex")
      ->capture_default_str();
  app.add_option("--samples", settings.samples, "Area samples each way")->capture_default_str();
  app.add_option("--cache", settings.cache.folder, "Keep remeshed scans in this folder");
  app.add_flag("--keep-remesh", settings.cache.keep_old_remesh,
               "Take kept meshes even if the remesher has changed");
  app.add_option("--nacre", settings.nacre, "The command")->capture_default_str();
  app.add_option("--svg", settings.svg, "Write the pictures into this folder");
  CLI11_PARSE(app, argc, argv);
  print_head(argc, argv);
  return run(settings);
}

}  // namespace
}  // namespace nacre::bench

int main(int argc, char** argv) { return nacre::bench::main_of(argc, argv); }
