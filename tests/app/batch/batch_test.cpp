// SPDX-License-Identifier: GPL-3.0-or-later
//
// Whole batches of tiny scans with the built command. Few tests with many expectations: it is the
// encodes that take the time.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <thread>

#include "run_command.h"

namespace nacre::app::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const std::vector<std::string> kCheap = {"--",       "--size", "2k",        "--levels", "2",
                                         "--effort", "fast",   "--samples", "1000"};

class Batches : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const {
    return scratch.file(name).string();
  }
  /// Tiny bodies that differ in shape, in two folders.
  void make_scans(int count) {
    fs::create_directories(scratch.file("in/sub"));
    for (int i = 0; i < count; ++i) {
      Scan scan = shapes::sphere(2);
      for (Vec3& p : scan.positions) p *= 1 + 0.05 * i * p[0] + 0.1 * std::sin(3 * p[1] + i);
      save(scratch, (i % 2 == 0 ? "in/a" : "in/sub/b") + std::to_string(i) + ".ply", scan);
    }
  }
  [[nodiscard]] std::vector<std::string> folder_command(
      const std::string& out, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = {"batch", path("in"), path(out)};
    words.insert(words.end(), more.begin(), more.end());
    words.insert(words.end(), kCheap.begin(), kCheap.end());
    return words;
  }
  /// What a batch is for: every file but the summaries, which hold times, by its path.
  [[nodiscard]] std::map<std::string, std::string> outputs(const std::string& out) const {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(scratch.file(out))) {
      const std::string name = fs::relative(entry.path(), scratch.file(out)).string();
      if (!entry.is_regular_file() || name.starts_with(".nacre/")) continue;
      files[name] = name.starts_with("summary.") ? "" : scratch.read(out + "/" + name);
    }
    return files;
  }
  [[nodiscard]] json summary(const std::string& out) const {
    return json::parse(scratch.read(out + "/summary.json"), nullptr, false);
  }
  [[nodiscard]] std::vector<json> failures(const std::string& out) const {
    std::vector<json> lines;
    std::istringstream in(scratch.read(out + "/failed.jsonl"));
    for (std::string line; std::getline(in, line);) lines.push_back(json::parse(line));
    return lines;
  }
  static std::size_t count_of(const std::string& text, const std::string& what) {
    std::size_t n = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1))
      ++n;
    return n;
  }
  Scratch scratch;
};

TEST_F(Batches, OneLineEncodesAFolderAndDoesOnlyWhatIsMissingTheNextTime) {
  make_scans(2);
  scratch.write("in/broken.ply", "ply\nformat ascii 1.0\nelement vertex 3\n");
  scratch.write("in/sub/flat.off", "OFF\n3 1 0\n0 0 0\n0 0 0\n0 0 0\n3 0 1 2\n");
  const Outcome first = run(folder_command("out", {"--jobs", "2"}));
  EXPECT_EQ(first.exit_code, 8) << first.err;
  EXPECT_EQ(first.out, "");
  const auto made = outputs("out");
  for (const char* name :
       {"a0.ncr", "sub/b1.ncr", "summary.html", "summary.csv", "summary.json", "failed.jsonl"}) {
    EXPECT_TRUE(made.contains(name)) << name;
  }
  EXPECT_EQ(made.size(), 6u);
  EXPECT_TRUE(fs::is_empty(scratch.file("out/.nacre/work")));

  // The same as the command gives, and the records' figures are its report's.
  std::vector<std::string> encode = {"encode", path("in/sub/b1.ply"), "-o", path("b1.ncr")};
  encode.insert(encode.end(), kCheap.begin() + 1, kCheap.end());
  ASSERT_EQ(run(encode).exit_code, 0);
  EXPECT_EQ(scratch.read("b1.ncr"), made.at("sub/b1.ncr"));
  const json report = json::parse(scratch.read("out/.nacre/reports/sub/b1.ncr.json"));
  const json all = summary("out");
  EXPECT_EQ(all["totals"]["done"], 2);
  EXPECT_EQ(all["totals"]["failed"], 2);
  for (const json& row : all["scans"]) {
    if (row["scan"] != "sub/b1.ply") continue;
    EXPECT_EQ(row["psnr_db"], report["psnr_db"]);
    EXPECT_EQ(row["bytes"], made.at("sub/b1.ncr").size());
    EXPECT_EQ(row["faces"], 128);
    EXPECT_GT(row["peak_bytes"], 1'000'000);
  }
  EXPECT_EQ(count_of(scratch.read("out/summary.html"), "data:image/png"), 2u);

  const auto failed = failures("out");
  ASSERT_EQ(failed.size(), 2u);
  EXPECT_EQ(failed[0]["scan"], "broken.ply");
  EXPECT_EQ(failed[0]["exit_code"], 3);
  EXPECT_EQ(failed[0]["attempts"], 3) << "a file can be unreadable for a moment";
  EXPECT_EQ(failed[1]["scan"], "sub/flat.off");
  EXPECT_EQ(failed[1]["exit_code"], 4);
  EXPECT_NE(failed[1]["message"].get<std::string>().find("flat.off"), std::string::npos);

  // Again: nothing to do. One scan changed: that one. Another one repaired: that one too.
  const Outcome second = run(folder_command("out"));
  EXPECT_EQ(second.exit_code, 8);
  EXPECT_EQ(count_of(second.err, "PSNR"), 0u) << second.err;
  EXPECT_EQ(outputs("out"), made);
  save(scratch, "in/a0.ply", shapes::sphere(1));
  save(scratch, "in/broken.ply", shapes::icosahedron());
  fs::remove(scratch.file("in/sub/flat.off"));
  const Outcome third = run(folder_command("out"));
  EXPECT_EQ(third.exit_code, 0) << third.err;
  EXPECT_EQ(count_of(third.err, "PSNR"), 2u) << third.err;
  EXPECT_NE(outputs("out").at("a0.ncr"), made.at("a0.ncr"));
  EXPECT_EQ(outputs("out").at("failed.jsonl"), "");
}

