// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/batch/manifest.h"
#include "app/batch/record.h"

/// What a batch did, as JSON, CSV and a page, failures first.
namespace nacre::app::batch {

struct Row {
  Item item;
  State state = State::kToDo;
  std::optional<Record> record;    ///< of a scan that is done
  std::optional<Failure> failure;  ///< of one that is not and was tried
};

struct Totals {
  std::size_t scans = 0, done = 0, failed = 0, foreign = 0, missing = 0;
  /// Of the scans that are done.
  std::uint64_t input_bytes = 0, output_bytes = 0, faces = 0, peak_bytes = 0;
  double seconds = 0, cpu_seconds = 0;
};

/// All items as the output folder has them: given up, in the way, not made, then done; each in the
/// manifest's order.
[[nodiscard]] std::vector<Row> collect(const Manifest& manifest, const Store& store, bool verify);
[[nodiscard]] Totals totals_of(const std::vector<Row>& rows);

[[nodiscard]] std::string_view name_of(State state);  ///< "done", "failed", "foreign", "missing"
/// Why a scan is not done; empty if it is.
[[nodiscard]] std::string reason(const Row& row);
[[nodiscard]] std::string describe_cleaning(const Record& record);

[[nodiscard]] std::string summary_json(const std::vector<Row>& rows);
[[nodiscard]] std::string summary_csv(const std::vector<Row>& rows);   ///< RFC 4180
[[nodiscard]] std::string summary_html(const std::vector<Row>& rows);  ///< one file, no network
/// One JSON line per scan that is not done, without anything that depends on time or machine; empty
/// if all are.
[[nodiscard]] std::string failed_json_lines(const std::vector<Row>& rows);

}  // namespace nacre::app::batch
