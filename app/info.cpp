// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <cstdio>

#include "app/files.h"
#include "app/json.h"
#include "app/prefix.h"
#include "app/report.h"
#include "app/report_compare.h"
#include "app/sizes.h"
#include "app/verbs.h"
#include "codec/decode.h"
#include "io/io.h"
#include "io/write.h"
#include "remesh/remesh.h"

namespace nacre::app {
namespace {

void print(const std::string& text) { std::fwrite(text.data(), 1, text.size(), stdout); }

std::string point_text(const Vec3& p) {
  return fmt::format("{:.9g} {:.9g} {:.9g}", p[0], p[1], p[2]);
}

Json scan_json(const InputFacts& facts, const Box& box, const Result<remesh::CleanScan>& cleaned) {
  Json json = {{"file", facts.file.string()},
               {"kind", "scan"},
               {"format", facts.read.format},
               {"bytes", facts.read.file_bytes},
               {"vertices", facts.vertices},
               {"faces", facts.faces},
               {"goal_vertices", facts.goal_vertices},
               {"polygons_triangulated", facts.read.polygons_triangulated},
               {"not_carried", facts.read.not_carried},
               {"bbox",
                {{"low", point_json(box.low + facts.origin)},
                 {"high", point_json(box.high + facts.origin)},
                 {"diagonal", facts.bbox_diagonal}}},
               {"origin", point_json(facts.origin)}};
  json["clean"] = cleaned ? clean_json(cleaned->report) : Json(nullptr);
  json["refused"] = cleaned ? Json(nullptr) : Json(cleaned.error().message);
  return json;
}

std::string scan_text(const InputFacts& facts, const Box& box,
                      const Result<remesh::CleanScan>& cleaned) {
  std::string text = fmt::format(
      "{}: scan, {}, {}\nvertices  {}\nfaces     {}{}\nbox       {}  to  {}\ndiagonal  {:.9g}\n",
      facts.file.string(), facts.read.format, format_bytes(facts.read.file_bytes),
      format_count(facts.vertices), format_count(facts.faces),
      facts.read.polygons_triangulated > 0
          ? fmt::format(" ({} polygons triangulated)",
                        format_count(facts.read.polygons_triangulated))
          : "",
      point_text(box.low + facts.origin), point_text(box.high + facts.origin), facts.bbox_diagonal);
  if (!facts.read.not_carried.empty()) {
    text += fmt::format("not carried by nacre: {}\n", fmt::join(facts.read.not_carried, ", "));
  }
  if (!cleaned) return text;
  const remesh::CleanReport& clean = cleaned->report;
  text += fmt::format(
      "topology  {} piece(s), {} closed, {} boundary loop(s), genus {}; {} vertices and {} faces "
      "after cleaning\n",
      format_count(clean.pieces), format_count(clean.closed_pieces),
      format_count(clean.boundary_loops), clean.genus, format_count(clean.vertices),
      format_count(clean.triangles));
  if (clean.actions.empty()) text += "defects   none\n";
  for (const remesh::CleanAction& action : clean.actions) {
    text += fmt::format("defects   {} {} (first ids: {})\n", format_count(action.count),
                        action.kind, fmt::join(action.first_ids, " "));
  }
  return text;
}

/// Prints what is known even of a scan that cleaning refuses, then fails.
Result<void> scan_info(const InfoCommand& command) {
  Result<io::ReadResult> read = io::read_scan(command.file);
  if (!read) return in_file(read.error(), command.file);
  InputFacts facts = input_facts(command.file, *read);
  facts.bbox_diagonal = bbox_diagonal(read->scan);
  const Result<remesh::CleanScan> cleaned = remesh::clean(read->scan);
  const Box box = bounding_box(read->scan);
  print(command.json ? dump_json(scan_json(facts, box, cleaned)) : scan_text(facts, box, cleaned));
  if (!cleaned) return in_file(cleaned.error(), command.file);
  return {};
}

struct NamedSection {
  std::string name;
  std::size_t offset = 0, bytes = 0;
  double step = 0;
};

/// The sections with the bands numbered: band j is what level j + 1 adds.
std::vector<NamedSection> numbered_sections(const codec::StreamInfo& info) {
  std::vector<NamedSection> sections;
  int band = 0;
  for (const codec::StreamInfo::Section& s : info.sections) {
    const std::string name =
        s.name == "band" ? fmt::format("band {}", band++) : std::string(s.name);
    sections.push_back({name, s.offset, s.bytes, s.step});
  }
  return sections;
}

Json stream_json(const std::filesystem::path& file, const codec::StreamInfo& info) {
  Json json = {
      {"file", file.string()},
      {"kind", "ncr"},
      {"version", info.version},
      {"transform", name_of(info.transform)},
      {"bytes", info.bytes_present},
      {"bytes_whole", info.bytes_whole},
      {"base_vertices", info.base_vertices},
      {"base_triangles", info.base_triangles},
      {"base_bits", info.base_bits},
      {"origin", point_json(info.origin)},
      {"profile", codec::profile_name(info.profile)},
      {"level_table", info.level_table.has_value()},
      {"bbox_diagonal", info.level_table ? Json(info.level_table->bbox_diagonal) : Json(nullptr)},
      {"certified_error", info.certified_error ? Json(*info.certified_error) : Json(nullptr)},
      {"levels", Json::array()},
      {"sections", Json::array()}};
  for (std::size_t j = 0; j < info.levels.size(); ++j) {
    const codec::StreamInfo::Level& level = info.levels[j];
    Json entry = {{"prefix_bytes", level.bytes},  {"vertices", level.vertices},
                  {"triangles", level.triangles}, {"present", level.bytes <= info.bytes_present},
                  {"psnr_db", nullptr},           {"max_error", nullptr},
                  {"max_error_percent", nullptr}};
    if (info.level_table) {
      const codec::LevelTable::Cut& cut = info.level_table->cuts[j];
      entry["psnr_db"] = cut.psnr_db;
      entry["max_error"] = cut.max_error;
      entry["max_error_percent"] = percent_of(info.level_table->bbox_diagonal, cut.max_error);
    }
    json["levels"].push_back(std::move(entry));
  }
  for (const auto& section : numbered_sections(info)) {
    Json entry = {{"name", section.name}, {"offset", section.offset}, {"bytes", section.bytes}};
    if (section.step > 0) entry["step"] = section.step;
    json["sections"].push_back(std::move(entry));
  }
  return json;
}

/// A dash for what the table does not know: levels that only come together with a finer one.
std::string quality_columns(const codec::LevelTable& table, std::size_t level) {
  const codec::LevelTable::Cut& cut = table.cuts[level];
  const std::string psnr = cut.psnr_db > 0 ? fmt::format("{:.2f}", cut.psnr_db) : "-";
  const std::string error = std::isfinite(cut.max_error)
                                ? fmt::format("{:>10.4g} ({:.3g} %)", cut.max_error,
                                              percent_of(table.bbox_diagonal, cut.max_error))
                                : fmt::format("{:>10}", "-");
  return fmt::format("{:>13} {}", psnr, error);
}

std::string levels_text(const codec::StreamInfo& info) {
  std::string text =
      fmt::format("{:<6} {:>14} {:>14} {:>14}{}\n", "level", "prefix bytes", "vertices", "faces",
                  info.level_table ? "      PSNR dB            max error" : "");
  for (std::size_t j = 0; j < info.levels.size(); ++j) {
    const codec::StreamInfo::Level& level = info.levels[j];
    const std::string quality = info.level_table ? quality_columns(*info.level_table, j) : "";
    text += fmt::format("{:<6} {:>14} {:>14} {:>14}{}{}\n", j, format_count(level.bytes),
                        format_count(level.vertices), format_count(level.triangles), quality,
                        level.bytes <= info.bytes_present ? "" : "  (cut off)");
  }
  if (info.level_table) return text;
  return text + "no level table: PSNR and errors of the levels are not in the file\n";
}

std::string stream_text(const std::filesystem::path& file, const codec::StreamInfo& info) {
  std::string text = fmt::format(
      "{}: nacre stream version {}, {}{}\nprofile   {}, transform {}\nbase      {} vertices, {} "
      "triangles, {} "
      "bits a coordinate\n",
      file.string(), info.version, format_bytes(info.bytes_present),
      info.bytes_present < info.bytes_whole
          ? fmt::format(" (cut short: {} when whole)", format_bytes(info.bytes_whole))
          : "",
      codec::profile_name(info.profile), name_of(info.transform), format_count(info.base_vertices),
      format_count(info.base_triangles), info.base_bits);
  if (!info.origin.isZero(0)) text += fmt::format("origin    {}\n", point_text(info.origin));
  if (info.certified_error) {
    text += fmt::format(
        "certified no point is farther from the scan's surface than {:.6g}, nor the "
        "scan's from it\n",
        *info.certified_error);
  }
  text += levels_text(info);
  text += fmt::format("{:<20} {:>10} {:>10} {:>7} {:>12}\n", "section", "offset", "bytes", "share",
                      "step");
  for (const auto& section : numbered_sections(info)) {
    const double share = info.bytes_whole > 0 ? 100.0 * static_cast<double>(section.bytes) /
                                                    static_cast<double>(info.bytes_whole)
                                              : 0.0;
    text += fmt::format("{:<20} {:>10} {:>10} {:>5.1f} % {:>12}\n", section.name, section.offset,
                        format_count(section.bytes), share,
                        section.step > 0 ? fmt::format("{:.6g}", section.step) : "");
  }
  return text;
}

Result<void> stream_info(const InfoCommand& command) {
  const Result<codec::StreamInfo> info = read_stream_info(command.file);
  if (!info) return info.error();
  print(command.json ? dump_json(stream_json(command.file, *info))
                     : stream_text(command.file, *info));
  return {};
}

}  // namespace

Result<void> run_info(const InfoCommand& command, Console& console) {
  if (!is_stream_name(command.file)) console.context().report("read", 0);
  return is_stream_name(command.file) ? stream_info(command) : scan_info(command);
}

}  // namespace nacre::app
