// SPDX-License-Identifier: GPL-3.0-or-later
//
// Read me first: done means that the record is there, that its key is that of today's input,
// options and codec, and that the output has the hash that the record says. The record is written
// before the output gets its name, so a kill between the two leaves a record without its output,
// which is not done and is made again; an output without a record is somebody else's file.
#include "app/batch/record.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <system_error>

#include "app/batch/hash.h"
#include "app/files.h"
#include "app/json.h"

namespace nacre::app::batch {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRecordSchema = "nacre-batch-record/0";
constexpr const char* kFailureSchema = "nacre-batch-failure/0";

// Readers of what may be any bytes: a field of another type counts as missing.
std::string text(const Json& json, const char* key) {
  return json.contains(key) && json[key].is_string() ? json[key].get<std::string>() : "";
}
template <class T>
T number(const Json& json, const char* key) {
  return json.contains(key) && json[key].is_number() ? json[key].get<T>() : T{};
}
std::optional<double> maybe(const Json& json, const char* key) {
  if (!json.contains(key) || !json[key].is_number()) return std::nullopt;
  return json[key].get<double>();
}
Json maybe(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json to_json(const Record& r) {
  Json cleaning = Json::array();
  for (const auto& [kind, count] : r.cleaning) {
    cleaning.push_back({{"kind", kind}, {"count", count}});
  }
  return {{"schema", kRecordSchema},
          {"key", r.key},
          {"nacre", codec_version()},
          {"input",
           {{"bytes", r.input.bytes},
            {"modified_ns", r.input.modified_ns},
            {"xxh3_128", r.input_hash},
            {"vertices", r.vertices},
            {"faces", r.faces}}},
          {"output", {{"bytes", r.output_bytes}, {"xxh3_128", r.output_hash}}},
          {"psnr_db", maybe(r.psnr_db)},
          {"max_error", maybe(r.max_error)},
          {"max_error_percent", maybe(r.max_error_percent)},
          {"bits_per_input_vertex", maybe(r.bits_per_input_vertex)},
          {"cleaning", std::move(cleaning)},
          {"fallbacks", r.fallbacks},
          {"run",
           {{"seconds", r.seconds},
            {"cpu_seconds", r.cpu_seconds},
            {"peak_bytes", r.peak_bytes},
            {"threads", r.threads},
            {"host", r.host}}},
          {"thumbnail_png", r.thumbnail}};
}

Record record_of(const Json& json) {
  Record r;
  r.key = text(json, "key");
  const Json input = json.value("input", Json::object());
  r.input = {number<std::uint64_t>(input, "bytes"), number<std::int64_t>(input, "modified_ns")};
  r.input_hash = text(input, "xxh3_128");
  r.vertices = number<std::uint64_t>(input, "vertices");
  r.faces = number<std::uint64_t>(input, "faces");
  const Json output = json.value("output", Json::object());
  r.output_bytes = number<std::uint64_t>(output, "bytes");
  r.output_hash = text(output, "xxh3_128");
  r.psnr_db = maybe(json, "psnr_db");
  r.max_error = maybe(json, "max_error");
  r.max_error_percent = maybe(json, "max_error_percent");
  r.bits_per_input_vertex = maybe(json, "bits_per_input_vertex");
  for (const Json& entry : json.value("cleaning", Json::array())) {
    r.cleaning.emplace_back(text(entry, "kind"), number<std::uint64_t>(entry, "count"));
  }
  r.fallbacks = number<std::uint64_t>(json, "fallbacks");
  const Json run = json.value("run", Json::object());
  r.seconds = number<double>(run, "seconds");
  r.cpu_seconds = number<double>(run, "cpu_seconds");
  r.peak_bytes = number<std::uint64_t>(run, "peak_bytes");
  r.threads = number<int>(run, "threads");
  r.host = text(run, "host");
  r.thumbnail = text(json, "thumbnail_png");
  return r;
}

/// An object of this schema, or null.
Json read_object(const fs::path& file, const char* schema) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return nullptr;
  Json json = Json::parse(in, nullptr, false);
  return json.is_object() && text(json, "schema") == schema ? json : Json(nullptr);
}

Result<void> write_object(const fs::path& file, const Json& json, const fs::path& work) {
  const fs::path written = work / "state.json";
  if (Result<void> ok = write_output(written, dump_json(json), true); !ok) return ok;
  return put_in_place(written, file);
}

fs::path state_file(const fs::path& folder, const char* kind, const Item& item) {
  return folder / kind / (item.output + ".json");
}

/// Two lists of words are equal exactly if these are.
std::string canonical(const std::vector<std::string>& options) {
  std::string joined;
  for (const std::string& word : options) joined += fmt::format("{}:{},", word.size(), word);
  return joined;
}

}  // namespace