TEST_F(Batches, ShardsTogetherMakeWhatOneRunMakes) {
  make_scans(2);
  ASSERT_EQ(run(folder_command("whole", {"-q"})).exit_code, 0);
  std::vector<std::string> plan = {"batch",         "plan",         path("in"),    "-o",
                                   path("m.jsonl"), "--output-dir", path("parts"), "-q"};
  plan.insert(plan.end(), kCheap.begin(), kCheap.end());
  ASSERT_EQ(run(plan).exit_code, 0);
  EXPECT_EQ(run(plan).exit_code, 2) << "the manifest exists already";
  // One shard twice at once, as after a lost node.
  Running twin({"batch", "run", path("m.jsonl"), "--shard", "1/2", "-q"});
  EXPECT_EQ(run({"batch", "run", path("m.jsonl"), "--shard", "1/2", "-q"}).exit_code, 0);
  EXPECT_EQ(twin.wait().exit_code, 0);
  const Outcome half = run({"batch", "status", path("m.jsonl"), "--json"});
  const json status = json::parse(half.out, nullptr, false);
  EXPECT_EQ(status["done"].get<int>() + status["missing"].get<int>(), 2) << half.out;
  EXPECT_GT(status["missing"], 0);
  EXPECT_EQ(run({"batch", "merge", path("m.jsonl"), "-q"}).exit_code, 8) << "some are missing";
  EXPECT_EQ(run({"batch", "run", path("m.jsonl"), "--shard", "0/2", "-q"}).exit_code, 0);
  EXPECT_EQ(run({"batch", "merge", path("m.jsonl"), "-q"}).exit_code, 0);
  EXPECT_EQ(outputs("parts"), outputs("whole"));
  EXPECT_EQ(run({"batch", "status", path("m.jsonl")}).out.find("2 scans: 2 done"), 0u);
}

TEST_F(Batches, ForeignOutputsAreNotOverwritten) {
  make_scans(2);
  fs::create_directories(scratch.file("out"));
  scratch.write("out/a0.ncr", "mine");
  const Outcome refused = run(folder_command("out"));
  EXPECT_EQ(refused.exit_code, 8);
  EXPECT_NE(refused.err.find("a0.ncr: exists already"), std::string::npos) << refused.err;
  EXPECT_EQ(scratch.read("out/a0.ncr"), "mine");
  EXPECT_TRUE(scratch.has("out/sub/b1.ncr")) << "the others go on";
  EXPECT_EQ(failures("out")[0]["state"], "foreign");
  EXPECT_EQ(run(folder_command("out", {"-f", "-q"})).exit_code, 0);
  EXPECT_NE(scratch.read("out/a0.ncr"), "mine");
}

TEST_F(Batches, StoppedOrKilledAtAnyMomentItEndsLikeAnUndisturbedRun) {
  make_scans(4);
  scratch.write("in/broken.ply", "ply\nformat ascii 1.0\nelement vertex 3\n");
  ASSERT_EQ(run(folder_command("whole", {"-q"})).exit_code, 8);
  const auto whole = outputs("whole");
  const auto expect_whole_so_far = [&] {
    for (const auto& [name, bytes] : outputs("out")) {
      if (!name.ends_with(".ncr")) continue;
      EXPECT_EQ(bytes, whole.at(name)) << name;
    }
  };
  Running stopped(folder_command("out", {"--jobs", "1"}));
  while (!fs::exists(scratch.file("out/.nacre/records"))) usleep(2000);
  stopped.interrupt();
  EXPECT_EQ(stopped.wait().exit_code, 75);
  EXPECT_TRUE(fs::is_empty(scratch.file("out/.nacre/work"))) << "nothing half-made is left";
  expect_whole_so_far();

  std::mt19937 random(11);
  int kills = 0;
  for (int round = 0; round < 6; ++round) {
    Running batch(folder_command("out", {"-q"}));
    std::this_thread::sleep_for(std::chrono::milliseconds(20 + random() % 500));
    if (!batch.kill_hard()) break;
    ++kills;
    expect_whole_so_far();
  }
  EXPECT_GT(kills, 0);
  EXPECT_EQ(run(folder_command("out", {"-q"})).exit_code, 8);
  EXPECT_EQ(outputs("out"), whole);
}

