// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "app/files.h"
#include "app/json.h"
#include "app/sha256.h"
#include "io/write.h"

namespace nacre::app {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMostFiles = 1000;

Error unreadable(const fs::path& place, const std::string& what) {
  return {ErrorCode::kUnreadableFile, fmt::format("{}: {}", place.string(), what)};
}

std::string payload_hash(const std::vector<StageRecord::File>& files) {
  std::string text;
  for (const StageRecord::File& file : files) text += file.name + " " + file.sha256 + "\n";
  return sha256(text);
}

/// Two builds may do different things with the same options.
const std::string& build_hash() {
  static const std::string hash = [] {
    const auto bytes = io::read_file("/proc/self/exe");
    return bytes ? sha256(*bytes) : std::string(NACRE_VERSION);
  }();
  return hash;
}

Json parsed_or_empty(const std::string& text) {
  Json json = Json::parse(text, nullptr, false);
  return json.is_object() ? json : Json::object();
}

Json to_json(const StageRecord& record) {
  Json files = Json::array();
  for (const StageRecord::File& file : record.files)
    files.push_back({{"name", file.name}, {"bytes", file.bytes}, {"sha256", file.sha256}});
  Json json = {{"schema", kStageSchema},
               {"stage", kDumpStageNames[static_cast<std::size_t>(record.stage)]},
               {"nacre", NACRE_VERSION}};
  json["parent"] = record.parent.empty() ? Json(nullptr) : Json(record.parent);
  json["hash"] = record.hash;
  json["key"] = record.key;
  json["options"] = parsed_or_empty(record.options);
  json["seconds"] = record.seconds;
  json["peak_bytes"] = record.peak_bytes;
  json["files"] = std::move(files);
  json["facts"] = parsed_or_empty(record.facts);
  return json;
}

/// A plain name in the same folder.
bool is_plain(const std::string& name) {
  return !name.empty() && name.find('/') == std::string::npos && name != "." && name != "..";
}

Result<StageRecord> from_json(const Json& json, const fs::path& file) {
  const auto bad = [&](const std::string& what) { return unreadable(file, what); };
  if (!json.is_object() || !json.contains("schema")) return bad("is no stage record");
  if (json["schema"] != kStageSchema)
    return bad(fmt::format("has schema {}, this nacre reads {}; dump the stage again",
                           json["schema"].dump(), kStageSchema));
  StageRecord record;
  try {
    const auto name = json.at("stage").get<std::string>();
    const auto place = std::ranges::find(kDumpStageNames, name);
    if (place == kDumpStageNames.end()) return bad("names a stage that does not exist: " + name);
    record.stage = static_cast<DumpStage>(place - kDumpStageNames.begin());
    if (json.at("parent").is_string()) record.parent = json["parent"].get<std::string>();
    record.hash = json.at("hash").get<std::string>();
    record.key = json.at("key").get<std::string>();
    record.options = json.at("options").dump();
    record.facts = json.at("facts").dump();
    record.seconds = json.at("seconds").get<double>();
    record.peak_bytes = json.at("peak_bytes").get<std::size_t>();
    if (json.at("files").size() > kMostFiles) return bad("lists too many files");
    for (const Json& entry : json["files"]) {
      record.files.push_back({entry.at("name").get<std::string>(),
                              entry.at("sha256").get<std::string>(),
                              entry.at("bytes").get<std::uint64_t>()});
      if (!is_plain(record.files.back().name)) return bad("lists a file that is not in its folder");
    }
  } catch (const Json::exception&) {
    return bad("lacks an entry or has one of the wrong kind; dump the stage again");
  }
  return record;
}

}  // namespace

std::string stage_folder_name(DumpStage stage) {
  const auto place = static_cast<std::size_t>(stage);
  return fmt::format("{:02}-{}", place + 1, kDumpStageNames[place]);
}

bool StageFolder::is_edited(std::string_view name) const {
  return std::ranges::find(edited, name) != edited.end();
}

