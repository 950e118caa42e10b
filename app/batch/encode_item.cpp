// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/batch/encode_item.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <fstream>

#include "app/batch/hash.h"
#include "app/batch/option_rules.h"
#include "app/files.h"
#include "app/json.h"
#include "app/progress.h"
#include "app/report.h"
#include "app/verbs.h"

namespace nacre::app::batch {
namespace {

namespace fs = std::filesystem;

std::optional<double> figure(const Json& json, const char* key) {
  if (!json.contains(key) || !json[key].is_number()) return std::nullopt;
  return json[key].get<double>();
}

std::uint64_t count(const Json& json, const char* key) {
  return json.contains(key) && json[key].is_number_unsigned() ? json[key].get<std::uint64_t>() : 0;
}

/// The report's figures; what a later version of it calls otherwise stays empty.
void read_report(const fs::path& file, Record& record) {
  std::ifstream in(file, std::ios::binary);
  const Json json = Json::parse(in, nullptr, false);
  if (!json.is_object()) return;
  record.psnr_db = figure(json, "psnr_db");
  record.max_error = figure(json, "max_error");
  record.max_error_percent = figure(json, "max_error_percent");
  record.bits_per_input_vertex = figure(json, "bits_per_input_vertex");
  const Json input = json.value("input", Json::object());
  record.vertices = count(input, "vertices");
  record.faces = count(input, "faces");
  const Json clean = json.value("clean", Json::object());
  if (clean.contains("actions") && clean["actions"].is_array()) {
    for (const Json& action : clean["actions"]) {
      if (!action.contains("kind") || !action["kind"].is_string()) continue;
      record.cleaning.emplace_back(action["kind"].get<std::string>(), count(action, "count"));
    }
  }
  if (json.contains("pieces") && json["pieces"].is_array()) {
    for (const Json& piece : json["pieces"]) {
      if (piece.is_object() && piece.value("fallback", Json()) != Json("")) ++record.fallbacks;
    }
  }
}

double cpu_seconds() {
  rusage usage = {};
  if (getrusage(RUSAGE_SELF, &usage) != 0) return 0;
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

Error changed(const fs::path& scan) {
  return {ErrorCode::kUnreadableFile,
          scan.string() + ": changed while it was being encoded; run the batch again"};
}

Result<void> finish(const Store& store, const Manifest& manifest, const Item& item,
                    const fs::path& work, Record& record) {
  const fs::path coded = work / "out.ncr", report = work / "report.json";
  Result<std::string> output_hash = hash_file(coded);
  if (!output_hash) return output_hash.error();
  record.output_hash = *output_hash;
  record.output_bytes = fs::file_size(coded);
  read_report(report, record);
  record.thumbnail = thumbnail_of(coded);
  record.cpu_seconds = cpu_seconds();
  record.peak_bytes = peak_resident_bytes();
  if (Result<void> ok = put_in_place(report, store.report_path(item)); !ok) return ok;
  if (Result<void> ok = store.write(item, record, work); !ok) return ok;
  if (Result<void> ok = put_in_place(coded, output_path(manifest, item)); !ok) return ok;
  store.forget_failure(item);
  return {};
}

}  // namespace

Result<void> encode_item(const Store& store, const Manifest& manifest, const Item& item,
                         const fs::path& work, int threads, bool force,
                         const std::atomic<bool>& cancel) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begin = Clock::now();
  const fs::path scan = scan_path(manifest, item);
  const std::optional<FileStamp> stamp = stamp_of(scan);
  Result<std::string> input_hash = hash_file(scan);
  if (!stamp || !input_hash) {
    return Error{ErrorCode::kUnreadableFile, scan.string() + ": no such file; check the path"};
  }
  if (!force && state_of(store, manifest, item, false, true) == State::kDone) {
    std::optional<Record> known = store.record(item);
    if (known) {
      known->input = *stamp;
      return store.write(item, *known, work);
    }
  }
  Result<EncodeCommand> command = encode_command(item.options, scan, work / "out.ncr");
  if (!command) return command.error();
  command->report = work / "report.json";
  command->common.threads = threads;
  command->common.verbosity = Verbosity::kQuiet;
  Console console(Verbosity::kQuiet, cancel);
  if (Result<void> encoded = run_encode(*command, console); !encoded) return encoded;
  if (stamp_of(scan) != stamp) return changed(scan);

  Record record;
  record.input = *stamp;
  record.input_hash = *input_hash;
  record.key = content_key(*input_hash, item.options);
  record.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  record.threads = threads;
  record.host = host_name();
  return finish(store, manifest, item, work, record);
}

}  // namespace nacre::app::batch
