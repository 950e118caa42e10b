// SPDX-License-Identifier: GPL-3.0-or-later
//
// One page without scripts and without anything from elsewhere: the style sheet stands in it,
// pictures are data: URIs, plots are SVG. So it opens from a mail and prints.
#include "app/report_html.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "alloc/alloc.h"
#include "app/report_compare.h"
#include "app/report_svg.h"
#include "app/sizes.h"

namespace nacre::app {
namespace {

constexpr int kCurvePoints = 60;  // of a drawn spline

constexpr const char* kStyle = R"(
:root{color-scheme:light dark;--ink:#1d2430;--soft:#5b6675;--paper:#fff;--line:#d5dbe3;--card:#f5f7fa;
--c1:#1f6fb4;--c2:#c4551b;--c3:#2d8a4e;--c4:#8250a8;--chosen:#c0203c}
@media(prefers-color-scheme:dark){:root{--ink:#e4e8ee;--soft:#9aa6b5;--paper:#14181f;--line:#333c48;--card:#1c222b;
--c1:#6db3ee;--c2:#f0995f;--c3:#71cf93;--c4:#c39be6;--chosen:#ff7a90}}
*{box-sizing:border-box}
body{margin:0 auto;max-width:76rem;padding:1.5rem;font:15px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--paper)}
h1{font-size:1.5rem;margin:0}h2{font-size:1.1rem;margin:2rem 0 .6rem}h3{font-size:.95rem;margin:0 0 .3rem;font-weight:600}
p{margin:.3rem 0}.soft{color:var(--soft)}
.facts{display:flex;flex-wrap:wrap;gap:.8rem;margin:1rem 0;padding:0;list-style:none}
.facts li{background:var(--card);border:1px solid var(--line);border-radius:.4rem;padding:.5rem .9rem}
.facts b{display:block;font-size:1.15rem}
.pictures,.plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(15rem,1fr));gap:.8rem}
.plots{grid-template-columns:repeat(auto-fit,minmax(22rem,1fr))}
figure{margin:0;break-inside:avoid}figcaption{color:var(--soft);font-size:.9rem}
img{width:100%;height:auto;display:block;border:1px solid var(--line);border-radius:.3rem}
svg{width:100%;max-width:46rem;height:auto;display:block}svg text{fill:var(--soft);font:12px system-ui,sans-serif}
svg .grid{stroke:var(--line);stroke-width:1}svg .axis{stroke:var(--soft);fill:none}
svg .curve{fill:none;stroke:currentColor;stroke-width:2}svg circle{fill:currentColor}
.c1{color:var(--c1)}.c2{color:var(--c2)}.c3{color:var(--c3)}.c4{color:var(--c4)}.chosen{color:var(--chosen)}
table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums;break-inside:avoid}
th,td{text-align:right;padding:.2rem .6rem;border-bottom:1px solid var(--line)}
th:first-child,td:first-child{text-align:left}th{font-weight:600;color:var(--soft)}
.bar{width:30%;min-width:6rem}.bar i{display:block;height:.7rem;background:var(--c1);border-radius:.15rem;print-color-adjust:exact;-webkit-print-color-adjust:exact}
@media print{:root{--ink:#000;--soft:#444;--paper:#fff;--line:#bbb;--card:#fff;--c1:#1f6fb4;--c2:#c4551b;--c3:#2d8a4e;--c4:#8250a8;--chosen:#c0203c}
body{padding:0;font-size:11px}h2{break-after:avoid}}
)";

std::string section(const char* title, const std::string& body) {
  return body.empty() ? "" : fmt::format("<section><h2>{}</h2>\n{}</section>\n", title, body);
}

std::string fact(const std::string& label, const std::string& value) {
  return fmt::format("<li>{}<b>{}</b></li>", escaped(label), escaped(value));
}

std::string head(const EncodeRun& run) {
  const std::string name = escaped(run.input.file.filename().string());
  const double diagonal = run.distance.bbox_diagonal, error = max_error(run.distance);
  const double bits = 8.0 * static_cast<double>(run.coded.bytes);
  std::string facts =
      fact("file", fmt::format("{} ({} bytes)", format_bytes(run.coded.bytes),
                               format_count(run.coded.bytes))) +
      fact("scan", fmt::format("{}, {} faces", format_bytes(run.input.read.file_bytes),
                               format_count(run.input.faces)));
  if (run.input.goal_vertices > 0) {
    facts += fact("bits per input vertex",
                  fmt::format("{:.3f}", bits / static_cast<double>(run.input.goal_vertices)));
  }
  facts += fact("PSNR", std::isfinite(run.distance.psnr_db)
                            ? fmt::format("{:.2f} dB", run.distance.psnr_db)
                            : std::string("equal surfaces"));
  facts += fact("largest distance found",
                fmt::format("{:.4g} ({:.3g} %)", error, percent_of(diagonal, error)));
  if (run.certified) {
    const double bound = run.certified->upper();
    facts += fact("certified: at most",
                  fmt::format("{:.4g} ({:.3g} %)", bound, percent_of(diagonal, bound)));
  }
  return fmt::format(
      "<h1>{}</h1>\n<p class=\"soft\">coded by nacre {}, profile {}; distances are "
      "between the scan as read and the decoded file, both ways, in model units and "
      "in per cent of the bounding box's diagonal</p>\n<ul class=\"facts\">{}</ul>\n",
      name, NACRE_VERSION, codec::profile_name(run.command.profile), facts);
}

std::string pictures(const HtmlExtras& extras) {
  std::string out;
  for (const HtmlExtras::Picture& picture : extras.pictures) {
    out += fmt::format(
        "<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\">"
        "<figcaption>{0}</figcaption></figure>\n",
        escaped(picture.caption), base64(picture.png));
  }
  return out.empty() ? out : "<div class=\"pictures\">" + out + "</div>\n";
}

std::string rate_plot(const EncodeRun& run, const HtmlExtras& extras) {
  Plot plot;
  plot.title = "PSNR against size";
  plot.x = {"bytes of the whole file", true};
  plot.y = {"PSNR, dB", false};
  Series sizes{{}, true, true, "c1", "coded to other sizes"};
  Series prefixes{{}, true, true, "c3", "prefixes of this file"};
  Series chosen{{}, false, true, "chosen", "this file"};
  chosen.points.push_back({static_cast<double>(run.coded.bytes), run.distance.psnr_db});
  for (const HtmlExtras::RdPoint& p : extras.rd_curve)
    sizes.points.push_back({static_cast<double>(p.bytes), p.psnr_db});
  if (!sizes.points.empty()) sizes.points.push_back(chosen.points.front());
  std::ranges::sort(sizes.points);
  for (const LevelFacts& level : run.levels) {
    if (level.psnr_db)
      prefixes.points.push_back({static_cast<double>(level.bytes), *level.psnr_db});
  }
  if (prefixes.points.empty()) prefixes.name.clear();
  if (sizes.points.empty()) sizes.name.clear();
  plot.series = {sizes, prefixes, chosen};
  return "<figure>" + svg(plot) + "</figure>\n";
}

/// Measured samples, the curve through them that the allocation used, and what it chose.
std::string band_plot(const codec::BandReport& band, std::size_t j) {
  Series measured{{}, false, true, "c1", "measured"}, curve{{}, true, false, "c2", ""},
      chosen{{}, false, true, "chosen", "chosen"};
  for (const alloc::Sample& sample : band.samples)
    measured.points.push_back({sample.bits, sample.distortion});
  const Result<alloc::RateDistortionCurve> fitted = alloc::RateDistortionCurve::fit(band.samples);
  if (fitted) {
    curve.name = fitted->is_spline() ? "smoothing spline" : "convex hull";
    for (int i = 0; i <= kCurvePoints; ++i) {
      const double bits =
          fitted->min_bits() + (fitted->max_bits() - fitted->min_bits()) * i / kCurvePoints;
      curve.points.push_back({bits, fitted->distortion(bits)});
    }
  }
  if (band.vertices > 0) {
    chosen.points.push_back({band.bits / static_cast<double>(band.vertices), band.distortion});
  }
  Plot plot;
  plot.title = fmt::format("band {}: distortion against rate", j);
  plot.x = {"bits per vertex of the band", false};
  plot.y = {"mean squared error", true};
  plot.series = {curve, measured, chosen};
  plot.width = 460;
  plot.height = 260;
  return fmt::format("<figure><h3>band {}</h3>{}</figure>\n", j, svg(plot));
}

std::string band_plots(const EncodeRun& run) {
  std::string out;
  for (std::size_t j = 0; j < run.coded.bands.size(); ++j)
    if (!run.coded.bands[j].samples.empty()) out += band_plot(run.coded.bands[j], j);
  return out.empty() ? out : "<div class=\"plots\">" + out + "</div>\n";
}

struct Row {
  std::string name;
  double value = 0;
  std::string text, more;
};

/// Rows with a bar each, as long as its share of the longest.
std::string bars(const std::vector<Row>& rows, const char* head) {
  double longest = 0;
  for (const Row& row : rows) longest = std::max(longest, row.value);
  std::string out = fmt::format("<table><tr>{}</tr>\n", head);
  for (const Row& row : rows) {
    const double width = longest > 0 ? 100 * row.value / longest : 0;
    out += fmt::format(
        "<tr><td>{}</td><td>{}</td><td>{}</td>"
        "<td class=\"bar\"><i style=\"width:{:.1f}%\"></i></td></tr>\n",
        escaped(row.name), escaped(row.text), escaped(row.more), width);
  }
  return out + "</table>\n";
}

std::string bytes_by_part(const EncodeRun& run) {
  std::vector<Row> rows;
  const auto add = [&](const std::string& name, double bytes) {
    const double share =
        run.coded.bytes > 0 ? 100 * bytes / static_cast<double>(run.coded.bytes) : 0;
    rows.push_back({name, bytes, fmt::format("{:.0f}", bytes), fmt::format("{:.1f} %", share)});
  };
  add("header", static_cast<double>(run.coded.bytes_header));
  add("base connectivity", static_cast<double>(run.coded.bytes_base_connectivity));
  add("base positions", static_cast<double>(run.coded.bytes_base_positions));
  for (std::size_t j = 0; j < run.coded.bands.size(); ++j)
    add(fmt::format("band {}", j), run.coded.bands[j].bits / 8);
  return bars(rows, "<th>part</th><th>bytes</th><th>share</th><th></th>");
}

std::string stages(const EncodeRun& run) {
  std::vector<Row> rows;
  for (const remesh::StageCost& cost : run.costs) {
    rows.push_back({cost.stage, cost.seconds, fmt::format("{:.2f}", cost.seconds),
                    format_bytes(cost.peak_bytes)});
  }
  return bars(rows, "<th>stage</th><th>seconds</th><th>peak memory by then</th><th></th>") +
         fmt::format(
             "<p class=\"soft\">{:.2f} s in all; parts of a stage (a/b) are in it, too</p>\n",
             run.seconds);
}

std::string level_rows(const EncodeRun& run) {
  if (run.levels.empty()) return "";
  std::string out =
      "<table><tr><th>level</th><th>bytes of the prefix</th><th>vertices</th><th>faces</th>"
      "<th>PSNR, dB</th><th>max error, certified</th></tr>\n";
  for (std::size_t j = 0; j < run.levels.size(); ++j) {
    const LevelFacts& level = run.levels[j];
    const std::string psnr = level.psnr_db ? fmt::format("{:.2f}", *level.psnr_db) : "";
    const std::string error =
        level.max_error ? fmt::format("{:.4g} ({:.3g} %)", *level.max_error,
                                      percent_of(run.distance.bbox_diagonal, *level.max_error))
                        : "";
    out +=
        fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
                    j, format_count(level.bytes), format_count(level.vertices),
                    format_count(level.triangles), psnr, error);
  }
  return out + "</table>\n";
}

