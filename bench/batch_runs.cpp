// SPDX-License-Identifier: GPL-3.0-or-later
//
// What `nacre batch` claims, each by a subcommand on scans that are made here: killing it loses and
// changes nothing, it keeps the processors busy, it stays below its memory, it costs little itself.
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <span>
#include <sstream>
#include <thread>

#include "base/topology.h"
#include "bench/support.h"
#include "io/write.h"

namespace nacre::bench {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct Settings {
  std::string nacre = NACRE_COMMAND, folder;
  int scans = 300, kills = 20, jobs = 0;
  unsigned seed = 1;
  bool corpus = true;
  std::string max_memory = "4G", options = "--size 2k --effort fast --samples 1000";
};

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

// --- scans
// ------------------------------------------------------------------------------------------

/// A torus of about so many triangles with waves on it; every seed another.
Scan wavy_torus(std::size_t triangles, unsigned seed) {
  std::mt19937 random(seed);
  const auto wave = [&] { return static_cast<double>(1 + random() % 6); };
  const double a = wave(), b = wave(), c = wave(), d = wave();
  const auto n = static_cast<std::uint32_t>(std::sqrt(static_cast<double>(triangles)));
  const auto m = static_cast<std::uint32_t>(std::max<std::size_t>(3, triangles / 2 / n));
  Scan scan;
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t k = 0; k < m; ++k) {
      const double u = 2 * M_PI * i / n, v = 2 * M_PI * k / m;
      const double minor = 0.4 + 0.04 * std::sin(a * u + b * v) + 0.02 * std::cos(c * u - d * v);
      const double r = 1 + minor * std::cos(v);
      scan.positions.emplace_back(r * std::cos(u), r * std::sin(u), minor * std::sin(v));
    }
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t k = 0; k < m; ++k) {
      const std::uint32_t i1 = (i + 1) % n, k1 = (k + 1) % m;
      scan.triangles.push_back({i * m + k, i1 * m + k, i1 * m + k1});
      scan.triangles.push_back({i * m + k, i1 * m + k1, i * m + k1});
    }
  }
  return scan;
}