TEST_F(Batches, LimitsFailWithSix) {
  make_scans(1);
  const Outcome small = run(folder_command("small", {"--max-memory", "8M"}));
  EXPECT_EQ(small.exit_code, 8) << small.err;
  ASSERT_EQ(failures("small").size(), 1u);
  EXPECT_EQ(failures("small")[0]["exit_code"], 6);
  EXPECT_NE(failures("small")[0]["message"].get<std::string>().find("--max-memory"),
            std::string::npos);
  EXPECT_EQ(run(folder_command("slow", {"--timeout", "0.001", "-q"})).exit_code, 8);
  EXPECT_EQ(failures("slow")[0]["exit_code"], 6);
  EXPECT_EQ(run(folder_command("slow", {"-q"})).exit_code, 8) << "it was given up";
  EXPECT_EQ(run(folder_command("slow", {"--retry-failed", "-q"})).exit_code, 0);
}

TEST_F(Batches, WrongUsageIsTwoAndWrongFilesThree) {
  make_scans(1);
  const auto refused = [&](int code, const std::string& named,
                           const std::vector<std::string>& words) {
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.exit_code, code) << outcome.err;
    EXPECT_NE(outcome.err.find(named), std::string::npos) << outcome.err;
    EXPECT_EQ(count_of(outcome.err, "\n"), 1u) << outcome.err;
  };
  refused(2, "batch IN OUT", {"batch"});
  refused(2, "batch IN OUT", {"batch", path("in")});
  refused(2, "--shard '2/2'", {"batch", "run", path("m"), "--shard", "2/2"});
  refused(2, "--shard '1'", {"batch", "run", path("m"), "--shard", "1"});
  refused(2, "--max-memory", {"batch", "run", path("m"), "--max-memory", "lots"});
  refused(2, "--sise", {"batch", path("in"), path("out"), "--", "--sise", "6k"});
  refused(2, "--output", {"batch", path("in"), path("out"), "--", "--output", "x.ncr"});
  refused(2, "after --", {"batch", "run", path("m"), "--", "--size", "6k"});
  refused(2, "--rule", {"batch", path("in"), path("out"), "--rule", "x"});
  refused(3, "none", {"batch", path("none"), path("out")});
  refused(3, "none", {"batch", "run", path("none")});
  refused(3, "a0.ply", {"batch", "status", path("in/a0.ply")});
  EXPECT_FALSE(scratch.has("out"));
  EXPECT_NE(run({"batch", "--help"}).out.find("nacre batch sbatch"), std::string::npos);
  EXPECT_NE(run({"batch", "run", "--help"}).out.find("--shard"), std::string::npos);
}

TEST_F(Batches, SbatchPrintsAScriptThatTheShellReads) {
  make_scans(3);
  fs::rename(scratch.file("in"), scratch.file("it's in"));
  ASSERT_EQ(run({"batch", "plan", path("it's in"), "-o", path("it's m.jsonl"), "-q"}).exit_code, 0);
  const Outcome printed = run({"batch", "sbatch", path("it's m.jsonl"), "--shards", "2"});
  EXPECT_EQ(printed.exit_code, 0);
  EXPECT_NE(printed.out.find("#SBATCH --array=0-1\n"), std::string::npos) << printed.out;
  scratch.write("array.sh", printed.out + "\n");
  EXPECT_EQ(std::system(("bash -n '" + path("array.sh") + "'").c_str()), 0);
  // Run as Slurm would.
  const std::string as_slurm =
      "SLURM_ARRAY_TASK_ID=1 SLURM_ARRAY_TASK_COUNT=2 "
      "SLURM_CPUS_PER_TASK=1 SLURM_ARRAY_JOB_ID=1 bash '" +
      path("array.sh") + "' 2>/dev/null";
  EXPECT_EQ(std::system(as_slurm.c_str()), 0);
  const json status = json::parse(run({"batch", "status", path("it's m.jsonl"), "--json"}).out);
  EXPECT_EQ(status["done"], 1) << "of three equal scans the second shard has one";
}

}  // namespace
}  // namespace nacre::app::test