std::string bands_table(const EncodeRun& run) {
  std::string out =
      "<table><tr><th>band</th><th>vertices</th><th>step</th><th>bits per vertex</th>"
      "<th>purely normal</th><th>mean squared error</th></tr>\n";
  for (std::size_t j = 0; j < run.coded.bands.size(); ++j) {
    const codec::BandReport& band = run.coded.bands[j];
    const double bits = band.vertices > 0 ? band.bits / static_cast<double>(band.vertices) : 0;
    out += fmt::format(
        "<tr><td>{}</td><td>{}</td><td>{}</td><td>{:.3f}</td><td>{:.1f} %</td>"
        "<td>{:.3g}</td></tr>\n",
        j, format_count(band.vertices),
        band.step > 0 ? fmt::format("{:.4g}", band.step) : "not coded", bits,
        100 * band.normal_only_fraction, band.distortion);
  }
  return run.coded.bands.empty() ? "" : out + "</table>\n";
}

std::string distances(const EncodeRun& run) {
  const metric::Comparison& c = run.distance;
  std::string out =
      "<table><tr><th>from</th><th>RMS</th><th>mean</th><th>99 % within</th>"
      "<th>largest</th><th>at</th></tr>\n";
  for (const auto& [name, d] :
       {std::pair("scan to decoded", &c.a_to_b), std::pair("decoded to scan", &c.b_to_a)}) {
    const Vec3 at = d->maximum_at + c.origin;
    const std::string near_all =
        d->histogram.empty() ? "" : fmt::format("{:.4g}", d->quantile(0.99, c.bbox_diagonal));
    out += fmt::format(
        "<tr><td>{}</td><td>{:.4g}</td><td>{:.4g}</td><td>{}</td><td>{:.4g} ({:.3g} "
        "%)</td><td>{:.6g} {:.6g} {:.6g}</td></tr>\n",
        name, d->rms, d->mean, near_all, d->maximum, percent_of(c.bbox_diagonal, d->maximum), at[0],
        at[1], at[2]);
  }
  out += "</table>\n";
  if (run.remesh_distance) {
    out += fmt::format(
        "<p class=\"soft\">The mesh before coding has {:.2f} dB: more bytes cannot "
        "give more than that.</p>\n",
        run.remesh_distance->psnr_db);
  }
  return out;
}