void write_bytes(const fs::path& file, std::span<const std::uint8_t> bytes) {
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

std::vector<std::uint8_t> bytes_of(const Scan& scan, const fs::path& file) {
  const auto format = io::mesh_format(file);
  auto bytes = io::serialize_mesh(scan, format.value());
  return std::move(bytes).value();
}

void write_scan(const fs::path& file, std::size_t triangles, unsigned seed) {
  fs::create_directories(file.parent_path());
  write_bytes(file, bytes_of(wavy_torus(triangles, seed), file));
}

/// One of the ways in which a file of an archive is no scan.
void write_broken(const fs::path& folder, int kind, unsigned seed) {
  fs::create_directories(folder);
  const fs::path file = folder / fmt::format("broken-{}-{}.ply", kind, seed);
  std::vector<std::uint8_t> bytes = bytes_of(wavy_torus(400, seed), file);
  switch (kind % 4) {
    case 0:  // cut short
      bytes.resize(bytes.size() / 2);
      break;
    case 1:  // not a number
      std::fill(bytes.end() - 400 * 13 - 40, bytes.end() - 400 * 13, std::uint8_t{0xff});
      break;
    case 2:  // empty
      bytes.clear();
      break;
    default:  // flat to a point
      bytes = bytes_of({{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, {{0, 1, 2}}}, file);
  }
  write_bytes(file, bytes);
}

/// A mixed archive: most of 1k to 5k triangles, a few up to 1M, broken ones, the corpus if wanted.
void make_archive(const Settings& settings, const fs::path& folder) {
  int made = 0;
  if (settings.corpus) {
    fs::create_directories(folder / "corpus");
    for (const std::string& mesh : corpus_meshes()) {
      fs::copy(mesh, folder / "corpus", fs::copy_options::skip_existing);
      ++made;
    }
  }
  const std::vector<std::string> endings = {"ply", "off", "obj", "stl"};
  std::mt19937 random(settings.seed);
  for (int i = 0; made < settings.scans; ++i, ++made) {
    const auto seed = static_cast<unsigned>(i);
    if (i % 15 == 7) {
      write_broken(folder / "broken", i / 15, seed);
      continue;
    }
    std::size_t triangles = 1000 + random() % 4000;
    if (i % 50 == 25) triangles = 20'000 + random() % 80'000;
    if (i == 100) triangles = 1'000'000;
    write_scan(folder / fmt::format("box{}/scan{}.{}", i / 40, i, endings[i % endings.size()]),
               triangles, seed);
  }
}

// --- runs
// -------------------------------------------------------------------------------------------

struct BatchRun {
  int exit_code = -1;
  bool killed = false;
  double seconds = 0;
  std::uint64_t peak_bytes = 0;  ///< of it and its children, sampled
};

std::uint64_t resident_bytes_of_group(pid_t leader) {
  std::uint64_t bytes = 0;
  const auto add = [&](pid_t pid) {
    std::ifstream in(fmt::format("/proc/{}/statm", pid));
    std::uint64_t total = 0, resident = 0;
    if (in >> total >> resident) bytes += resident * static_cast<std::uint64_t>(getpagesize());
  };
  add(leader);
  std::ifstream children(fmt::format("/proc/{0}/task/{0}/children", leader));
  for (pid_t pid = 0; children >> pid;) add(pid);
  return bytes;
}

/// Runs the batch over `in`; with `kill_after` it gets SIGKILL then.
BatchRun run_batch(const Settings& settings, const fs::path& in, const fs::path& out,
                   double kill_after, const std::vector<std::string>& more) {
  std::vector<std::string> words = {settings.nacre, "batch", in, out, "-q"};
  words.insert(words.end(), more.begin(), more.end());
  if (settings.jobs > 0) words.insert(words.end(), {"--jobs", std::to_string(settings.jobs)});
  words.emplace_back("--");
  for (const std::string& word : words_of(settings.options)) words.push_back(word);
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  const Clock::time_point begin = Clock::now();
  const pid_t pid = fork();
  if (pid < 0) throw std::runtime_error("fork failed");
  if (pid == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    execv(argv[0], argv.data());
    _exit(127);
  }
  BatchRun run;
  int status = 0;
  while (waitpid(pid, &status, WNOHANG) == 0) {
    run.peak_bytes = std::max(run.peak_bytes, resident_bytes_of_group(pid));
    if (kill_after > 0 && seconds_since(begin) > kill_after) kill(pid, SIGKILL);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  run.seconds = seconds_since(begin);
  run.killed = WIFSIGNALED(status);
  if (WIFEXITED(status)) run.exit_code = WEXITSTATUS(status);
  return run;
}

/// Every file that a batch is for, and failed.jsonl; not the summaries, which hold times.
std::map<std::string, std::vector<std::uint8_t>> outputs(const fs::path& folder) {
  std::map<std::string, std::vector<std::uint8_t>> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = fs::relative(entry.path(), folder).string();
    if (!entry.is_regular_file() || name.starts_with(".nacre/") || name.starts_with("summary.")) {
      continue;
    }
    files[name] = io::read_file(entry.path()).value();
  }
  return files;
}

int bench_kill(const Settings& settings, const fs::path& folder) {
  make_archive(settings, folder / "in");
  const BatchRun whole = run_batch(settings, folder / "in", folder / "whole", 0, {});
  fmt::print("undisturbed: {} scans, {:.0f} s, exit code {}\n", settings.scans, whole.seconds,
             whole.exit_code);
  std::mt19937 random(settings.seed);
  int killed = 0;
  double spent = 0;
  // Spread over the whole run: each attempt lives for about its share of the time.
  std::uniform_real_distribution<double> life(0.02, 2 * whole.seconds / (settings.kills + 1));
  while (killed < settings.kills) {
    const BatchRun run = run_batch(settings, folder / "in", folder / "out", life(random), {});
    spent += run.seconds;
    if (!run.killed) break;
    ++killed;
  }
  const BatchRun last = run_batch(settings, folder / "in", folder / "out", 0, {});
  const auto expected = outputs(folder / "whole"), found = outputs(folder / "out");
  const bool same = expected == found;
  const auto left = fs::directory_iterator(folder / "out/.nacre/work");
  fmt::print("killed {} times, then finished: {:.0f} s in all, exit code {}; {} files, {}; {}\n",
             killed, spent + last.seconds, last.exit_code, found.size(),
             same ? "all bit for bit the same" : "DIFFERENT",
             left == fs::directory_iterator() ? "nothing left behind" : "WORK FILES LEFT");
  return same && last.exit_code == whole.exit_code ? 0 : 1;
}

int bench_speed(const Settings& settings, const fs::path& folder) {
  std::mt19937 random(settings.seed);
  double single = 0;
  fs::create_directories(folder / "single");
  for (int i = 0; i < settings.scans; ++i) {
    const fs::path scan = folder / "in" / fmt::format("scan{}.ply", i);
    write_scan(scan, 20'000 + random() % 80'000, static_cast<unsigned>(i));
    const std::string name = folder / "single" / fmt::format("scan{}", i);
    std::vector<std::string> words = {
        settings.nacre, "encode",       scan,        "-o", name + ".ncr",
        "--report",     name + ".json", "--threads", "1",  "-q"};
    for (const std::string& word : words_of(settings.options)) words.push_back(word);
    const ChildRun run = run_child(words, 3600);
    if (!run.ok()) throw std::runtime_error(run.outcome());
    single += run.seconds;
  }
  const BatchRun batch = run_batch(settings, folder / "in", folder / "out", 0, {});
  const int threads = static_cast<int>(std::thread::hardware_concurrency());
  fmt::print(
      "{} scans one after another with one thread: {:.1f} s; batch on {} processors: {:.1f} "
      "s = {:.2f} x (sum / {})\n",
      settings.scans, single, threads, batch.seconds, batch.seconds / (single / threads), threads);
  return batch.exit_code;
}

int bench_memory(const Settings& settings, const fs::path& folder) {
  std::mt19937 random(settings.seed);
  const int huge = std::min(settings.scans, 3);
  for (int i = 0; i < settings.scans; ++i) {
    write_scan(folder / "in" / fmt::format("scan{}.ply", i),
               i < huge ? 1'000'000 : 1000 + random() % 30'000, static_cast<unsigned>(i));
  }
  const BatchRun run =
      run_batch(settings, folder / "in", folder / "out", 0, {"--max-memory", settings.max_memory});
  fmt::print(
      "{} scans, {} of 1M triangles, --max-memory {}: peak {:.0f} MB, {:.0f} s, exit code "
      "{}\n",
      settings.scans, huge, settings.max_memory, static_cast<double>(run.peak_bytes) / 1e6,
      run.seconds, run.exit_code);
  return run.exit_code;
}

/// Processor time is not counted but wall time with one scan at a time, each with one thread.
int bench_overhead(const Settings& settings, const fs::path& folder) {
  double single = 0;
  fs::create_directories(folder / "single");
  for (int i = 0; i < settings.scans; ++i) {
    const fs::path scan = folder / "in" / fmt::format("scan{}.ply", i);
    write_scan(scan, 1000, static_cast<unsigned>(i));
    const std::string name = folder / "single" / fmt::format("scan{}", i);
    std::vector<std::string> words = {
        settings.nacre, "encode",       scan,        "-o", name + ".ncr",
        "--report",     name + ".json", "--threads", "1",  "-q"};
    for (const std::string& word : words_of(settings.options)) words.push_back(word);
    single += run_child(words, 3600).seconds;
  }
  Settings one = settings;
  one.jobs = 1;
  const BatchRun batch = run_batch(one, folder / "in", folder / "out", 0, {"--threads", "1"});
  const BatchRun again = run_batch(one, folder / "in", folder / "out", 0, {"--threads", "1"});
  fmt::print(
      "{} scans, one at a time: encode {:.3f} s each, batch {:.3f} s each: {:+.1f} ms for "
      "each; {:.1f} ms for each that is done already\n",
      settings.scans, single / settings.scans, batch.seconds / settings.scans,
      1000 * (batch.seconds - single) / settings.scans, 1000 * again.seconds / settings.scans);
  return batch.exit_code;
}

int main_of(int argc, char** argv) {
  Settings settings;
  CLI::App app("Measures nacre batch", "batch_runs");
  app.require_subcommand(1);
  app.add_option("--nacre", settings.nacre, "The command")->capture_default_str();
  app.add_option("--folder", settings.folder, "Work there and leave it; default: a temporary one");
  app.add_option("--scans", settings.scans, "How many")->capture_default_str();
  app.add_option("--kills", settings.kills, "For kill: how many")->capture_default_str();
  app.add_option("--seed", settings.seed)->capture_default_str();
  app.add_option("--max-memory", settings.max_memory, "For memory")->capture_default_str();
  app.add_option("--options", settings.options, "Of nacre encode")->capture_default_str();
  app.add_flag("!--no-corpus", settings.corpus, "For kill: generated scans only");
  using Bench = int (*)(const Settings&, const fs::path&);
  const std::map<std::string, std::pair<Bench, const char*>> benches = {
      {"kill", {&bench_kill, "SIGKILL at random moments against an undisturbed run"}},
      {"speed", {&bench_speed, "Wall time against the sum of single-threaded encodes"}},
      {"memory", {&bench_memory, "Peak memory of a mix with 1M triangles under --max-memory"}},
      {"overhead", {&bench_overhead, "What the batch adds to each scan"}}};
  for (const auto& [name, bench] : benches) {
    app.add_subcommand(name, bench.second)->fallthrough();
  }
  CLI11_PARSE(app, argc, argv);
  print_head(argc, argv);
  const TemporaryFolder temporary;
  const fs::path folder = settings.folder.empty() ? temporary.path() : fs::path(settings.folder);
  const auto& bench = benches.at(app.get_subcommands().front()->get_name());
  return bench.first(settings, folder);
}

}  // namespace
}  // namespace nacre::bench

int main(int argc, char** argv) {
  try {
    return nacre::bench::main_of(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "batch_runs: {}\n", error.what());
    return 1;
  }
}
