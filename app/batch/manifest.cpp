// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/batch/manifest.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>
#include <string_view>

#include "app/json.h"

namespace nacre::app::batch {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSchema = "nacre-batch-manifest/0";
constexpr std::size_t kLongestShown = 60;

std::string line_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

bool is_text(const Json& json, const char* key) {
  return json.contains(key) && json[key].is_string();
}

/// A name that stays below the folder it is put behind.
bool stays_below(const fs::path& path) {
  return !path.empty() && !path.is_absolute() && path.has_filename() &&
         std::none_of(path.begin(), path.end(), [](const fs::path& part) { return part == ".."; });
}

/// What is wrong with the line; empty: nothing.
std::string read_item(const Json& json, Item& item) {
  if (!is_text(json, "scan") || !is_text(json, "output")) {
    return R"(needs "scan" and "output", both text)";
  }
  item.scan = json["scan"];
  item.output = json["output"];
  if (item.scan.empty()) return R"("scan" is empty)";
  if (!stays_below(item.output) || !item.output.ends_with(".ncr")) {
    return fmt::format(R"("output" must be a .ncr file below the output folder, found '{}')",
                       item.output.substr(0, kLongestShown));
  }
  if (json.contains("options")) {
    const Json& options = json["options"];
    if (!options.is_array()) return R"("options" must be a list of words)";
    for (const Json& word : options) {
      if (!word.is_string()) return R"("options" must be a list of words)";
      item.options.push_back(word);
    }
  }
  const auto count = [&](const char* key) {
    return json.contains(key) && json[key].is_number_unsigned() ? json[key].get<std::uint64_t>()
                                                                : 0;
  };
  item.file_bytes = count("file_bytes");
  item.triangles = count("triangles");
  item.triangles_from_header =
      json.contains("triangles_from_header") && json["triangles_from_header"] == true;
  return {};
}

std::string read_head(const Json& json, Manifest& manifest) {
  if (!is_text(json, "schema") || json["schema"] != kSchema) {
    return fmt::format(
        "is no batch manifest of this version (wants schema {}); make it again with "
        "nacre batch plan",
        kSchema);
  }
  if (!is_text(json, "input_root") || !is_text(json, "output_root")) {
    return R"(needs "input_root" and "output_root", both text)";
  }
  manifest.input_root = json["input_root"].get<std::string>();
  manifest.output_root = json["output_root"].get<std::string>();
  return manifest.output_root.is_absolute() ? "" : R"("output_root" must be an absolute path)";
}

}  // namespace

std::string to_json_lines(const Manifest& manifest) {
  std::string text = line_of({{"schema", kSchema},
                              {"input_root", manifest.input_root.string()},
                              {"output_root", manifest.output_root.string()}});
  for (const Item& item : manifest.items) {
    text += line_of({{"scan", item.scan},
                     {"output", item.output},
                     {"options", item.options},
                     {"file_bytes", item.file_bytes},
                     {"triangles", item.triangles},
                     {"triangles_from_header", item.triangles_from_header}});
  }
  return text;
}

Result<Manifest> read_manifest(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in || fs::is_directory(file)) {
    return Error{
        ErrorCode::kUnreadableFile,
        fmt::format("{}: no such manifest; make one with nacre batch plan", file.string())};
  }
  Manifest manifest;
  std::size_t number = 0;
  std::set<std::string> outputs;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    const auto wrong = [&](std::string_view what) {
      return Error{ErrorCode::kUnreadableFile,
                   fmt::format("{}: line {}: {}", file.string(), number, what), number};
    };
    const Json json = Json::parse(line, nullptr, false);
    if (!json.is_object()) return wrong("is not a JSON object; is the file cut short?");
    if (manifest.output_root.empty()) {
      if (const std::string what = read_head(json, manifest); !what.empty()) return wrong(what);
      continue;
    }
    Item item;
    if (const std::string what = read_item(json, item); !what.empty()) return wrong(what);
    if (!outputs.insert(fs::path(item.output).lexically_normal().string()).second) {
      return wrong(fmt::format("'{}' is the output of an earlier line too", item.output));
    }
    manifest.items.push_back(std::move(item));
  }
  if (manifest.output_root.empty()) {
    return Error{ErrorCode::kUnreadableFile,
                 fmt::format("{}: is empty; make it with nacre batch plan", file.string())};
  }
  std::ranges::sort(manifest.items, {}, &Item::output);
  return manifest;
}

fs::path scan_path(const Manifest& manifest, const Item& item) {
  return manifest.input_root / item.scan;
}

fs::path output_path(const Manifest& manifest, const Item& item) {
  return manifest.output_root / item.output;
}

}  // namespace nacre::app::batch
