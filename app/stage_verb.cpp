// SPDX-License-Identifier: GPL-3.0-or-later
//
// `nacre stage list` and `nacre stage diff`.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/json.h"
#include "app/npy.h"
#include "app/sizes.h"
#include "app/stage.h"
#include "app/verbs.h"

namespace nacre::app {
namespace fs = std::filesystem;
namespace {

bool is_stage_folder(const fs::path& folder) {
  std::error_code ignored;
  return fs::exists(folder / kStageRecordName, ignored);
}

/// The stages of a work folder in their order, or the one that the folder is.
Result<std::vector<StageFolder>> stages_in(const fs::path& folder) {
  std::vector<StageFolder> found;
  const auto add = [&](const fs::path& place) -> Result<void> {
    Result<StageFolder> stage = open_stage(place);
    if (!stage) return stage.error();
    found.push_back(std::move(*stage));
    return {};
  };
  if (is_stage_folder(folder)) {
    if (Result<void> ok = add(folder); !ok) return ok.error();
    return found;
  }
  for (std::size_t i = 0; i < kDumpStageNames.size(); ++i) {
    const fs::path place = folder / stage_folder_name(static_cast<DumpStage>(i));
    if (!is_stage_folder(place)) continue;
    if (Result<void> ok = add(place); !ok) return ok.error();
  }
  if (!found.empty()) return found;
  std::error_code ignored;
  return Error{ErrorCode::kUnreadableFile,
               fmt::format("{}: {}", folder.string(),
                           fs::is_directory(folder, ignored)
                               ? "has no stages; write some with --work-dir and --dump"
                               : "is not a folder")};
}

std::uint64_t payload_bytes(const StageFolder& stage) {
  std::uint64_t bytes = 0;
  for (const auto& [name, content] : stage.files) bytes += content.size();
  return bytes;
}

/// Whether the stage was made from the one listed before it.
bool follows(const StageFolder& stage, const StageFolder* before) {
  return before == nullptr || stage.record.parent.empty() ||
         stage.record.parent == before->record.hash;
}

std::string list_text(const std::vector<StageFolder>& stages) {
  std::string text;
  const StageFolder* before = nullptr;
  for (const StageFolder& stage : stages) {
    text += fmt::format("{:<20} {:>10} in {:2} files  {:8.2f} s  peak {:>9}  {}",
                        stage_folder_name(stage.record.stage), format_bytes(payload_bytes(stage)),
                        stage.files.size(), stage.record.seconds,
                        format_bytes(stage.record.peak_bytes), stage.record.hash.substr(0, 12));
    if (!stage.edited.empty()) text += fmt::format("  edited: {}", fmt::join(stage.edited, ", "));
    if (!follows(stage, before)) text += "  not made from the stage before it";
    text += "\n";
    before = &stage;
  }
  return text;
}

Json list_json(const std::vector<StageFolder>& stages) {
  Json list = Json::array();
  const StageFolder* before = nullptr;
  for (const StageFolder& stage : stages) {
    Json entry = {{"stage", stage_folder_name(stage.record.stage)},
                  {"folder", stage.folder.string()},
                  {"hash", stage.record.hash},
                  {"hash_now", stage.hash},
                  {"edited", stage.edited},
                  {"bytes", payload_bytes(stage)},
                  {"seconds", stage.record.seconds},
                  {"peak_bytes", stage.record.peak_bytes},
                  {"follows", follows(stage, before)}};
    entry["parent"] = stage.record.parent.empty() ? Json(nullptr) : Json(stage.record.parent);
    entry["options"] = Json::parse(stage.record.options, nullptr, false);
    list.push_back(std::move(entry));
    before = &stage;
  }
  return {{"schema", "nacre-stage-list/1"}, {"stages", std::move(list)}};
}

/// How two files of one name differ.
struct FileDifference {
  std::string name, what;  ///< for a person
  std::size_t rows_a = 0, rows_b = 0, rows_different = 0;
  double largest = 0, rms = 0;  ///< of the numbers, if the shapes agree
  std::size_t largest_row = 0;
  bool is_array = false;
};

double number_at(const NpyView& array, std::size_t i) {
  const auto read = [&]<class T>(T value) {
    std::memcpy(&value, array.data.data() + i * sizeof value, sizeof value);
    return static_cast<double>(value);
  };
  if (array.type == "<f8") return read(double{});
  if (array.type == "<f4") return read(float{});
  if (array.type == "<u4") return read(std::uint32_t{});
  if (array.type == "<i4") return read(std::int32_t{});
  if (array.type == "<u8") return read(std::uint64_t{});
  if (array.type == "<i8") return read(std::int64_t{});
  return read(std::uint8_t{});
}

FileDifference array_difference(const NpyView& a, const NpyView& b) {
  FileDifference out;
  out.is_array = true;
  out.rows_a = a.rows;
  out.rows_b = b.rows;
  if (a.rows != b.rows || a.columns != b.columns || a.type != b.type) {
    out.what = fmt::format("{} rows of {} against {} of {}", a.rows, a.type, b.rows, b.type);
    return out;
  }
  const std::size_t columns = std::max<std::size_t>(a.columns, 1);
  double squares = 0;
  for (std::size_t row = 0; row < a.rows; ++row) {
    bool differs = false;
    for (std::size_t i = row * columns; i < (row + 1) * columns; ++i) {
      const double x = number_at(a, i), y = number_at(b, i);
      const double d = std::abs(x - y);
      differs |= x != y;
      squares += d * d;
      if (d <= out.largest) continue;
      out.largest = d;
      out.largest_row = row;
    }
    out.rows_different += differs;
  }
  out.rms = a.rows == 0 ? 0 : std::sqrt(squares / static_cast<double>(a.rows * columns));
  out.what = fmt::format("{} of {} rows differ, at most by {:.6g} (row {}), rms {:.6g}",
                         out.rows_different, out.rows_a, out.largest, out.largest_row, out.rms);
  return out;
}

std::optional<FileDifference> file_difference(const std::string& name, const StageFolder& a,
                                              const StageFolder& b) {
  const auto in_a = a.files.find(name), in_b = b.files.find(name);
  FileDifference out;
  if (in_a == a.files.end() || in_b == b.files.end()) {
    out.name = name;
    out.what = in_a == a.files.end() ? "only in the second" : "only in the first";
    return out;
  }
  if (in_a->second == in_b->second) return std::nullopt;
  const auto view_a = read_npy(in_a->second), view_b = read_npy(in_b->second);
  if (view_a && view_b) {
    out = array_difference(*view_a, *view_b);
  } else {
    const auto differ = std::ranges::mismatch(in_a->second, in_b->second);
    out.what = fmt::format("{} bytes against {}, the same up to byte {}", in_a->second.size(),
                           in_b->second.size(), differ.in1 - in_a->second.begin());
  }
  out.name = name;
  return out;
}

std::vector<FileDifference> differences(const StageFolder& a, const StageFolder& b) {
  std::vector<std::string> names;
  for (const StageFolder* stage : {&a, &b})
    for (const auto& [name, content] : stage->files) names.push_back(name);
  std::ranges::sort(names);
  names.erase(std::ranges::unique(names).begin(), names.end());
  std::vector<FileDifference> found;
  for (const std::string& name : names)
    if (auto difference = file_difference(name, a, b)) found.push_back(std::move(*difference));
  return found;
}

struct StageDifference {
  std::optional<DumpStage> first;  ///< none: all stages that both have are the same
  std::vector<DumpStage> same, only_in_one;
  std::vector<FileDifference> files;
};

StageDifference compare(const std::vector<StageFolder>& a, const std::vector<StageFolder>& b) {
  StageDifference out;
  const auto find = [](const std::vector<StageFolder>& stages, DumpStage wanted) {
    const auto it = std::ranges::find_if(
        stages, [&](const StageFolder& s) { return s.record.stage == wanted; });
    return it == stages.end() ? nullptr : &*it;
  };
  for (std::size_t i = 0; i < kDumpStageNames.size(); ++i) {
    const auto stage = static_cast<DumpStage>(i);
    const StageFolder *in_a = find(a, stage), *in_b = find(b, stage);
    if (in_a == nullptr && in_b == nullptr) continue;
    if (in_a == nullptr || in_b == nullptr) {
      out.only_in_one.push_back(stage);
      continue;
    }
    if (out.first) continue;
    std::vector<FileDifference> found = differences(*in_a, *in_b);
    if (found.empty()) {
      out.same.push_back(stage);
    } else {
      out.first = stage;
      out.files = std::move(found);
    }
  }
  return out;
}

std::vector<std::string> names_of(const std::vector<DumpStage>& stages) {
  std::vector<std::string> names;
  for (const DumpStage stage : stages) names.push_back(stage_folder_name(stage));
  return names;
}

std::string diff_text(const StageDifference& difference) {
  std::string text;
  if (!difference.same.empty())
    text += fmt::format("the same: {}\n", fmt::join(names_of(difference.same), ", "));
  if (!difference.only_in_one.empty())
    text += fmt::format("in one only: {}\n", fmt::join(names_of(difference.only_in_one), ", "));
  if (!difference.first) return text + "no stage differs\n";
  text += fmt::format("first that differs: {}\n", stage_folder_name(*difference.first));
  for (const FileDifference& file : difference.files)
    text += fmt::format("  {:<22} {}\n", file.name, file.what);
  return text;
}

Json diff_json(const StageDifference& difference) {
  Json files = Json::array();
  for (const FileDifference& file : difference.files) {
    Json entry = {{"file", file.name}, {"what", file.what}};
    if (file.is_array) {
      entry["rows_a"] = file.rows_a;
      entry["rows_b"] = file.rows_b;
      entry["rows_different"] = file.rows_different;
      entry["largest"] = file.largest;
      entry["largest_row"] = file.largest_row;
      entry["rms"] = file.rms;
    }
    files.push_back(std::move(entry));
  }
  Json json = {{"schema", "nacre-stage-diff/1"}, {"same", !difference.first}};
  json["first_different"] =
      difference.first ? Json(stage_folder_name(*difference.first)) : Json(nullptr);
  json["same_stages"] = names_of(difference.same);
  json["only_in_one"] = names_of(difference.only_in_one);
  json["files"] = std::move(files);
  return json;
}

}  // namespace

Result<void> run_stage(const StageCommand& command, Console& /*console*/) {
  const Result<std::vector<StageFolder>> a = stages_in(command.a);
  if (!a) return a.error();
  std::string text;
  if (command.b.empty()) {
    text = command.json ? dump_json(list_json(*a)) : list_text(*a);
  } else {
    const Result<std::vector<StageFolder>> b = stages_in(command.b);
    if (!b) return b.error();
    const StageDifference difference = compare(*a, *b);
    if (difference.same.empty() && !difference.first)
      return Error{ErrorCode::kUnreadableFile, fmt::format("{}: has no stage that {} has too",
                                                           command.b.string(), command.a.string())};
    text = command.json ? dump_json(diff_json(difference)) : diff_text(difference);
  }
  std::fwrite(text.data(), 1, text.size(), stdout);
  return {};
}

}  // namespace nacre::app
