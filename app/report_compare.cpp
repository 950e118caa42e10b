// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/report_compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "app/report.h"
#include "app/sizes.h"

namespace nacre::app {
namespace {

/// Rows of the printed histogram: half a decade each.
constexpr int kEdgesPerRow = 5;
constexpr int kBarWidth = 24;

Json quantiles_json(const metric::OneSided& d, double diagonal) {
  return {{"p50", d.quantile(0.5, diagonal)},
          {"p90", d.quantile(0.9, diagonal)},
          {"p99", d.quantile(0.99, diagonal)},
          {"p999", d.quantile(0.999, diagonal)}};
}

Json histogram_json(const metric::Comparison& c) {
  Json edges = Json::array();
  for (int k = 0; k < metric::kHistogramEdges; ++k)
    edges.push_back(c.bbox_diagonal * metric::histogram_edge(k));
  return {
      {"edges", std::move(edges)}, {"a_to_b", c.a_to_b.histogram}, {"b_to_a", c.b_to_a.histogram}};
}

Json certified_side_json(const metric::CertifiedOneSided& side, const Vec3& origin) {
  return {{"lower", side.lower},
          {"upper", side.upper},
          {"lower_at", point_json(side.lower_at + origin)},
          {"within_tolerance", side.within_tolerance}};
}

Json certified_json(const metric::Certified& c) {
  return {{"lower", c.lower()},
          {"upper", c.upper()},
          {"upper_percent", percent_of(c.bbox_diagonal, c.upper())},
          {"within_tolerance", c.within_tolerance()},
          {"a_to_b", certified_side_json(c.a_to_b, c.origin)},
          {"b_to_a", certified_side_json(c.b_to_a, c.origin)}};
}

std::string place_text(const Vec3& p) {
  return fmt::format("{:.9g} {:.9g} {:.9g}", p[0], p[1], p[2]);
}

std::string one_sided_text(const char* name, const char* surface, const metric::OneSided& d,
                           const metric::Comparison& c) {
  return fmt::format(
      "{}  rms {:.6g} ({:.4f} %)  mean {:.6g}  max {:.6g} ({:.4f} %) on {} at {}  {} samples", name,
      d.rms, percent_of(c.bbox_diagonal, d.rms), d.mean, d.maximum,
      percent_of(c.bbox_diagonal, d.maximum), surface, place_text(d.maximum_at + c.origin),
      format_count(d.sample_count));
}

/// Samples of places [first, last) of a histogram, as a share of all.
double share_of(const metric::OneSided& d, int first, int last) {
  if (d.histogram.empty() || d.sample_count == 0) return 0;
  std::uint64_t count = 0;
  for (int k = first; k < last; ++k) count += d.histogram[static_cast<std::size_t>(k)];
  return static_cast<double>(count) / static_cast<double>(d.sample_count);
}

std::string bar(double share) {
  // What is there at all shows.
  const int length = share > 0 ? std::max(1, static_cast<int>(std::lround(share * kBarWidth))) : 0;
  return std::string(static_cast<std::size_t>(length), '#');
}

std::string share_text(double share) {
  if (share <= 0) return "-";
  return share < 0.0001 ? "< 0.01 %" : fmt::format("{:.2f} %", 100 * share);
}

}  // namespace

double percent_of(double diagonal, double distance) {
  return diagonal > 0 ? 100 * distance / diagonal : 0;
}

double max_error(const metric::Comparison& comparison) {
  return std::max(comparison.a_to_b.maximum, comparison.b_to_a.maximum);
}

Json comparison_json(const metric::Comparison& c,
                     const std::optional<metric::Certified>& certified) {
  const bool on_a = c.a_to_b.maximum >= c.b_to_a.maximum;
  const metric::OneSided& farthest = on_a ? c.a_to_b : c.b_to_a;
  Json json = {{"psnr_db", c.psnr_db},
               {"rms_a_to_b", c.a_to_b.rms},
               {"rms_b_to_a", c.b_to_a.rms},
               {"mean_a_to_b", c.a_to_b.mean},
               {"mean_b_to_a", c.b_to_a.mean},
               {"max_a_to_b", c.a_to_b.maximum},
               {"max_b_to_a", c.b_to_a.maximum},
               {"max_a_to_b_at", point_json(c.a_to_b.maximum_at + c.origin)},
               {"max_b_to_a_at", point_json(c.b_to_a.maximum_at + c.origin)},
               {"max",
                {{"value", farthest.maximum},
                 {"percent", percent_of(c.bbox_diagonal, farthest.maximum)},
                 {"on", on_a ? "A" : "B"},
                 {"at", point_json(farthest.maximum_at + c.origin)}}},
               {"bbox_diagonal", c.bbox_diagonal},
               {"samples", {{"a_to_b", c.a_to_b.sample_count}, {"b_to_a", c.b_to_a.sample_count}}},
               {"quantiles",
                {{"a_to_b", quantiles_json(c.a_to_b, c.bbox_diagonal)},
                 {"b_to_a", quantiles_json(c.b_to_a, c.bbox_diagonal)}}},
               {"histogram", histogram_json(c)}};
  json["certified"] = certified ? certified_json(*certified) : Json(nullptr);
  if (!std::isfinite(c.psnr_db)) json["psnr_db"] = nullptr;
  return json;
}

std::string to_json(const metric::Comparison& comparison,
                    const std::optional<metric::Certified>& certified) {
  return dump_json(comparison_json(comparison, certified));
}

std::string describe(const metric::Comparison& c) {
  return fmt::format("PSNR {:.3f} dB  bbox diagonal {:.6g}\n{}\n{}", c.psnr_db, c.bbox_diagonal,
                     one_sided_text("A -> B", "A", c.a_to_b, c),
                     one_sided_text("B -> A", "B", c.b_to_a, c));
}

std::string describe(const metric::Certified& c) {
  std::string text;
  for (const auto& [name, side] :
       {std::pair("A -> B", &c.a_to_b), std::pair("B -> A", &c.b_to_a)}) {
    text += fmt::format("{}  max certified {:.6g} .. {:.6g} ({:.4f} %){}\n", name, side->lower,
                        side->upper, percent_of(c.bbox_diagonal, side->upper),
                        side->within_tolerance ? "" : "  (stopped early: bounds are loose)");
  }
  return text + fmt::format("two-sided maximum: at most {:.6g} ({:.4f} %)", c.upper(),
                            percent_of(c.bbox_diagonal, c.upper()));
}

std::string describe_histogram(const metric::Comparison& c) {
  std::string text =
      fmt::format("{:<23} {:>9} {:<{}} {:>9}", "distance below", "of A", "", kBarWidth, "of B");
  bool begun = false;
  for (int first = 0; first <= metric::kHistogramEdges; first += kEdgesPerRow) {
    const int last = std::min(first + kEdgesPerRow, metric::kHistogramEdges + 1);
    const double of_a = share_of(c.a_to_b, first, last), of_b = share_of(c.b_to_a, first, last);
    begun = begun || of_a > 0 || of_b > 0;
    const bool ended = share_of(c.a_to_b, first, metric::kHistogramEdges + 1) <= 0 &&
                       share_of(c.b_to_a, first, metric::kHistogramEdges + 1) <= 0;
    if (!begun || ended) continue;
    const bool is_open = last > metric::kHistogramEdges;
    const double edge = is_open ? 0 : metric::histogram_edge(last - 1);
    const std::string below =
        is_open ? "(beyond the diagonal)"
                : fmt::format("{:.4g} ({:.3g} %)", edge * c.bbox_diagonal, 100 * edge);
    std::string line = fmt::format("{:<23} {:>9} {:<{}} {:>9} {}", below, share_text(of_a),
                                   bar(of_a), kBarWidth, share_text(of_b), bar(of_b));
    line.erase(line.find_last_not_of(' ') + 1);
    text += "\n" + line;
  }
  return text;
}

}  // namespace nacre::app
