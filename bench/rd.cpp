// SPDX-License-Identifier: GPL-3.0-or-later
//
// Rate-distortion curves of nacre's profiles against what a user has without it: simplify, then
// Draco.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <map>

#include "app/sizes.h"
#include "bench/coded_point.h"
#include "bench/peers.h"
#include "bench/support.h"
#include "bench/svg_plot.h"

namespace nacre::bench {
namespace {

/// The sizes over which curves are compared.
constexpr double kFromBytes = 2000, kToBytes = 32000;
constexpr const char* kPeer = "simplify + Draco";
/// The chords of that curve, which no file reaches; for a fair verdict, the harder opponent.
constexpr const char* kPeerHull = "its upper hull";

struct Settings {
  std::vector<std::string> meshes;
  std::vector<std::string> profiles = {"best", "paper", "nmc", "eqmc"};
  std::vector<std::string> bytes = {"1k",    "1.4k", "2k",    "2.8k", "4k",  "5.7k", "8k",
                                    "11.3k", "16k",  "22.6k", "32k",  "45k", "64k"};
  std::size_t samples = 1'000'000;
  CacheOptions cache;
  std::string csv, svg, nacre = NACRE_COMMAND;
  bool has_peers = true;
};

struct MeshResult {
  std::string name;
  bool is_closed = true;
  std::vector<std::size_t> sizes;
  std::map<std::string, std::vector<RatePoint>> curves;  ///< by profile, or kPeer, kPeerHull
  std::vector<CodedPoint> coded;
  std::vector<PeerPoint> peer;
};

bool is_closed(const SemiRegularMesh& mesh) {
  const auto topology = Topology::build(mesh.base_triangles, mesh.base_vertex_count, 1);
  if (!topology) return false;
  const auto& edges = topology->level(0).edges;
  return std::none_of(edges.begin(), edges.end(), [](const Edge& e) { return e.is_boundary(); });
}

Result<MeshResult> run_mesh(const std::string& file, const Settings& settings,
                            const std::vector<std::size_t>& sizes) {
  auto scan = prepare_scan(file, settings.cache);
  if (!scan) return scan.error();
  MeshResult result;
  result.name = scan->name;
  result.is_closed = is_closed(scan->mesh);
  result.sizes = sizes;
  // Profile best is what the command makes of the scan. The others get the semi-regular mesh that
  // it would take for the size.
  std::vector<SemiRegularMesh> meshes;
  const bool has_others = settings.profiles != std::vector<std::string>{"best"};
  for (std::size_t i = 0; i < sizes.size() && has_others; ++i) {
    auto mesh = mesh_for_size(*scan, settings.cache, sizes[i]);
    if (!mesh) return mesh.error();
    meshes.push_back(std::move(*mesh));
  }
  fmt::print("\n### {}\n\n{} input vertices, {}\n\n", scan->name, scan->input_vertices,
             result.is_closed ? "closed" : "open");
  for (const std::string& name : settings.profiles) {
    const codec::Profile profile = *codec::profile_of_name(name);
    const auto points = profile == codec::Profile::kBest
                            ? command_points(*scan, file, settings.nacre, sizes, settings.samples)
                            : code_points(*scan, {profile}, sizes, settings.samples, meshes);
    result.curves[name] = curve_of(points, profile);
    result.coded.insert(result.coded.end(), points.begin(), points.end());
  }
  if (settings.has_peers) {
    PeerOptions options;
    options.samples = settings.samples;
    options.folder = settings.cache.folder;
    auto peer = simplify_and_draco(*scan, options);
    if (!peer) {
      fmt::print("{}: {}\n", kPeer, peer.error().message);
    } else {
      result.peer = std::move(*peer);
      std::vector<RatePoint> points;
      for (const PeerPoint& p : result.peer) points.push_back(p.point);
      result.curves[kPeer] = rising(points);
      result.curves[kPeerHull] = filled(upper_hull(std::move(points)));
    }
  }
  return result;
}

std::string cell(const CodedPoint& p) {
  if (p.error) return "-";
  return fmt::format("{:.2f}", p.point.psnr_db);
}

void print_curves(const MeshResult& result, const Settings& settings) {
  std::vector<Table::Column> columns = {{"target bytes"}};
  for (const std::string& profile : settings.profiles) columns.push_back({profile + " dB"});
  if (settings.has_peers)
    for (const char* name : {kPeer, kPeerHull}) columns.push_back({std::string(name) + " dB"});
  columns.push_back({settings.profiles[0] + " bytes"});
  columns.push_back({settings.profiles[0] + ", max error, dB"});
  const Table table(columns);
  table.print_header();
  const std::size_t count = result.sizes.size();
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<std::string> row = {std::to_string(result.sizes[i])};
    for (std::size_t k = 0; k < settings.profiles.size(); ++k)
      row.push_back(cell(result.coded[k * count + i]));
    for (const char* name : {kPeer, kPeerHull}) {
      if (!settings.has_peers) break;
      const auto peer = result.curves.find(name);
      const auto db = peer == result.curves.end()
                          ? std::nullopt
                          : psnr_at(peer->second, static_cast<double>(result.sizes[i]));
      row.push_back(db ? fmt::format("{:.2f}", *db) : "-");
    }
    const CodedPoint& first = result.coded[i];
    row.push_back(first.error ? first.error->message : fmt::format("{:.0f}", first.point.bytes));
    if (!first.error) row.push_back(fmt::format("{:.2f}", first.point.psnr_of_maximum_db));
    table.print_row(row);
  }
  std::fflush(stdout);
}

/// Sizes from 2 to 32 kB where the first profile has fewer dB than another curve.
std::vector<std::string> defeats(const MeshResult& result, const Settings& settings) {
  std::vector<std::string> out;
  for (std::size_t i = 0; i < result.sizes.size(); ++i) {
    const CodedPoint& first = result.coded[i];
    const auto size = static_cast<double>(result.sizes[i]);
    if (size < kFromBytes || size > kToBytes) continue;
    for (const char* other : {kPeerHull, "paper"}) {
      const auto curve = result.curves.find(other);
      if (curve == result.curves.end() || other == settings.profiles[0]) continue;
      auto db = psnr_at(curve->second, size);
      // The paper's own point of this target; the peers' hull at the size.
      if (curve->first != kPeerHull) {
        const auto p =
            std::find_if(result.coded.begin(), result.coded.end(), [&](const CodedPoint& c) {
              return codec::profile_name(c.profile) == other && c.target_bytes == result.sizes[i];
            });
        db = p->error ? std::nullopt : std::optional(p->point.psnr_db);
      }
      if (!db || (!first.error && first.point.psnr_db >= *db)) continue;
      out.push_back(fmt::format("{} at {} bytes: {} dB, {} has {:.2f}", result.name,
                                result.sizes[i], cell(first), other, *db));
    }
  }
  return out;
}

std::string percent(const std::optional<BdRate>& rate) {
  return rate ? fmt::format("{:+.1f} %", rate->percent) : "-";
}

void print_bd_rates(const std::vector<MeshResult>& results, const Settings& settings) {
  std::vector<std::string> others;
  for (std::size_t k = 1; k < settings.profiles.size(); ++k) others.push_back(settings.profiles[k]);
  if (settings.has_peers) others.insert(others.end(), {kPeer, kPeerHull});
  fmt::print(
      "\n### BD-rate of {}\n\nBytes more (+) or fewer (-) than each reference at equal PSNR: mean "
      "of the difference in log(bytes), by pchip, over the PSNR that the reference has from {:.0f} "
      "to {:.0f} bytes, as far as both curves were measured; in brackets that range, as sizes of "
      "the reference.\n\n",
      settings.profiles[0], kFromBytes, kToBytes);
  std::vector<Table::Column> columns = {{"mesh", true}, {"", true}};
  for (const std::string& other : others) columns.push_back({"against " + other});
  const Table table(columns);
  table.print_header();
  std::map<std::pair<bool, std::string>, std::vector<double>> all;
  for (const MeshResult& result : results) {
    std::vector<std::string> row = {result.name, result.is_closed ? "closed" : "open"};
    for (const std::string& other : others) {
      const auto reference = result.curves.find(other);
      if (reference == result.curves.end()) {
        row.push_back("-");
        continue;
      }
      const auto rate =
          bd_rate(reference->second, result.curves.at(settings.profiles[0]), kFromBytes, kToBytes);
      if (rate) all[{result.is_closed, other}].push_back(rate->percent);
      row.push_back(
          percent(rate) +
          (rate ? fmt::format(" [{:.1f}k-{:.1f}k]", rate->bytes_from / 1000, rate->bytes_to / 1000)
                : ""));
    }
    table.print_row(row);
  }
  for (const bool closed : {true, false}) {
    std::vector<std::string> row = {"mean", closed ? "closed" : "open"};
    for (const std::string& other : others) {
      const std::vector<double>& rates = all[{closed, other}];
      double sum = 0;
      for (const double r : rates) sum += r;
      row.push_back(rates.empty()
                        ? "-"
                        : fmt::format("{:+.1f} % ({})", sum / static_cast<double>(rates.size()),
                                      rates.size()));
    }
    table.print_row(row);
  }
}

void append_csv(std::string& csv, const MeshResult& result, const Settings& settings) {
  const auto line = [&](std::string_view series, const RatePoint& p, const std::string& how) {
    csv +=
        fmt::format("{},{},{},{:.0f},{:.4f},{:.4f},{:.9g},{:.9g},{:.9g},{:.9g},{}\n", result.name,
                    series, how, p.bytes, p.psnr_db, p.psnr_of_maximum_db, p.rms_a_to_b,
                    p.rms_b_to_a, p.maximum_a_to_b, p.maximum_b_to_a, settings.samples);
  };
  for (const CodedPoint& p : result.coded)
    if (!p.error)
      line(codec::profile_name(p.profile), p.point, fmt::format("target={}", p.target_bytes));
  for (const PeerPoint& p : result.peer)
    line(p.is_simplified ? "simplify+draco" : "draco", p.point,
         fmt::format("triangles={};qp={}", p.triangles, p.position_bits));
}

Plot plot_of(const MeshResult& result, const Settings& settings) {
  Plot plot{result.name, "whole file, bytes", "PSNR, dB", true, false, {}};
  std::vector<std::string> names = settings.profiles;
  names.emplace_back(kPeer);
  for (const std::string& name : names) {
    const auto curve = result.curves.find(name);
    if (curve == result.curves.end()) continue;
    Series series{name, {}, true, name != kPeer};
    for (const RatePoint& p : curve->second) series.points.emplace_back(p.bytes, p.psnr_db);
    plot.series.push_back(std::move(series));
  }
  return plot;
}

int run(Settings settings) {
  std::vector<std::size_t> sizes;
  for (const std::string& text : settings.bytes) {
    const auto bytes = app::parse_size(text);
    if (!bytes) {
      fmt::print(stderr, "rd: {}\n", bytes.error().message);
      return 2;
    }
    sizes.push_back(*bytes);
  }
  std::sort(sizes.begin(), sizes.end());
  if (settings.has_peers && !has_draco()) {
    fmt::print(stderr,
               "rd: draco_encoder and draco_decoder are not on the PATH (Debian: apt install "
               "draco); going on without {}\n",
               kPeer);
    settings.has_peers = false;
  }
  std::vector<MeshResult> results;
  std::vector<std::string> lost;
  std::string csv =
      "mesh,series,setting,bytes,psnr_db,psnr_of_maximum_db,rms_a_to_b,rms_b_to_a,max_a_to_b,"
      "max_b_to_a,samples\n";
  int failures = 0;
  for (const std::string& file : settings.meshes) {
    auto result = run_mesh(file, settings, sizes);
    if (!result) {
      fmt::print("\n{}: {}\n", file, result.error().message);
      ++failures;
      continue;
    }
    print_curves(*result, settings);
    append_csv(csv, *result, settings);
    if (!settings.csv.empty()) write_text(settings.csv, csv);
    if (!settings.svg.empty())
      write_text(std::filesystem::path(settings.svg) / ("rd-" + result->name + ".svg"),
                 to_svg(plot_of(*result, settings)));
    for (std::string& line : defeats(*result, settings)) lost.push_back(line);
    results.push_back(std::move(*result));
  }
  print_bd_rates(results, settings);
  fmt::print("\nWhere {} is worse than {} ({}) or paper, 2 to 32 kB: {}\n", settings.profiles[0],
             kPeer, kPeerHull, lost.empty() ? "nowhere" : "");
  for (const std::string& line : lost) fmt::print("- {}\n", line);
  return failures == 0 ? 0 : 1;
}

int main_of(int argc, char** argv) {
  Settings settings;
  CLI::App app("Rate-distortion curves of every profile and of simplification with Draco", "rd");
  app.add_option("MESH", settings.meshes, "Scans")->required();
  app.add_option("--profiles", settings.profiles, "The first one is compared with the others")
      ->delimiter(',')
      ->check(CLI::IsMember({"best", "paper", "nmc", "eqmc"}))
      ->capture_default_str();
  app.add_option("--bytes", settings.bytes, "Whole-file sizes")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--samples", settings.samples, "Area samples each way")->capture_default_str();
  app.add_option("--cache", settings.cache.folder,
                 "Keep remeshed scans and the peers' results in this folder");
  app.add_flag("--keep-remesh", settings.cache.keep_old_remesh,
               "Take kept meshes even if the remesher has changed");
  app.add_option("--base-vertices", settings.cache.base_vertices, "0: as remesh chooses");
  app.add_option("--levels", settings.cache.levels, "0: as remesh chooses");
  app.add_option("--nacre", settings.nacre, "The command")->capture_default_str();
  app.add_option("--csv", settings.csv, "Write all points here");
  app.add_option("--svg", settings.svg, "Write a picture per mesh into this folder");
  app.add_flag("!--no-peers", settings.has_peers, "Without simplification and Draco");
  CLI11_PARSE(app, argc, argv);
  print_head(argc, argv);
  return run(std::move(settings));
}

}  // namespace
}  // namespace nacre::bench

int main(int argc, char** argv) { return nacre::bench::main_of(argc, argv); }
