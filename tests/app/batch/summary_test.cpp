// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/batch/summary.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

namespace nacre::app::batch {
namespace {

using nlohmann::json;

std::vector<Row> rows() {
  Row failed;
  failed.item = {"bad <1>.ply", "bad <1>.ncr", {"--size", "6k"}, 10, 1, true};
  failed.state = State::kFailed;
  failed.failure = Failure{"k", 3, true, 4, 0, "is \"flat\", refused"};
  Row missing;
  missing.item = {"late.ply", "late.ncr", {}, 10, 1, true};
  Row done;
  done.item = {"a,b.ply", "a,b.ncr", {}, 1000, 20, true};
  done.state = State::kDone;
  Record record;
  record.input.bytes = 1000;
  record.output_bytes = 50;
  record.faces = 20;
  record.psnr_db = 71.25;
  record.cleaning = {{"welded vertices", 1204}, {"dropped degenerate faces", 2}};
  record.seconds = 1.5;
  record.peak_bytes = 77;
  record.thumbnail = "QUJD";
  done.record = record;
  return {failed, missing, done};
}

/// RFC 4180, the other way round.
std::vector<std::vector<std::string>> read_csv(const std::string& text) {
  std::vector<std::vector<std::string>> lines(1, {""});
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') {
      if (quoted && i + 1 < text.size() && text[i + 1] == '"') {
        lines.back().back() += text[++i];
      } else {
        quoted = !quoted;
      }
    } else if (!quoted && c == ',') {
      lines.back().emplace_back();
    } else if (!quoted && c == '\n') {
      lines.push_back({""});
    } else if (quoted || c != '\r') {
      lines.back().back() += c;
    }
  }
  lines.pop_back();
  return lines;
}

TEST(Summary, JsonHasTotalsAndEveryScan) {
  const json summary = json::parse(summary_json(rows()));
  EXPECT_EQ(summary["totals"]["scans"], 3);
  EXPECT_EQ(summary["totals"]["done"], 1);
  EXPECT_EQ(summary["totals"]["failed"], 1);
  EXPECT_EQ(summary["totals"]["missing"], 1);
  EXPECT_EQ(summary["totals"]["ratio"], 20.0);
  ASSERT_EQ(summary["scans"].size(), 3u);
  EXPECT_EQ(summary["scans"][0]["state"], "failed");
  EXPECT_EQ(summary["scans"][0]["exit_code"], 4);
  EXPECT_EQ(summary["scans"][0]["attempts"], 3);
  EXPECT_EQ(summary["scans"][2]["clean"]["welded vertices"], 1204);
  EXPECT_EQ(summary["scans"][2]["psnr_db"], 71.25);
  EXPECT_TRUE(summary["scans"][2]["max_error"].is_null());
}

TEST(Summary, CsvReadsBack) {
  const auto lines = read_csv(summary_csv(rows()));
  ASSERT_EQ(lines.size(), 4u);
  for (const auto& line : lines) EXPECT_EQ(line.size(), lines[0].size());
  const auto column = [&](const char* name) {
    return static_cast<std::size_t>(std::ranges::find(lines[0], name) - lines[0].begin());
  };
  EXPECT_EQ(lines[1][column("message")], "is \"flat\", refused");
  EXPECT_EQ(lines[1][column("options")], "--size 6k");
  EXPECT_EQ(lines[3][column("scan")], "a,b.ply");
  EXPECT_EQ(lines[3][column("psnr_db")], "71.25");
  EXPECT_EQ(lines[3][column("ratio")], "20.000");
  EXPECT_EQ(lines[3][column("cleaning")], "1,204 welded vertices; 2 dropped degenerate faces");
}

TEST(Summary, FailuresSayWhyAndNothingThatChangesFromRunToRun) {
  std::istringstream in(failed_json_lines(rows()));
  std::vector<json> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(json::parse(line));
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0]["scan"], "bad <1>.ply");
  EXPECT_EQ(lines[0]["exit_code"], 4);
  EXPECT_EQ(lines[0]["message"], "is \"flat\", refused");
  EXPECT_EQ(lines[1]["state"], "missing");
  EXPECT_TRUE(lines[1]["exit_code"].is_null());
  EXPECT_EQ(failed_json_lines({rows()[2]}), "");
}

TEST(Summary, PageIsSelfContainedAndEscapesNames) {
  const std::string page = summary_html(rows());
  EXPECT_EQ(page.find("bad <1>"), std::string::npos);
  EXPECT_NE(page.find("bad &lt;1&gt;.ply"), std::string::npos);
  EXPECT_NE(page.find("data:image/png;base64,QUJD"), std::string::npos);
  EXPECT_EQ(page.find("http"), std::string::npos) << "nothing is fetched";
  EXPECT_LT(page.find("bad &lt;1"), page.find("late.ply")) << "failures first";
  EXPECT_LT(page.find("late.ply"), page.find("a,b.ply"));
  // Every row has a cell below every head.
  const auto count = [](std::string_view text, std::string_view what) {
    std::size_t n = 0;
    for (std::size_t at = text.find(what); at != std::string_view::npos;
         at = text.find(what, at + 1)) {
      ++n;
    }
    return n;
  };
  EXPECT_EQ(count(page, "<td"), 3 * count(page, "<th>") + 3 * count(page, "<th "));
}

TEST(Summary, PageStaysTextWhereNamesAreNone) {
  std::vector<Row> one = {rows().front()};
  one[0].item.scan = "x\xFF'.ply";
  EXPECT_NE(summary_html(one).find("x\xEF\xBF\xBD&#39;.ply"), std::string::npos);
}

}  // namespace
}  // namespace nacre::app::batch