std::string histogram(const EncodeRun& run) {
  const metric::Comparison& c = run.distance;
  Plot plot;
  plot.title = "share of the surface by distance";
  plot.x = {"distance, model units", true};
  plot.y = {"% of the area per 2 dB", false};
  for (const auto& [name, css, d] : {std::tuple("scan to decoded", "c1", &c.a_to_b),
                                     std::tuple("decoded to scan", "c2", &c.b_to_a)}) {
    Series series{{}, true, false, css, name};
    if (d->sample_count == 0) continue;
    const auto count = static_cast<double>(d->sample_count);
    for (int k = 1; k < metric::kHistogramEdges && !d->histogram.empty(); ++k) {
      const double share =
          100 * static_cast<double>(d->histogram[static_cast<std::size_t>(k)]) / count;
      const bool beside = share > 0 || d->histogram[static_cast<std::size_t>(k) - 1] > 0;
      if (beside) series.points.push_back({c.bbox_diagonal * metric::histogram_edge(k), share});
    }
    plot.series.push_back(std::move(series));
  }
  return "<figure>" + svg(plot) + "</figure>\n";
}

std::string changes(const EncodeRun& run) {
  std::string out;
  if (run.from) out += fmt::format("<p>{}</p>\n", escaped("started " + describe(*run.from)));
  const std::string cleaned = describe_cleaning(run.remesh.clean);
  out += fmt::format("<p>{}</p>\n",
                     cleaned.empty() ? "the scan needed no cleaning" : escaped(cleaned));
  if (!run.input.read.not_carried.empty()) {
    std::string names;
    for (const std::string& name : run.input.read.not_carried)
      names += (names.empty() ? "" : ", ") + name;
    out += fmt::format("<p>not carried: {}</p>\n", escaped(names));
  }
  for (const std::string& line : describe_fallbacks(run.remesh.pieces, &run))
    out += fmt::format("<p>{}</p>\n", escaped(line));
  out += fmt::format("<p>{} base vertices, {} levels, {} vertices and {} faces when decoded</p>\n",
                     format_count(run.remesh.base_vertices), run.remesh.levels,
                     format_count(run.remesh.vertices), format_count(run.remesh.triangles));
  return out;
}

}  // namespace

std::string base64(std::span<const std::uint8_t> bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t there = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k) word = word << 8 | (k < there ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      out += k <= there ? kDigits[word >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

std::string to_html(const EncodeRun& run, const HtmlExtras& extras) {
  std::string page = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">"
      "<link rel=\"icon\" href=\"data:,\"><title>{} - "
      "nacre</title><style>{}</style></head>\n<body>\n",
      escaped(run.input.file.filename().string()), kStyle);
  page += head(run);
  page += section("Pictures", pictures(extras));
  page += section("Rate and distortion", rate_plot(run, extras));
  page += section("Levels: what prefixes of the file decode to", level_rows(run));
  page += section("Distances", distances(run) + histogram(run));
  page += section("Bytes by part", bytes_by_part(run));
  page += section("Bands", bands_table(run) + band_plots(run));
  page += section("Time and memory", stages(run));
  page += section("What was changed, and what was not carried", changes(run));
  return page + "</body></html>\n";
}

}  // namespace nacre::app
