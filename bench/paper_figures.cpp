// SPDX-License-Identifier: GPL-3.0-or-later
//
// [LVQ] Figs 4 and 5 on this remesh: PSNR over bits per semi-regular vertex for Venus and Horse, of
// the paper's coder, those it compares itself with, and the best one. And Fig. 3: a band's measured
// (R, D) points with the spline through them.
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

struct Settings {
  std::vector<std::string> meshes;
  std::vector<double> bits = {0.25, 0.35, 0.5, 0.7, 1, 1.4, 2, 2.8, 4};
  std::vector<std::string> profiles = {"paper", "nmc", "eqmc", "best"};
  int band = -1;
  double band_bits = 1;  ///< per semi-regular vertex, of the coding whose samples are shown
  std::size_t samples = 1'000'000;
  CacheOptions cache;
  std::string svg;
};

std::vector<Profile> profiles_of(const Settings& settings) {
  std::vector<Profile> out;
  for (const std::string& name : settings.profiles) out.push_back(*codec::profile_of_name(name));
  return out;
}

std::size_t bytes_at(const PreparedScan& scan, double bits) {
  return static_cast<std::size_t>(bits * static_cast<double>(scan.mesh.positions.size()) / 8);
}

/// Figs 4 and 5.
void print_rates(const PreparedScan& scan, const Settings& settings) {
  const auto profiles = profiles_of(settings);
  std::vector<std::size_t> sizes;
  for (const double bits : settings.bits) sizes.push_back(bytes_at(scan, bits));
  const auto points = code_points(scan, profiles, sizes, settings.samples);
  std::vector<Table::Column> columns = {{"bits / semi-regular vertex"}, {"bytes"}};
  for (const std::string& name : settings.profiles) columns.push_back({name + " dB"});
  for (const std::string& name : settings.profiles) columns.push_back({name + ", max error, dB"});
  const Table table(columns);
  table.print_header();
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    std::vector<std::string> row = {fmt::format("{:.2f}", settings.bits[i]),
                                    std::to_string(sizes[i])};
    const auto add = [&](double RatePoint::*figure) {
      for (std::size_t k = 0; k < profiles.size(); ++k) {
        const CodedPoint& p = points[k * sizes.size() + i];
        row.push_back(p.error ? "-" : fmt::format("{:.2f}", p.point.*figure));
      }
    };
    add(&RatePoint::psnr_db);
    add(&RatePoint::psnr_of_maximum_db);
    table.print_row(row);
  }
  fmt::print("\n");
  if (settings.svg.empty()) return;
  Plot plot{scan.name, "bits per semi-regular vertex (whole file)", "PSNR, dB", false, false, {}};
  for (const Profile profile : profiles) {
    Series series{std::string(codec::profile_name(profile)), {}, true, true};
    for (const RatePoint& p : curve_of(points, profile))
      series.points.emplace_back(8 * p.bytes / static_cast<double>(scan.mesh.positions.size()),
                                 p.psnr_db);
    plot.series.push_back(std::move(series));
  }
  write_text(std::filesystem::path(settings.svg) / ("figure-rates-" + scan.name + ".svg"),
             to_svg(plot));
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
  for (const std::string& file : settings.meshes) {
    const auto fail = [&](const Error& error) {
      fmt::print("{}: {}\n\n", file, error.message);
      ++failures;
    };
    const auto scan = prepare_scan(file, settings.cache);
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
      print_rates(*scan, settings);
    }
    std::fflush(stdout);
  }
  return failures == 0 ? 0 : 1;
}

int main_of(int argc, char** argv) {
  Settings settings;
  CLI::App app("Figures 3, 4 and 5 of the paper, on this remesh", "paper_figures");
  app.add_option("MESH", settings.meshes, "Scans; default: venus and horse of the corpus");
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
  app.add_option("--svg", settings.svg, "Write the pictures into this folder");
  CLI11_PARSE(app, argc, argv);
  if (settings.meshes.empty())
    settings.meshes = {corpus::mesh("venus.off"), corpus::mesh("horse.ply")};
  print_head(argc, argv);
  return run(settings);
}

}  // namespace
}  // namespace nacre::bench

int main(int argc, char** argv) { return nacre::bench::main_of(argc, argv); }