std::optional<FileStamp> stamp_of(const fs::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return std::nullopt;
  constexpr std::int64_t kSecond = 1'000'000'000;
  return FileStamp{static_cast<std::uint64_t>(status.st_size),
                   status.st_mtim.tv_sec * kSecond + status.st_mtim.tv_nsec};
}

std::string codec_version() { return NACRE_VERSION; }

std::string content_key(const std::string& input_hash, const std::vector<std::string>& options) {
  return hash_of(fmt::format("nacre-batch-key/0\n{}\n{}\n{}", input_hash, canonical(options),
                             codec_version()));
}

std::string failure_key(const FileStamp& input, const std::vector<std::string>& options) {
  return hash_of(fmt::format("nacre-batch-attempt/0\n{}\n{}\n{}\n{}", input.bytes,
                             input.modified_ns, canonical(options), codec_version()));
}

Result<void> put_in_place(const fs::path& from, const fs::path& to) {
  std::error_code failed;
  fs::create_directories(to.parent_path(), failed);
  if (!failed) fs::rename(from, to, failed);
  if (failed) {
    return Error{ErrorCode::kCannotWrite,
                 fmt::format("{}: cannot be put in place: {}", to.string(), failed.message())};
  }
  const int folder = ::open(to.parent_path().c_str(), O_RDONLY | O_CLOEXEC);
  if (folder >= 0) {
    (void)::fsync(folder);  // not every file system can; the file is whole either way
    ::close(folder);
  }
  return {};
}

Store::Store(fs::path output_root)
    : output_root_(std::move(output_root)), folder_(output_root_ / ".nacre") {}

fs::path Store::report_path(const Item& item) const { return state_file(folder_, "reports", item); }

std::optional<Record> Store::record(const Item& item) const {
  const Json json = read_object(state_file(folder_, "records", item), kRecordSchema);
  if (json.is_null()) return std::nullopt;
  return record_of(json);
}

bool Store::knows(const Item& item) const {
  std::error_code ignored;
  return fs::exists(state_file(folder_, "records", item), ignored);
}

std::optional<Failure> Store::failure(const Item& item) const {
  const Json json = read_object(state_file(folder_, "failures", item), kFailureSchema);
  if (json.is_null()) return std::nullopt;
  Failure failure;
  failure.key = text(json, "key");
  failure.attempts = number<int>(json, "attempts");
  failure.final = json.contains("final") && json["final"] == true;
  failure.exit_code = number<int>(json, "exit_code");
  failure.signal = number<int>(json, "signal");
  failure.message = text(json, "message");
  return failure;
}

Result<void> Store::write(const Item& item, const Record& record, const fs::path& work) const {
  return write_object(state_file(folder_, "records", item), to_json(record), work);
}

Result<void> Store::write(const Item& item, const Failure& failure, const fs::path& work) const {
  const Json json = {{"schema", kFailureSchema},       {"key", failure.key},
                     {"attempts", failure.attempts},   {"final", failure.final},
                     {"exit_code", failure.exit_code}, {"signal", failure.signal},
                     {"message", failure.message}};
  return write_object(state_file(folder_, "failures", item), json, work);
}

void Store::forget_failure(const Item& item) const {
  std::error_code ignored;
  fs::remove(state_file(folder_, "failures", item), ignored);
}

State state_of(const Store& store, const Manifest& manifest, const Item& item, bool verify,
               bool read_changed) {
  const fs::path scan = scan_path(manifest, item), output = output_path(manifest, item);
  // A scan that went missing has no stamp; its attempts are counted all the same.
  const std::optional<FileStamp> stamp = stamp_of(scan);
  const std::optional<Record> record = store.record(item);
  const std::optional<FileStamp> made = stamp_of(output);
  if (record && made && stamp && made->bytes == record->output_bytes) {
    const Result<std::string> output_hash = hash_file(output);
    bool same = output_hash && *output_hash == record->output_hash;
    std::string input_hash = record->input_hash;
    if (same && (verify || record->input != *stamp)) {
      same = verify || read_changed;
      const Result<std::string> hash = same ? hash_file(scan) : Result<std::string>(std::string());
      if (hash) input_hash = *hash;
    }
    if (same && record->key == content_key(input_hash, item.options)) return State::kDone;
  }
  const std::optional<Failure> failure = store.failure(item);
  if (failure && failure->final &&
      failure->key == failure_key(stamp.value_or(FileStamp{}), item.options)) {
    return State::kFailed;
  }
  return made && !store.knows(item) ? State::kForeign : State::kToDo;
}

}  // namespace nacre::app::batch
