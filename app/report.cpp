// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "app/goal.h"
#include "app/json.h"
#include "app/report_compare.h"
#include "app/sizes.h"

namespace nacre::app {
namespace {

constexpr const char* kSchema = "nacre-report/0";
/// Of docs/report.schema.json: raised when a field changes its meaning or goes; new ones may come.
constexpr int kSchemaVersion = 1;
constexpr std::size_t kListedFallbacks = 5;

double share(double part, double whole) { return whole > 0 ? part / whole : 0; }

Json input_json(const InputFacts& input) {
  return {{"file", input.file.string()},
          {"format", input.read.format},
          {"bytes", input.read.file_bytes},
          {"vertices", input.vertices},
          {"faces", input.faces},
          {"goal_vertices", input.goal_vertices},
          {"polygons_triangulated", input.read.polygons_triangulated},
          {"not_carried", input.read.not_carried},
          {"origin", point_json(input.origin)},
          {"bbox_diagonal", input.bbox_diagonal}};
}

Json from_json(const Reentry& from) {
  return {{"stage", from.stage},
          {"folder", from.folder.string()},
          {"is_edited", !from.edited.empty()},
          {"edited", from.edited}};
}

Json remesh_options_json(const RemeshSettings& settings) {
  return {{"levels", settings.levels},
          {"base_vertices", settings.base_vertices},
          {"repair", name_of(settings.repair)}};
}

Json encode_options_json(const EncodeRun& run) {
  const EncodeCommand& command = run.command;
  Json goal = {{"kind", name_of(command.goal.kind)}, {"value", command.goal.value}};
  Json options = {{"profile", codec::profile_name(command.profile)},
                  {"transform", name_of(command.transform)},
                  {"theta_degrees", command.theta_degrees},
                  {"goal", std::move(goal)},
                  {"target_bytes", run.target_bytes},
                  {"samples", command.samples}};
  options.update(remesh_options_json(command.remesh));
  return options;
}

Json levels_json(const std::vector<LevelFacts>& levels) {
  Json list = Json::array();
  for (const LevelFacts& level : levels) {
    list.push_back({{"prefix_bytes", level.bytes},
                    {"vertices", level.vertices},
                    {"triangles", level.triangles},
                    {"psnr_db", level.psnr_db ? Json(*level.psnr_db) : Json(nullptr)},
                    {"max_error", level.max_error ? Json(*level.max_error) : Json(nullptr)}});
  }
  return list;
}

Json remesh_json(const RemeshFacts& facts) {
  Json bands = Json::array();
  for (const remesh::BandReport& band : facts.bands) {
    bands.push_back({{"vertices", band.vertices},
                     {"normal_only", band.normal_only},
                     {"normal_only_fraction", share(static_cast<double>(band.normal_only),
                                                    static_cast<double>(band.vertices))},
                     {"folded_triangles", band.folded_triangles}});
  }
  return {{"levels", facts.levels},
          {"base_vertices", facts.base_vertices},
          {"base_triangles", facts.base_triangles},
          {"vertices", facts.vertices},
          {"triangles", facts.triangles},
          {"bands", std::move(bands)}};
}

Json bands_json(const std::vector<codec::BandReport>& bands) {
  Json list = Json::array();
  for (const codec::BandReport& band : bands) {
    Json samples = Json::array();
    for (const alloc::Sample& sample : band.samples) {
      samples.push_back({{"step", sample.step},
                         {"bits_per_vertex", sample.bits},
                         {"distortion", sample.distortion}});
    }
    list.push_back({{"vertices", band.vertices},
                    {"gain", band.gain},
                    {"step", band.step},
                    {"bits", band.bits},
                    {"bits_per_vertex", share(band.bits, static_cast<double>(band.vertices))},
                    {"normal_only_fraction", band.normal_only_fraction},
                    {"distortion", band.distortion},
                    {"samples", std::move(samples)}});
  }
  return list;
}

/// "seconds" and "peak_bytes", each with one entry per stage and "total".
void add_costs(Json& json, const std::vector<remesh::StageCost>& costs, double total_seconds) {
  Json seconds = Json::object(), peak = Json::object();
  std::size_t largest = 0;
  for (const remesh::StageCost& cost : costs) {
    seconds[cost.stage] = cost.seconds;
    peak[cost.stage] = cost.peak_bytes;
    largest = std::max(largest, cost.peak_bytes);
  }
  seconds["total"] = total_seconds;
  peak["total"] = largest;
  json["seconds"] = std::move(seconds);
  json["peak_bytes"] = std::move(peak);
}

std::string cost_text(double seconds) {
  return fmt::format("{:.1f} s, {}", seconds, format_bytes(peak_resident_bytes()));
}

std::string quality_text(const metric::Comparison& c) {
  const double error = max_error(c);
  return fmt::format("max error {:.3g} ({:.2g} %), PSNR {:.2f} dB", error,
                     percent_of(c.bbox_diagonal, error), c.psnr_db);
}

std::string input_text(const InputFacts& input) {
  return fmt::format("{} {} faces {}", input.file.filename().string(), format_count(input.faces),
                     format_bytes(input.read.file_bytes));
}

std::size_t distinct_positions(const Scan& scan) {
  std::vector<std::array<double, 3>> points;
  points.reserve(scan.positions.size());
  // Adding zero makes -0 and 0 the same point.
  for (const Vec3& p : scan.positions) points.push_back({p[0] + 0.0, p[1] + 0.0, p[2] + 0.0});
  std::ranges::sort(points);
  return static_cast<std::size_t>(std::ranges::unique(points).begin() - points.begin());
}

}  // namespace

std::string dump_json(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Json point_json(const Vec3& point) { return Json::array({point[0], point[1], point[2]}); }

Json clean_json(const remesh::CleanReport& clean) {
  Json actions = Json::array();
  for (const remesh::CleanAction& action : clean.actions) {
    Json entry = {{"kind", action.kind}, {"count", action.count}, {"first_ids", action.first_ids}};
    if (action.area > 0) entry["area"] = action.area;
    if (action.extent > 0) entry["largest_extent"] = action.extent;
    actions.push_back(std::move(entry));
  }
  return {{"actions", std::move(actions)},
          {"vertices", clean.vertices},
          {"triangles", clean.triangles},
          {"pieces", clean.pieces},
          {"closed_pieces", clean.closed_pieces},
          {"boundary_loops", clean.boundary_loops},
          {"genus", clean.genus}};
}

Json pieces_json(const std::vector<remesh::PieceReport>& pieces) {
  Json list = Json::array();
  for (const remesh::PieceReport& piece : pieces) {
    list.push_back({{"triangles", piece.triangles},
                    {"base_triangles", piece.base_triangles},
                    {"base_vertices", piece.base_vertices},
                    {"is_own_base", piece.is_own_base},
                    {"boundary_loops", piece.boundary_loops},
                    {"genus", piece.genus},
                    {"fallback", piece.fallback}});
  }
  return list;
}

std::size_t base_bytes_estimate(const remesh::PieceReport& piece, const RemeshFacts& remesh,
                                const codec::EncodeReport& coded) {
  const double triangles = share(static_cast<double>(piece.base_triangles),
                                 static_cast<double>(remesh.base_triangles)),
               vertices = share(static_cast<double>(piece.base_vertices),
                                static_cast<double>(remesh.base_vertices));
  return static_cast<std::size_t>(
      std::lround(triangles * static_cast<double>(coded.bytes_base_connectivity) +
                  vertices * static_cast<double>(coded.bytes_base_positions)));
}

StageClock::StageClock() : begin_(Clock::now()), stage_begin_(begin_) {}

void StageClock::finish(const std::string& stage) {
  const Clock::time_point now = Clock::now();
  const double seconds = std::chrono::duration<double>(now - stage_begin_).count();
  costs_.push_back({stage, seconds, peak_resident_bytes()});
  stage_begin_ = now;
}

void StageClock::finish(const std::string& stage, const std::vector<remesh::StageCost>& parts) {
  for (const remesh::StageCost& part : parts) {
    costs_.push_back({stage + "/" + part.stage, part.seconds, part.peak_bytes});
  }
  finish(stage);
}

double StageClock::total_seconds() const {
  return std::chrono::duration<double>(Clock::now() - begin_).count();
}

std::size_t peak_resident_bytes() {
  rusage usage = {};
  if (getrusage(RUSAGE_SELF, &usage) != 0) return 0;
  return static_cast<std::size_t>(usage.ru_maxrss) * 1024;  // Linux counts in KiB
}

InputFacts input_facts(const std::filesystem::path& file, const io::ReadResult& read) {
  InputFacts facts;
  facts.file = file;
  facts.read = read.report;
  facts.vertices = read.scan.positions.size();
  facts.faces = read.scan.triangles.size();
  facts.goal_vertices =
      read.report.format.starts_with("stl") ? distinct_positions(read.scan) : facts.vertices;
  facts.origin = read.scan.origin;
  return facts;
}

std::vector<LevelFacts> level_facts(const codec::StreamInfo& info) {
  std::vector<LevelFacts> facts;
  for (std::size_t j = 0; j < info.levels.size(); ++j) {
    const codec::StreamInfo::Level& level = info.levels[j];
    LevelFacts& fact = facts.emplace_back();
    fact = {level.bytes, level.vertices, level.triangles, {}, {}};
    if (!info.level_table) continue;
    fact.psnr_db = info.level_table->cuts[j].psnr_db;
    const double error = info.level_table->cuts[j].max_error;
    if (std::isfinite(error)) fact.max_error = error;
  }
  return facts;
}

RemeshFacts remesh_facts(const remesh::Remesh& remesh) {
  RemeshFacts facts;
  facts.clean = remesh.clean;
  facts.bands = remesh.bands;
  facts.pieces = remesh.pieces;
  facts.base_vertices = remesh.mesh.base_vertex_count;
  facts.base_triangles = remesh.mesh.base_triangles.size();
  facts.vertices = remesh.mesh.positions.size();
  facts.levels = remesh.mesh.level_count;
  facts.triangles = facts.base_triangles << (2 * facts.levels);
  return facts;
}

std::string to_json(const EncodeRun& run) {
  const codec::EncodeReport& coded = run.coded;
  const double bits = 8.0 * static_cast<double>(coded.bytes);
  const double error = max_error(run.distance);
  Json json = {{"schema", kSchema},
               {"schema_version", kSchemaVersion},
               {"verb", "encode"},
               {"nacre", NACRE_VERSION}};
  json["input"] = input_json(run.input);
  json["output"] = run.command.output.string();
  if (run.from) json["from"] = from_json(*run.from);
  json["options"] = encode_options_json(run);
  json["bytes"] = coded.bytes;
  json["bytes_header"] = coded.bytes_header;
  json["bytes_base"] = coded.bytes_base;
  json["bytes_base_connectivity"] = coded.bytes_base_connectivity;
  json["bytes_base_positions"] = coded.bytes_base_positions;
  json["base_bits"] = coded.base_bits;
  json["bits_per_input_vertex"] = share(bits, static_cast<double>(run.input.goal_vertices));
  json["bits_per_semiregular_vertex"] = share(bits, static_cast<double>(run.remesh.vertices));
  json["psnr_db"] = run.distance.psnr_db;
  json["remesh_psnr_db"] = run.remesh_distance ? Json(run.remesh_distance->psnr_db) : Json(nullptr);
  json["max_error"] = error;
  json["max_error_percent"] = percent_of(run.distance.bbox_diagonal, error);
  json["distance"] = comparison_json(run.distance, run.certified);
  json["remesh_distance"] =
      run.remesh_distance ? comparison_json(*run.remesh_distance) : Json(nullptr);
  json["allocation"] = {
      {"lambda", coded.lambda},
      {"predicted_distortion", coded.predicted_distortion},
      {"measured_distortion", coded.measured_distortion},
      {"relative_error",
       share(coded.predicted_distortion - coded.measured_distortion, coded.measured_distortion)}};
  json["levels"] = coded.levels;
  json["level_table"] = levels_json(run.levels);
  json["bands"] = bands_json(coded.bands);
  json["clean"] = clean_json(run.remesh.clean);
  json["pieces"] = pieces_json(run.remesh.pieces);
  for (std::size_t i = 0; i < run.remesh.pieces.size(); ++i)
    json["pieces"][i]["base_bytes_estimate"] =
        base_bytes_estimate(run.remesh.pieces[i], run.remesh, run.coded);
  json["remesh"] = remesh_json(run.remesh);
  add_costs(json, run.costs, run.seconds);
  return dump_json(json);
}

std::string to_json(const RemeshRun& run) {
  const double error = max_error(run.distance);
  Json json = {{"schema", kSchema},
               {"schema_version", kSchemaVersion},
               {"verb", "remesh"},
               {"nacre", NACRE_VERSION}};
  json["input"] = input_json(run.input);
  json["output"] = run.command.output.string();
  if (run.from) json["from"] = from_json(*run.from);
  json["options"] = remesh_options_json(run.command.remesh);
  json["options"]["samples"] = run.command.samples;
  json["remesh_psnr_db"] = run.distance.psnr_db;
  json["max_error"] = error;
  json["max_error_percent"] = percent_of(run.distance.bbox_diagonal, error);
  json["distance"] = comparison_json(run.distance);
  json["clean"] = clean_json(run.remesh.clean);
  json["pieces"] = pieces_json(run.remesh.pieces);
  json["remesh"] = remesh_json(run.remesh);
  add_costs(json, run.costs, run.seconds);
  return dump_json(json);
}

std::string describe(const Reentry& from) {
  return fmt::format("from {}{}", from.folder.string(),
                     from.edited.empty()
                         ? ", as it was dumped"
                         : fmt::format(", edited: {}", fmt::join(from.edited, ", ")));
}

std::string summary_line(const EncodeRun& run) {
  const double ratio =
      share(static_cast<double>(run.input.read.file_bytes), static_cast<double>(run.coded.bytes));
  return fmt::format("{} -> {} {} ({:.{}f}x), {}, {}", input_text(run.input),
                     run.command.output.filename().string(), format_bytes(run.coded.bytes), ratio,
                     ratio < 10 ? 1 : 0, quality_text(run.distance), cost_text(run.seconds));
}

std::string summary_line(const RemeshRun& run) {
  return fmt::format("{} -> {} {} faces ({} base faces, {} levels), {}, {}", input_text(run.input),
                     run.command.output.filename().string(), format_count(run.remesh.triangles),
                     format_count(run.remesh.base_triangles), run.remesh.levels,
                     quality_text(run.distance), cost_text(run.seconds));
}

std::string describe_cleaning(const remesh::CleanReport& clean) {
  std::string line;
  for (const remesh::CleanAction& action : clean.actions) {
    line += fmt::format("{}{} {}", line.empty() ? "cleaned: " : ", ", format_count(action.count),
                        action.kind);
  }
  return line;
}

std::vector<std::string> describe_fallbacks(const std::vector<remesh::PieceReport>& pieces,
                                            const EncodeRun* run) {
  std::vector<std::string> lines;
  std::size_t more = 0;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (pieces[i].fallback.empty()) continue;
    if (lines.size() == kListedFallbacks) {
      ++more;
      continue;
    }
    lines.push_back(fmt::format("piece {} ({} triangles): {}", i, format_count(pieces[i].triangles),
                                pieces[i].fallback));
    if (run != nullptr)
      lines.back() +=
          fmt::format("; its share of the base mesh is about {}",
                      format_bytes(base_bytes_estimate(pieces[i], run->remesh, run->coded)));
  }
  if (more > 0) lines.push_back(fmt::format("{} more such pieces; --report lists them", more));
  return lines;
}

std::vector<std::string> describe_costs(const std::vector<remesh::StageCost>& costs) {
  std::vector<std::string> lines;
  for (const remesh::StageCost& cost : costs) {
    lines.push_back(fmt::format("  {:<28} {:8.2f} s  peak {}", cost.stage, cost.seconds,
                                format_bytes(cost.peak_bytes)));
  }
  return lines;
}

}  // namespace nacre::app
