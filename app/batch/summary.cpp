// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/batch/summary.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "app/exit_code.h"
#include "app/json.h"
#include "app/sizes.h"

namespace nacre::app::batch {
namespace {

constexpr const char* kSchema = "nacre-batch-summary/0";

/// Failures first.
int rank(State state) {
  switch (state) {
    case State::kFailed:
      return 0;
    case State::kForeign:
      return 1;
    case State::kToDo:
      return 2;
    case State::kDone:
      break;
  }
  return 3;
}

Json maybe(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

double ratio(double before, double after) { return after > 0 ? before / after : 0; }

/// Why it is not done, the same for every run that ends in the same way.
Json failure_json(const Row& row) {
  Json json = {{"scan", row.item.scan}, {"output", row.item.output}, {"state", name_of(row.state)}};
  json["exit_code"] = nullptr;
  if (row.state == State::kForeign) json["exit_code"] = int{kExitUsage};
  if (row.failure) {
    json["exit_code"] = row.failure->exit_code;
    if (row.failure->signal != 0) json["signal"] = row.failure->signal;
    json["attempts"] = row.failure->attempts;
  }
  json["message"] = reason(row);
  return json;
}

Json row_json(const Row& row) {
  if (!row.record) return failure_json(row);
  const Record& r = *row.record;
  Json cleaning = Json::object();
  for (const auto& [kind, count] : r.cleaning) cleaning[kind] = count;
  return {{"scan", row.item.scan},
          {"output", row.item.output},
          {"state", name_of(row.state)},
          {"options", row.item.options},
          {"input_bytes", r.input.bytes},
          {"input_xxh3_128", r.input_hash},
          {"vertices", r.vertices},
          {"faces", r.faces},
          {"bytes", r.output_bytes},
          {"xxh3_128", r.output_hash},
          {"ratio", ratio(static_cast<double>(r.input.bytes), static_cast<double>(r.output_bytes))},
          {"bits_per_input_vertex", maybe(r.bits_per_input_vertex)},
          {"psnr_db", maybe(r.psnr_db)},
          {"max_error", maybe(r.max_error)},
          {"max_error_percent", maybe(r.max_error_percent)},
          {"clean", std::move(cleaning)},
          {"fallbacks", r.fallbacks},
          {"seconds", r.seconds},
          {"cpu_seconds", r.cpu_seconds},
          {"peak_bytes", r.peak_bytes},
          {"threads", r.threads},
          {"host", r.host}};
}

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string csv_number(const std::optional<double>& value) {
  return value ? fmt::format("{}", *value) : "";
}

}  // namespace

std::vector<Row> collect(const Manifest& manifest, const Store& store, bool verify) {
  std::vector<Row> rows;
  for (const Item& item : manifest.items) {
    Row row;
    row.item = item;
    row.state = state_of(store, manifest, item, verify, true);
    if (row.state == State::kDone) {
      row.record = store.record(item);
    } else {
      row.failure = store.failure(item);
    }
    rows.push_back(std::move(row));
  }
  std::ranges::stable_sort(rows, {}, [](const Row& row) { return rank(row.state); });
  return rows;
}

Totals totals_of(const std::vector<Row>& rows) {
  Totals totals;
  totals.scans = rows.size();
  for (const Row& row : rows) {
    if (row.state == State::kFailed) ++totals.failed;
    if (row.state == State::kForeign) ++totals.foreign;
    if (row.state == State::kToDo) ++totals.missing;
    if (row.state == State::kDone) ++totals.done;
    if (!row.record) continue;
    totals.input_bytes += row.record->input.bytes;
    totals.output_bytes += row.record->output_bytes;
    totals.faces += row.record->faces;
    totals.peak_bytes = std::max(totals.peak_bytes, row.record->peak_bytes);
    totals.seconds += row.record->seconds;
    totals.cpu_seconds += row.record->cpu_seconds;
  }
  return totals;
}

std::string_view name_of(State state) {
  switch (state) {
    case State::kDone:
      return "done";
    case State::kFailed:
      return "failed";
    case State::kForeign:
      return "foreign";
    case State::kToDo:
      break;
  }
  return "missing";
}

std::string reason(const Row& row) {
  if (row.state == State::kDone) return {};
  if (row.state == State::kForeign) return "a file of this name was made by no batch; see -f";
  if (row.failure) return row.failure->message;
  return "not encoded yet; run the batch";
}

std::string describe_cleaning(const Record& record) {
  std::string text;
  for (const auto& [kind, count] : record.cleaning) {
    text += fmt::format("{}{} {}", text.empty() ? "" : "; ", format_count(count), kind);
  }
  return text;
}

std::string summary_json(const std::vector<Row>& rows) {
  const Totals t = totals_of(rows);
  Json list = Json::array();
  for (const Row& row : rows) list.push_back(row_json(row));
  const Json json = {
      {"schema", kSchema},
      {"nacre", codec_version()},
      {"totals",
       {{"scans", t.scans},
        {"done", t.done},
        {"failed", t.failed},
        {"foreign", t.foreign},
        {"missing", t.missing},
        {"input_bytes", t.input_bytes},
        {"bytes", t.output_bytes},
        {"ratio", ratio(static_cast<double>(t.input_bytes), static_cast<double>(t.output_bytes))},
        {"faces", t.faces},
        {"seconds", t.seconds},
        {"cpu_seconds", t.cpu_seconds},
        {"peak_bytes", t.peak_bytes}}},
      {"scans", std::move(list)}};
  return dump_json(json);
}

std::string summary_csv(const std::vector<Row>& rows) {
  std::string text =
      "scan,output,state,exit_code,attempts,message,vertices,faces,input_bytes,bytes,ratio,"
      "bits_per_input_vertex,psnr_db,max_error,max_error_percent,cleaning,fallbacks,seconds,"
      "cpu_seconds,peak_bytes,threads,host,options\r\n";
  for (const Row& row : rows) {
    std::vector<std::string> fields = {row.item.scan, row.item.output,
                                       std::string(name_of(row.state))};
    if (row.failure) {
      fields.push_back(std::to_string(row.failure->exit_code));
      fields.push_back(std::to_string(row.failure->attempts));
    } else {
      fields.insert(fields.end(), 2, "");
    }
    fields.push_back(reason(row));
    if (row.record) {
      const Record& r = *row.record;
      const double input = static_cast<double>(r.input.bytes);
      fields.insert(
          fields.end(),
          {std::to_string(r.vertices), std::to_string(r.faces), std::to_string(r.input.bytes),
           std::to_string(r.output_bytes),
           fmt::format("{:.3f}", ratio(input, static_cast<double>(r.output_bytes))),
           csv_number(r.bits_per_input_vertex), csv_number(r.psnr_db), csv_number(r.max_error),
           csv_number(r.max_error_percent), describe_cleaning(r), std::to_string(r.fallbacks),
           fmt::format("{:.3f}", r.seconds), fmt::format("{:.3f}", r.cpu_seconds),
           std::to_string(r.peak_bytes), std::to_string(r.threads), r.host});
    } else {
      fields.insert(fields.end(), 16, "");
    }
    fields.push_back(fmt::format("{}", fmt::join(row.item.options, " ")));
    for (std::size_t i = 0; i < fields.size(); ++i) {
      if (i > 0) text += ',';
      text += csv_field(fields[i]);
    }
    text += "\r\n";
  }
  return text;
}

std::string failed_json_lines(const std::vector<Row>& rows) {
  std::string text;
  for (const Row& row : rows) {
    if (row.state == State::kDone) continue;
    text += failure_json(row).dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
  }
  return text;
}

}  // namespace nacre::app::batch
