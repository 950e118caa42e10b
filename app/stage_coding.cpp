// SPDX-License-Identifier: GPL-3.0-or-later
//
// Payloads of the stages that code: curves, steps, symbols. Small tables are JSON, to be edited by
// hand; what has a value per vertex is an array.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "app/files.h"
#include "app/json.h"
#include "app/stage_arrays.h"
#include "app/stage_files.h"
#include "codec/band_coder.h"
#include "codec/stream_reader.h"
#include "codec/stream_writer.h"

namespace nacre::app {
namespace {

constexpr const char* kStepsName = "steps.json";
constexpr const char* kSymbolsName = "symbols.json";

StageFile json_file(std::string name, const Json& json) {
  const std::string text = dump_json(json);
  return {std::move(name), {text.begin(), text.end()}};
}

Error bad_table(const StageFolder& stage, const char* name, const std::string& what) {
  return {ErrorCode::kUnreadableFile, fmt::format("{}: {}", (stage.folder / name).string(), what)};
}

Result<Json> table_of(const StageFolder& stage, const char* name) {
  const auto bytes = stage.file(name);
  if (!bytes) return bytes.error();
  Json json = Json::parse(bytes->begin(), bytes->end(), nullptr, false);
  if (!json.is_object()) return bad_table(stage, name, "is no JSON object");
  return json;
}

/// A step as people read it, beside the index that counts.
Json step_json(int index) {
  if (index == codec::kNotCoded) return {{"index", nullptr}};
  return {{"index", index}, {"size", codec::step_size(index)}};
}

int step_index_of(const Json& json) {
  return json.at("index").is_null() ? codec::kNotCoded : json["index"].get<int>();
}

std::string target_name(std::size_t level) { return fmt::format("target-{}.npy", level); }
std::string points_name(std::size_t band) { return fmt::format("band-{}.npy", band); }
std::string heads_name(std::size_t band) { return fmt::format("band-{}-heads.npy", band); }

StageFile raw_file(std::string name, std::span<const std::uint8_t> bytes) {
  return {std::move(name), {bytes.begin(), bytes.end()}};
}

bool is_step(int index) { return std::abs(index) <= codec::kMaxStepIndex; }

/// The symbols of band j; its step goes into the header's entry. Throws what Json throws.
Result<entropy::BandSymbols> band_from(const StageFolder& stage, const Json& json, std::size_t j,
                                       codec::BandEntry& header) {
  entropy::BandSymbols band;
  band.shrink_32nds = json.at("shrink_32nds").get<std::array<int, 3>>();
  band.ratio_quarters = json.at("ratio_quarters").get<int>();
  band.has_tangential = json.at("has_tangential").get<bool>();
  const int step = step_index_of(json);
  if (step == codec::kNotCoded) return band;
  if (!is_step(step))
    return bad_table(stage, kSymbolsName, "a step's index must lie in -6400 .. 6400");
  header.step_index = step;
  auto points = array_of<entropy::DetailPoint>(stage, points_name(j));
  if (!points) return points.error();
  band.points = std::move(*points);
  if (!stage.files.contains(heads_name(j))) return band;
  auto heads = array_of<std::uint8_t>(stage, heads_name(j));
  if (!heads) return heads.error();
  band.heads = std::move(*heads);
  return band;
}

}  // namespace

StageFiles files_of(const codec::EncodeReport& report) {
  StageFiles files;
  for (std::size_t j = 0; j < report.bands.size(); ++j) {
    std::vector<std::array<double, 3>> rows;
    for (const alloc::Sample& sample : report.bands[j].samples)
      rows.push_back({sample.bits, sample.distortion, sample.step});
    files.push_back(array_file(points_name(j), rows));
  }
  return files;
}

StageFiles files_of(const codec::StepChoice& choice) {
  Json steps = Json::array();
  for (const int step : choice.steps) steps.push_back(step_json(step));
  StageFiles files = {json_file(kStepsName, {{"profile", codec::profile_name(choice.profile)},
                                             {"transform", name_of(choice.transform)},
                                             {"theta_degrees", choice.theta_degrees},
                                             {"lambda", choice.lambda},
                                             {"steps", std::move(steps)}})};
  for (std::size_t j = 0; j < choice.targets.size(); ++j)
    files.push_back(array_file(target_name(j), choice.targets[j]));
  return files;
}

Result<codec::StepChoice> choice_from(const StageFolder& stage) {
  const auto json = table_of(stage, kStepsName);
  if (!json) return json.error();
  codec::StepChoice choice;
  try {
    const auto profile = codec::profile_of_name(json->at("profile").get<std::string>());
    if (!profile) return bad_table(stage, kStepsName, "names no profile that is known");
    choice.profile = *profile;
    if (json->at("transform") == "loop") choice.transform = wavelet::Transform::kLoop;
    choice.theta_degrees = json->at("theta_degrees").get<double>();
    choice.lambda = json->at("lambda").get<double>();
    for (const Json& step : json->at("steps")) choice.steps.push_back(step_index_of(step));
  } catch (const Json::exception&) {
    return bad_table(stage, kStepsName,
                     "needs profile, transform, theta_degrees, lambda, and steps with an index "
                     "each (null: not coded)");
  }
  if (!stage.files.contains(target_name(0))) return choice;
  for (std::size_t j = 0; j < choice.steps.size(); ++j) {
    auto target = array_of<Vec3>(stage, target_name(j));
    if (!target) return target.error();
    choice.targets.push_back(std::move(*target));
  }
  return choice;
}

StageFiles symbol_files_of(const codec::StreamSymbols& symbols,
                           std::span<const std::uint8_t> stream) {
  const auto layout = codec::read_layout(stream);
  const std::size_t header_bytes = layout ? layout->header_bytes : 0;
  Json bands = Json::array();
  for (std::size_t j = 0; j < symbols.bands.size(); ++j) {
    const entropy::BandSymbols& band = symbols.bands[j];
    const bool coded = !band.points.empty();
    Json entry = step_json(coded ? symbols.header.bands[j].step_index : codec::kNotCoded);
    entry["shrink_32nds"] = band.shrink_32nds;
    entry["ratio_quarters"] = band.ratio_quarters;
    entry["has_tangential"] = band.has_tangential;
    bands.push_back(std::move(entry));
  }
  const Json table = {{"profile", codec::profile_name(symbols.header.profile)},
                      {"grid", step_json(symbols.header.grid_step_index)},
                      {"grid_corner", symbols.header.grid_corner},
                      {"grid_bits", symbols.header.grid_bits},
                      {"bands", std::move(bands)}};
  StageFiles files = {raw_file("header.bin", stream.first(header_bytes)),
                      raw_file("connectivity.bin", symbols.connectivity),
                      json_file(kSymbolsName, table), array_file("grid.npy", symbols.grid)};
  for (std::size_t j = 0; j < symbols.bands.size(); ++j) {
    if (symbols.bands[j].points.empty()) continue;
    files.push_back(array_file(points_name(j), symbols.bands[j].points));
    if (!symbols.bands[j].heads.empty())
      files.push_back(array_file(heads_name(j), symbols.bands[j].heads));
  }
  return files;
}

Result<codec::StreamSymbols> symbols_from(const StageFolder& stage) {
  codec::StreamSymbols out;
  const auto header = stage.file("header.bin");
  if (!header) return header.error();
  const auto layout = codec::read_layout(*header);
  if (!layout) return in_file(layout.error(), stage.folder / "header.bin");
  out.header = layout->header;
  if (!stage.edited.empty()) {  // what was measured holds no longer
    out.header.level_table.reset();
    out.header.certified_error.reset();
  }
  const auto connectivity = stage.file("connectivity.bin");
  if (!connectivity) return connectivity.error();
  out.connectivity.assign(connectivity->begin(), connectivity->end());
  auto grid = array_of<entropy::GridPoint>(stage, "grid.npy");
  if (!grid) return grid.error();
  out.grid = std::move(*grid);
  const auto json = table_of(stage, kSymbolsName);
  if (!json) return json.error();
  try {
    out.header.grid_step_index = step_index_of(json->at("grid"));
    out.header.grid_corner = json->at("grid_corner").get<std::array<std::int64_t, 3>>();
    out.header.grid_bits = json->at("grid_bits").get<int>();
    if (json->at("bands").size() != out.header.bands.size())
      return bad_table(stage, kSymbolsName, "needs as many bands as the header has");
    for (std::size_t j = 0; j < out.header.bands.size(); ++j) {
      auto band = band_from(stage, json->at("bands").at(j), j, out.header.bands[j]);
      if (!band) return band.error();
      out.bands.push_back(std::move(*band));
    }
  } catch (const Json::exception&) {
    return bad_table(stage, kSymbolsName,
                     "needs grid, grid_corner, grid_bits, and bands with index, shrink_32nds, "
                     "ratio_quarters and has_tangential each");
  }
  if (!is_step(out.header.grid_step_index))
    return bad_table(stage, kSymbolsName, "the grid's step index must lie in -6400 .. 6400");
  return out;
}

std::string to_text(const StageFacts& facts) {
  Json bands = Json::array();
  for (const remesh::BandReport& band : facts.bands)
    bands.push_back({{"vertices", band.vertices},
                     {"normal_only", band.normal_only},
                     {"folded_triangles", band.folded_triangles}});
  Json json = {{"levels", facts.levels}, {"is_kept", facts.is_kept}};
  json["transform"] = name_of(facts.transform);
  json["clean"] = clean_json(facts.clean);
  json["bands"] = std::move(bands);
  json["pieces"] = pieces_json(facts.pieces);
  return json.dump();
}

namespace {

remesh::CleanReport clean_from_json(const Json& json) {
  remesh::CleanReport clean;
  for (const Json& entry : json.at("actions")) {
    remesh::CleanAction action;
    action.kind = entry.at("kind").get<std::string>();
    action.count = entry.at("count").get<std::size_t>();
    action.first_ids = entry.at("first_ids").get<std::vector<std::size_t>>();
    action.area = entry.value("area", 0.0);
    action.extent = entry.value("largest_extent", 0.0);
    clean.actions.push_back(std::move(action));
  }
  clean.vertices = json.at("vertices").get<std::size_t>();
  clean.triangles = json.at("triangles").get<std::size_t>();
  clean.pieces = json.at("pieces").get<std::size_t>();
  clean.closed_pieces = json.at("closed_pieces").get<std::size_t>();
  clean.boundary_loops = json.at("boundary_loops").get<std::size_t>();
  clean.genus = json.at("genus").get<int>();
  return clean;
}

}  // namespace

StageFacts facts_from(const std::string& text) {
  const Json json = Json::parse(text, nullptr, false);
  StageFacts facts;
  try {
    facts.levels = json.at("levels").get<int>();
    facts.is_kept = json.at("is_kept").get<bool>();
    if (json.at("transform") == "loop") facts.transform = wavelet::Transform::kLoop;
    facts.clean = clean_from_json(json.at("clean"));
    for (const Json& band : json.at("bands"))
      facts.bands.push_back({band.at("vertices").get<std::size_t>(),
                             band.at("normal_only").get<std::size_t>(),
                             band.at("folded_triangles").get<std::size_t>()});
    for (const Json& piece : json.at("pieces"))
      facts.pieces.push_back(
          {piece.at("triangles").get<std::size_t>(), piece.at("base_triangles").get<std::size_t>(),
           piece.at("boundary_loops").get<std::size_t>(), piece.at("genus").get<int>(),
           piece.at("fallback").get<std::string>(), piece.value("base_vertices", std::size_t{0}),
           piece.value("is_own_base", false)});
  } catch (const Json::exception&) {
    return facts;
  }
  return facts;
}

}  // namespace nacre::app
