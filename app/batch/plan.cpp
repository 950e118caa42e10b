// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/batch/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iostream>
#include <map>
#include <set>
#include <system_error>

#include "app/batch/estimate.h"
#include "app/batch/glob.h"
#include "app/batch/option_rules.h"
#include "app/batch/scan_size.h"
#include "app/batch/verbs.h"
#include "app/exit_code.h"
#include "app/files.h"
#include "app/json.h"
#include "app/sizes.h"

namespace nacre::app::batch {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 4> kScanExtensions = {".ply", ".obj", ".off", ".stl"};

Error unreadable(const fs::path& file, const std::string& what) {
  return {ErrorCode::kUnreadableFile, fmt::format("{}: {}", file.string(), what)};
}

bool is_scan_name(const fs::path& file) {
  return std::ranges::any_of(kScanExtensions,
                             [&](std::string_view e) { return has_extension(file, e); });
}

/// JSON is UTF-8, and a name that is not would not come back from it.
bool survives_json(const std::string& name) {
  const std::string text = Json(name).dump(-1, ' ', false, Json::error_handler_t::replace);
  return Json::parse(text, nullptr, false) == Json(name);
}

/// Every file of the folder, by its path below it; links to folders are not followed, for they can
/// lead in circles.
Result<std::vector<std::string>> files_below(const fs::path& folder, Console& console) {
  std::vector<std::string> files;
  std::error_code failed;
  fs::recursive_directory_iterator it(folder, failed), end;
  if (failed) return unreadable(folder, "cannot be listed: " + failed.message());
  while (it != end) {
    const fs::path name = it->path().filename();
    std::error_code ignored;
    if (it->is_directory(ignored) && name.string().starts_with(".")) {
      it.disable_recursion_pending();
    } else if (it->is_regular_file(ignored) && !name.string().starts_with(".")) {
      files.push_back(fs::relative(it->path(), folder, ignored).generic_string());
    }
    const fs::path at = it->path();
    it.increment(failed);
    if (failed) {
      console.warning(fmt::format("{}: cannot be listed: {}", at.string(), failed.message()));
      break;
    }
  }
  return files;
}

struct Listing {
  fs::path root;                   ///< what the mirror hangs from
  std::vector<std::string> files;  ///< below it
};

/// One path a line, relative to the current folder; the root is the deepest folder they share.
Result<Listing> read_list(const fs::path& list) {
  std::ifstream file;
  if (list != "-") {
    file.open(list, std::ios::binary);
    if (!file) return unreadable(list, "no such folder or list of scans; check the path");
  }
  std::istream& in = list == "-" ? std::cin : file;
  std::vector<fs::path> paths;
  for (std::string line; std::getline(in, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (!line.empty()) paths.push_back(fs::absolute(line).lexically_normal());
  }
  if (paths.empty()) return unreadable(list, "names no scan");
  Listing listing;
  listing.root = paths.front().parent_path();
  for (const fs::path& path : paths) {
    while (listing.root.has_relative_path() &&
           *path.lexically_relative(listing.root).begin() == "..") {
      listing.root = listing.root.parent_path();
    }
  }
  for (const fs::path& path : paths) {
    listing.files.push_back(path.lexically_relative(listing.root).generic_string());
  }
  return listing;
}

bool wanted(const PlanCommand& command, const std::string& file, bool listed) {
  const auto named_by = [&](const std::vector<std::string>& patterns) {
    return std::ranges::any_of(patterns, [&](const std::string& p) { return glob_match(p, file); });
  };
  if (named_by(command.exclude)) return false;
  return command.include.empty() ? listed || is_scan_name(file) : named_by(command.include);
}

/// Outputs by scan; see make_plan().
std::map<std::string, std::string> output_names(const std::vector<std::string>& scans) {
  const auto short_name = [](const std::string& scan) {
    return fs::path(scan).replace_extension(".ncr").generic_string();
  };
  std::map<std::string, int> uses;
  for (const std::string& scan : scans) {
    ++uses[short_name(scan)];
    ++uses[scan + ".ncr"];  // "a.ply.obj" may want the long name of "a.ply"
  }
  std::map<std::string, std::string> names;
  for (const std::string& scan : scans) {
    const std::string name = short_name(scan);
    names[scan] = uses[name] > 1 ? scan + ".ncr" : name;
  }
  return names;
}

Result<std::vector<OptionRule>> all_rules(const PlanCommand& command) {
  std::vector<OptionRule> rules;
  if (!command.options_file.empty()) {
    Result<std::vector<OptionRule>> read = read_rules(command.options_file);
    if (!read) return read.error();
    rules = std::move(*read);
  }
  Result<std::vector<EncodeOption>> common = split_options(command.encode_options);
  if (!common) return Error{ErrorCode::kBadInput, "after --: " + common.error().message};
  if (!common->empty()) rules.push_back({"", *common});
  for (const std::string& text : command.rules) {
    Result<OptionRule> rule = parse_rule(text);
    if (!rule) return rule.error();
    rules.push_back(*rule);
  }
  return rules;
}

Result<Listing> find_scans(const PlanCommand& command, Console& console) {
  const bool is_folder = fs::is_directory(command.source);
  Listing listing;
  if (is_folder) {
    listing.root = fs::canonical(command.source);
    Result<std::vector<std::string>> files = files_below(listing.root, console);
    if (!files) return files.error();
    listing.files = std::move(*files);
  } else {
    Result<Listing> read = read_list(command.source);
    if (!read) return read.error();
    listing = std::move(*read);
  }
  std::erase_if(listing.files, [&](const std::string& file) {
    if (!wanted(command, file, !is_folder)) return true;
    if (survives_json(file)) return false;
    console.warning(fmt::format("{}: left out, its name is not UTF-8; rename it", file));
    return true;
  });
  std::ranges::sort(listing.files);
  const auto repeated = std::ranges::unique(listing.files);
  listing.files.erase(repeated.begin(), repeated.end());
  if (listing.files.empty()) {
    return unreadable(command.source,
                      "holds no scan that is asked for (.ply .obj .off .stl, or --include)");
  }
  return listing;
}

fs::path output_root(const PlanCommand& command) {
  fs::path root = command.output_dir;
  if (root.empty()) root = fs::absolute(command.manifest).parent_path() / "ncr";
  return fs::weakly_canonical(fs::absolute(root));
}

}  // namespace

Result<Manifest> make_plan(const PlanCommand& command, Console& console) try {
  Result<std::vector<OptionRule>> rules = all_rules(command);
  if (!rules) return rules.error();
  Result<Listing> listing = find_scans(command, console);
  if (!listing) return listing.error();
  Manifest manifest;
  manifest.input_root = listing->root;
  manifest.output_root = output_root(command);
  const std::map<std::string, std::string> names = output_names(listing->files);
  std::set<std::vector<std::string>> checked;
  for (const auto& [scan, output] : names) {
    Item item;
    item.scan = scan;
    item.output = output;
    item.options = options_for(*rules, scan);
    if (checked.insert(item.options).second) {
      Result<EncodeCommand> fine =
          encode_command(item.options, scan_path(manifest, item), output_path(manifest, item));
      if (!fine) return in_file(fine.error(), scan);
    }
    const ScanSize size = scan_size(scan_path(manifest, item));
    item.file_bytes = size.file_bytes;
    item.triangles = size.triangles;
    item.triangles_from_header = size.from_header;
    manifest.items.push_back(std::move(item));
  }
  std::ranges::sort(manifest.items, {}, &Item::output);
  return manifest;
} catch (const fs::filesystem_error& error) {
  return Error{ErrorCode::kUnreadableFile, error.what()};
}

Result<int> run_plan(const PlanCommand& command, Console& console) {
  if (Result<void> ok = check_output(command.manifest, command.overwrite, command.source); !ok) {
    return ok.error();
  }
  Result<Manifest> manifest = make_plan(command, console);
  if (!manifest) return manifest.error();
  Result<void> written =
      write_output(command.manifest, to_json_lines(*manifest), command.overwrite);
  if (!written) return written.error();
  double seconds = 0;
  std::uint64_t triangles = 0, largest = 0;
  for (const Item& item : manifest->items) {
    seconds += estimated_seconds(item);
    triangles += item.triangles;
    largest = std::max(largest, estimated_bytes(item));
  }
  console.note(fmt::format(
      "{}: {} scans, {} triangles, about {:.1f} hours on one thread; the largest takes about {}",
      command.manifest.string(), format_count(manifest->items.size()), format_count(triangles),
      seconds / 3600, format_bytes(largest)));
  return int{kExitDone};
}

}  // namespace nacre::app::batch
