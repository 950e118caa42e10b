// SPDX-License-Identifier: GPL-3.0-or-later
//
// A table that is whole without scripts; the script only sorts it and hides rows.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <string_view>

#include "app/batch/summary.h"
#include "app/report_svg.h"
#include "app/sizes.h"

namespace nacre::app::batch {
namespace {

constexpr std::string_view kHead = R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>nacre batch</title>
<meta name="viewport" content="width=device-width">
<style>
body { font: 14px/1.4 system-ui, sans-serif; margin: 1.5em; color: #222; background: #fff; }
table { border-collapse: collapse; }
th, td { padding: .25em .6em; border-bottom: 1px solid #ddd; text-align: right; vertical-align: middle; }
th { position: sticky; top: 0; background: #f3f3f3; }
th button { font: inherit; font-weight: 600; border: 0; background: none; cursor: pointer; padding: 0; }
th[aria-sort=ascending] button::after { content: " \25B4"; }
th[aria-sort=descending] button::after { content: " \25BE"; }
.text { text-align: left; }
td.why { max-width: 34em; }
img { display: block; }
tr.failed td, tr.foreign td { background: #fbe9e7; }
tr.missing td { background: #fff6dd; }
.totals { display: flex; flex-wrap: wrap; gap: .4em 2em; margin: 1em 0; padding: 0; list-style: none; }
input { font: inherit; padding: .2em .4em; width: 20em; }
</style></head><body>
<h1>nacre batch</h1>
)";

constexpr std::string_view kScript = R"(<script>
const table = document.querySelector("table"), body = table.tBodies[0];
const heads = [...table.tHead.rows[0].cells];
const value = (row, i) => row.cells[i].dataset.v ?? row.cells[i].textContent;
heads.forEach((head, i) => head.firstChild?.addEventListener("click", () => {
  const up = head.getAttribute("aria-sort") !== "ascending";
  heads.forEach(h => h.removeAttribute("aria-sort"));
  head.setAttribute("aria-sort", up ? "ascending" : "descending");
  const text = head.classList.contains("text");
  body.append(...[...body.rows].sort((a, b) => {
    const x = value(a, i), y = value(b, i);
    if (x === "" || y === "") return (x === "") - (y === "");
    return (text ? x.localeCompare(y) : x - y) * (up ? 1 : -1);
  }));
}));
document.querySelector("input").addEventListener("input", event => {
  const wanted = event.target.value.toLowerCase();
  for (const row of body.rows) row.hidden = !row.textContent.toLowerCase().includes(wanted);
});
</script>
)";

std::string text_cell(std::string_view text, std::string_view style = "text") {
  return fmt::format("<td class=\"{}\">{}</td>", style, escaped(text));
}

/// Shown for people, sorted by the number.
std::string number_cell(double value, const std::string& shown) {
  return fmt::format("<td data-v=\"{}\">{}</td>", value, shown);
}

std::string figure_cell(const std::optional<double>& value, const char* format) {
  if (!value) return "<td data-v=\"\"></td>";
  return number_cell(*value, fmt::format(fmt::runtime(format), *value));
}

std::string bytes_cell(std::uint64_t bytes) {
  return number_cell(static_cast<double>(bytes), format_bytes(bytes));
}

std::string record_cells(const Record& r) {
  const double ratio =
      r.output_bytes > 0 ? static_cast<double>(r.input.bytes) / static_cast<double>(r.output_bytes)
                         : 0;
  std::string why = describe_cleaning(r);
  if (r.fallbacks > 0) {
    why += fmt::format("{}{} pieces kept as they were", why.empty() ? "" : "; ",
                       format_count(r.fallbacks));
  }
  return number_cell(static_cast<double>(r.faces), format_count(r.faces)) +
         bytes_cell(r.input.bytes) + bytes_cell(r.output_bytes) + figure_cell(ratio, "{:.1f}") +
         figure_cell(r.psnr_db, "{:.2f}") + figure_cell(r.max_error, "{:.4g}") +
         figure_cell(r.max_error_percent, "{:.4f}") + figure_cell(r.seconds, "{:.1f}") +
         bytes_cell(r.peak_bytes) + text_cell(why, "text why");
}

std::string failure_cells(const Row& row) {
  std::string cells;
  constexpr int kNumbers = 9;
  for (int i = 0; i < kNumbers; ++i) cells += "<td data-v=\"\"></td>";
  std::string why = reason(row);
  if (row.failure) {
    why = fmt::format("exit code {}, {} attempt{}: {}", row.failure->exit_code,
                      row.failure->attempts, row.failure->attempts == 1 ? "" : "s", why);
  }
  return cells + text_cell(why, "text why");
}

std::string row_html(const Row& row) {
  std::string html = fmt::format("<tr class=\"{}\"><td>", name_of(row.state));
  if (row.record && !row.record->thumbnail.empty()) {
    html += fmt::format(R"(<img alt="" loading="lazy" src="data:image/png;base64,{}">)",
                        escaped(row.record->thumbnail));
  }
  html += "</td>" + text_cell(name_of(row.state)) + text_cell(row.item.scan);
  html += row.record ? record_cells(*row.record) : failure_cells(row);
  return html + text_cell(fmt::format("{}", fmt::join(row.item.options, " "))) + "</tr>\n";
}

std::string totals_html(const Totals& t) {
  const double ratio =
      t.output_bytes > 0 ? static_cast<double>(t.input_bytes) / static_cast<double>(t.output_bytes)
                         : 0;
  return fmt::format(
      "<ul class=\"totals\"><li>{} scans</li><li>{} done</li><li>{} failed</li><li>{} missing</li>"
      "<li>{} faces</li><li>{} &rarr; {} ({:.1f}&times;)</li><li>{:.1f} s of encoding, {:.1f} s of "
      "processor time</li><li>largest memory {}</li></ul>\n",
      format_count(t.scans), format_count(t.done), format_count(t.failed + t.foreign),
      format_count(t.missing), format_count(t.faces), format_bytes(t.input_bytes),
      format_bytes(t.output_bytes), ratio, t.seconds, t.cpu_seconds, format_bytes(t.peak_bytes));
}

}  // namespace

std::string summary_html(const std::vector<Row>& rows) {
  struct Column {
    const char* name;
    bool is_text;
  };
  constexpr std::array<Column, 13> kColumns = {{{"state", true},
                                                {"scan", true},
                                                {"faces", false},
                                                {"input", false},
                                                {"output", false},
                                                {"ratio", false},
                                                {"PSNR dB", false},
                                                {"max error", false},
                                                {"max error %", false},
                                                {"seconds", false},
                                                {"memory", false},
                                                {"cleaning, or why not", true},
                                                {"options", true}}};
  std::string html(kHead);
  html += totals_html(totals_of(rows));
  html +=
      "<p><input type=\"search\" aria-label=\"show rows with\" placeholder=\"show rows with "
      "...\"></p>\n<table><thead><tr><th></th>";
  for (const Column& column : kColumns) {
    html += fmt::format("<th{}><button>{}</button></th>", column.is_text ? " class=\"text\"" : "",
                        column.name);
  }
  html += "</tr></thead><tbody>\n";
  for (const Row& row : rows) html += row_html(row);
  html += "</tbody></table>\n";
  html += kScript;
  return html + "</body></html>\n";
}

}  // namespace nacre::app::batch