Result<std::span<const std::uint8_t>> StageFolder::file(const std::string& name) const {
  const auto it = files.find(name);
  if (it == files.end()) return unreadable(folder / name, "is not there; dump the stage again");
  return std::span<const std::uint8_t>(it->second);
}

Result<std::string> write_stage(const fs::path& folder, StageRecord record, const StageFiles& files,
                                bool overwrite) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    return Error{ErrorCode::kCannotWrite, fmt::format("{}: {}", folder.string(), error.message())};
  // Until the new record is there, the folder must not look complete.
  if (overwrite) fs::remove(folder / kStageRecordName, error);
  record.files.clear();
  for (const StageFile& file : files) {
    record.files.push_back({file.name, sha256(file.bytes), file.bytes.size()});
    if (Result<void> ok = write_output(folder / file.name, file.bytes, overwrite); !ok)
      return ok.error();
  }
  record.hash = payload_hash(record.files);
  const Result<void> written =
      write_output(folder / kStageRecordName, dump_json(to_json(record)), overwrite);
  if (!written) return written.error();
  return record.hash;
}

Result<StageRecord> read_record(const fs::path& folder) {
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored))
    return unreadable(folder, "is not the folder of a stage, like DIR/05-normal-mesh");
  const fs::path file = folder / kStageRecordName;
  if (!fs::exists(file, ignored))
    return unreadable(folder,
                      "has no stage.json; name the folder of one stage, like "
                      "DIR/05-normal-mesh, written by --dump");
  const auto bytes = io::read_file(file);
  if (!bytes) return in_file(bytes.error(), file);
  return from_json(Json::parse(bytes->begin(), bytes->end(), nullptr, false), file);
}

Result<StageFolder> open_stage(const fs::path& folder) {
  Result<StageRecord> record = read_record(folder);
  if (!record) return record.error();
  StageFolder out;
  out.folder = folder;
  out.record = std::move(*record);
  std::vector<StageRecord::File> now;
  for (const StageRecord::File& file : out.record.files) {
    const fs::path path = folder / file.name;
    std::error_code ignored;
    if (has_extension(path, ".ply") && !fs::exists(path, ignored)) {
      now.push_back(file);
      continue;
    }
    auto bytes = io::read_file(path);
    if (!bytes) return in_file(bytes.error(), path);
    now.push_back({file.name, sha256(*bytes), bytes->size()});
    if (now.back().sha256 != file.sha256) out.edited.push_back(file.name);
    out.files[file.name] = std::move(*bytes);
  }
  out.hash = payload_hash(now);
  return out;
}

Result<std::optional<StageFolder>> open_beside(const StageFolder& stage) {
  const DumpStage own = stage.record.stage;
  const bool needs_map = own == DumpStage::kBase;
  const bool needs_mesh = own == DumpStage::kRdCurves || own == DumpStage::kSteps;
  if (!needs_map && !needs_mesh) return std::optional<StageFolder>();
  const DumpStage other = needs_map ? DumpStage::kParameterisation : DumpStage::kCoefficients;
  const fs::path folder = stage.folder.has_filename() ? stage.folder.parent_path()
                                                      : stage.folder.parent_path().parent_path();
  Result<StageFolder> found = open_stage(folder / stage_folder_name(other));
  if (found) return std::optional(std::move(*found));
  Error error = found.error();
  error.message +=
      fmt::format("; --from {} needs {} beside it, which has the {}", stage_folder_name(own),
                  stage_folder_name(other), needs_map ? "map" : "mesh");
  return error;
}

std::string StageKeys::key(DumpStage stage) const {
  std::string text = build_hash() + "\n" + origin_ + "\n";
  for (std::size_t i = 0; i <= index(stage); ++i)
    text += fmt::format("{} {}\n", kDumpStageNames[i], options_[i]);
  return sha256(text);
}

}  // namespace nacre::app
