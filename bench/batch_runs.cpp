// SPDX-License-Identifier: GPL-3.0-or-later
//
// What `nacre batch` claims, each by a subcommand on scans that are made here: killing it loses and
// changes nothing, it keeps the processors busy, it stays below its memory, it costs little itself.
#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
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
  int scans = 0, kills = 20, jobs = 0, rounds = 5, huge = 3, regular_percent = 75;
  unsigned seed = 1;
  bool corpus = true;
  std::string max_memory = "4G", options, leave_out;

  [[nodiscard]] int scans_or(int usual) const { return scans > 0 ? scans : usual; }
  [[nodiscard]] std::string options_or(const char* usual) const {
    return options.empty() ? usual : options;
  }
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

/// Some thousand triangles that are three regular splits of 36 or 64.
void write_grid(const fs::path& file, unsigned seed) {
  write_scan(file, seed % 3 == 0 ? 4096 : 2304, seed);
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
/// Those in regular/ are grids, for --semi-regular, which takes a hundredth of the whole encoder.
void make_archive(const Settings& settings, const fs::path& folder) {
  int made = 0;
  if (settings.corpus) {
    fs::create_directories(folder / "corpus");
    for (const std::string& mesh : corpus_meshes()) {
      if (fs::path(mesh).filename() == settings.leave_out) continue;
      fs::copy(mesh, folder / "corpus", fs::copy_options::skip_existing);
      ++made;
    }
  }
  const std::vector<std::string> endings = {"ply", "off", "obj", "stl"};
  std::mt19937 random(settings.seed);
  for (int i = 0; made < settings.scans_or(300); ++i, ++made) {
    const auto seed = static_cast<unsigned>(i);
    const std::string name = fmt::format("scan{}.{}", i, endings[i % endings.size()]);
    if (i % 15 == 7) {
      write_broken(folder / "broken", i / 15, seed);
    } else if (i == 100 && settings.regular_percent < 100) {
      write_scan(folder / "large" / name, 1'000'000, seed);
    } else if (i % 50 == 25 && settings.regular_percent < 100) {
      write_scan(folder / "large" / name, 20'000 + random() % 80'000, seed);
    } else if (static_cast<int>(random() % 100) < settings.regular_percent) {
      // No STL: its corners are not joined before --semi-regular looks.
      write_grid(folder / "regular" / fmt::format("scan{}.{}", i, endings[i % 3]), seed);
    } else {
      write_scan(folder / fmt::format("box{}", i / 40) / name, 1000 + random() % 4000, seed);
    }
  }
}

struct Run {
  int exit_code = -1;
  bool killed = false;
  double seconds = 0;
  double cpu_seconds = 0;           ///< of it and its children
  std::uint64_t peak_bytes = 0;     ///< of it and its children together, sampled
  double idle_machine_seconds = 0;  ///< wall time if nothing else had run, see watch()
};

struct Watching {
  double kill_after_cpu_seconds = 0;  ///< 0: never
  bool on = false;                    ///< sample memory and what is runnable
};

/// What /proc says of a process, its threads and its children.
struct Sample {
  std::uint64_t resident_bytes = 0;
  double cpu_seconds = 0;
  int runnable = 0;
};

void add_process(pid_t pid, Sample& sample) {
  std::ifstream statm(fmt::format("/proc/{}/statm", pid));
  std::uint64_t total = 0, resident = 0;
  if (statm >> total >> resident) {
    sample.resident_bytes += resident * static_cast<std::uint64_t>(getpagesize());
  }
  // The state comes after the name in brackets, the times 11 words later: proc(5).
  const auto after_name = [](const fs::path& file) {
    std::ifstream in(file);
    std::string line;
    std::getline(in, line);
    const std::size_t bracket = line.rfind(')');
    return words_of(bracket == std::string::npos ? "" : line.substr(bracket + 1));
  };
  const std::vector<std::string> words = after_name(fmt::format("/proc/{}/stat", pid));
  if (words.size() < 15) return;
  double ticks = 0;
  for (std::size_t i = 11; i < 15; ++i) ticks += std::stod(words[i]);
  sample.cpu_seconds += ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
  std::error_code gone;
  for (const auto& task : fs::directory_iterator(fmt::format("/proc/{}/task", pid), gone)) {
    const std::vector<std::string> thread = after_name(task.path() / "stat");
    if (!thread.empty() && thread.front() == "R") ++sample.runnable;
  }
}

Sample sample_of(pid_t leader) {
  Sample sample;
  add_process(leader, sample);
  std::ifstream children(fmt::format("/proc/{0}/task/{0}/children", leader));
  for (pid_t pid = 0; children >> pid;) add_process(pid, sample);
  return sample;
}

/// Samples until the process ends. On an idle machine every runnable thread has a processor, so
/// what it computed between two samples would have taken as long as it takes that many processors;
/// where nothing was runnable, as long as it did take.
void watch(pid_t pid, const Watching& watching, int& status, rusage& usage, Run& run) {
  const int processors = static_cast<int>(std::thread::hardware_concurrency());
  double cpu_before = 0;
  Clock::time_point before = Clock::now();
  while (wait4(pid, &status, WNOHANG, &usage) == 0) {
    const Sample sample = sample_of(pid);
    run.peak_bytes = std::max(run.peak_bytes, sample.resident_bytes);
    const double cpu = sample.cpu_seconds - cpu_before, wall = seconds_since(before);
    before = Clock::now();
    cpu_before = sample.cpu_seconds;
    const int used = std::clamp(sample.runnable, 1, processors);
    run.idle_machine_seconds += sample.runnable == 0 ? wall : std::min(wall, cpu / used);
    const double life = watching.kill_after_cpu_seconds;
    if (life > 0 && sample.cpu_seconds >= life) kill(pid, SIGKILL);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

Run run_program(std::vector<std::string> words, const Watching& watching = {}) {
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const Clock::time_point begin = Clock::now();
  const pid_t pid = fork();
  if (pid < 0) throw std::runtime_error("fork failed");
  if (pid == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    const int null = open("/dev/null", O_RDWR);
    dup2(null, STDOUT_FILENO);
    dup2(null, STDERR_FILENO);
    execv(argv[0], argv.data());
    _exit(127);
  }
  Run run;
  int status = 0;
  rusage usage = {};
  if (watching.on || watching.kill_after_cpu_seconds > 0) {
    watch(pid, watching, status, usage, run);
  } else {
    wait4(pid, &status, 0, &usage);
  }
  run.seconds = seconds_since(begin);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  run.cpu_seconds = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  // What was computed after the last sample was not seen.
  run.idle_machine_seconds =
      std::max(run.idle_machine_seconds, run.cpu_seconds / std::thread::hardware_concurrency());
  run.killed = WIFSIGNALED(status);
  if (WIFEXITED(status)) run.exit_code = WEXITSTATUS(status);
  return run;
}

Run run_batch(const Settings& settings, const fs::path& in, const fs::path& out,
              const std::string& options, const std::vector<std::string>& more,
              const Watching& watching = {}) {
  std::vector<std::string> words = {settings.nacre, "batch", in, out, "-q"};
  words.insert(words.end(), more.begin(), more.end());
  if (settings.jobs > 0) words.insert(words.end(), {"--jobs", std::to_string(settings.jobs)});
  words.emplace_back("--");
  for (const std::string& word : words_of(options)) words.push_back(word);
  return run_program(words, watching);
}

/// One scan through nacre encode, with one thread and all that the batch does with each.
Run run_encode(const Settings& settings, const fs::path& scan, const fs::path& out,
               const std::string& options) {
  const std::string name = out / scan.stem();
  std::vector<std::string> words = {
      settings.nacre, "encode",    scan, "-o", name + ".ncr", "--report",
      name + ".json", "--threads", "1",  "-q", "-f"};
  for (const std::string& word : words_of(options)) words.push_back(word);
  const Run run = run_program(words);
  if (run.exit_code != 0) {
    throw std::runtime_error(fmt::format("{}: exit code {}", scan.string(), run.exit_code));
  }
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

/// Moments are counted in processor time, which does not depend on what else the machine does.
/// Every second life is short, so that starts, and ends of short scans, are hit as well.
int bench_kill(const Settings& settings, const fs::path& folder) {
  make_archive(settings, folder / "in");
  const std::string options =
      settings.options_or("--quality 30 --levels 3 --effort fast --samples 1000");
  const std::vector<std::string> more = {"--rule", "regular/**=--semi-regular"};
  const auto batch = [&](const char* out, double life) {
    return run_batch(settings, folder / "in", folder / out, options, more, {life, false});
  };
  const Run whole = batch("whole", 0);
  const std::size_t all = outputs(folder / "whole").size() - 1;  // but failed.jsonl
  fmt::print("undisturbed: {} of {} scans done, {:.0f} s, {:.0f} s of processor, exit code {}\n",
             all, settings.scans_or(300), whole.seconds, whole.cpu_seconds, whole.exit_code);
  std::fflush(stdout);
  std::mt19937 random(settings.seed);
  const double mean = whole.cpu_seconds / (settings.kills + 1);
  int killed = 0;
  double spent = 0;
  std::string lives;
  while (killed < settings.kills) {
    const double most = killed % 2 == 0 ? 3 * mean : std::min(1.0, mean);
    const double life = std::uniform_real_distribution<double>(0.01, most)(random);
    const Run run = batch("out", life);
    spent += run.seconds;
    if (!run.killed) break;
    ++killed;
    lives += fmt::format(" {:.2f}", life);
  }
  const std::size_t before = outputs(folder / "out").size();
  // Younger work folders than 2 s are left alone by a start: another may be making them.
  std::this_thread::sleep_for(std::chrono::seconds(3));
  const Run last = batch("out", 0);
  const auto expected = outputs(folder / "whole"), found = outputs(folder / "out");
  const bool same = expected == found;
  const bool clean = fs::directory_iterator(folder / "out/.nacre/work") == fs::directory_iterator();
  fmt::print("killed {} times, after s of processor:{}\n", killed, lives);
  fmt::print("{} files then; finished: {:.0f} s in all, exit code {}; {} files, {}; {}\n", before,
             spent + last.seconds, last.exit_code, found.size(),
             same ? "all bit for bit the same" : "DIFFERENT",
             clean ? "nothing left behind" : "WORK FILES LEFT");
  return same && clean && killed == settings.kills && last.exit_code == whole.exit_code ? 0 : 1;
}

/// Half of the single runs before the batch, half after it, so that a change of the machine's load
/// meets both sides.
int bench_speed(const Settings& settings, const fs::path& folder) {
  const std::string options = settings.options_or("--size 2k --effort fast --samples 1000");
  const int scans = settings.scans_or(100);
  std::mt19937 random(settings.seed);
  double wall = 0, cpu = 0;
  std::vector<fs::path> files;
  for (int i = 0; i < scans; ++i) {
    files.push_back(folder / "in" / fmt::format("scan{}.ply", i));
    write_scan(files.back(), 20'000 + random() % 80'000, static_cast<unsigned>(i));
  }
  fs::create_directories(folder / "single");
  const auto singles = [&](int from, int to) {
    for (int i = from; i < to; ++i) {
      const Run run = run_encode(settings, files[i], folder / "single", options);
      wall += run.seconds;
      cpu += run.cpu_seconds;
    }
  };
  singles(0, scans / 2);
  const Run batch = run_batch(settings, folder / "in", folder / "out", options, {}, {0, true});
  singles(scans / 2, scans);
  const double processors = std::thread::hardware_concurrency();
  fmt::print("{} scans of 20k to 100k triangles, {} processors\n", scans, processors);
  fmt::print("one after another, one thread: {:.1f} s, {:.1f} s of processor\n", wall, cpu);
  fmt::print("batch:                         {:.1f} s, {:.1f} s of processor, exit code {}\n",
             batch.seconds, batch.cpu_seconds, batch.exit_code);
  fmt::print("wall: {:.2f} x (sum / {})\n", batch.seconds / (wall / processors), processors);
  fmt::print("without the other load: {:.1f} s = {:.2f} x (sum of processor times / {})\n",
             batch.idle_machine_seconds, batch.idle_machine_seconds / (cpu / processors),
             processors);
  return batch.exit_code;
}

int bench_memory(const Settings& settings, const fs::path& folder) {
  const std::string options = settings.options_or("--size 2k --effort fast --samples 1000");
  const int scans = settings.scans_or(12);
  std::mt19937 random(settings.seed);
  for (int i = 0; i < scans; ++i) {
    write_scan(folder / "in" / fmt::format("scan{}.ply", i),
               i < settings.huge ? 1'000'000 : 1000 + random() % 30'000, static_cast<unsigned>(i));
  }
  const Run run = run_batch(settings, folder / "in", folder / "out", options,
                            {"--max-memory", settings.max_memory}, {0, true});
  fmt::print(
      "{} scans, {} of 1M triangles, --max-memory {}: peak {:.0f} MB, {:.0f} s, {:.0f} s of "
      "processor, exit code {}\n",
      scans, settings.huge, settings.max_memory, static_cast<double>(run.peak_bytes) / 1e6,
      run.seconds, run.cpu_seconds, run.exit_code);
  return run.exit_code;
}

/// One scan at a time, one thread each, both ways in turn; --semi-regular takes so little that the
/// difference shows.
int bench_overhead(const Settings& settings, const fs::path& folder) {
  const std::string options =
      settings.options_or("--semi-regular --quality 40 --effort fast --samples 1000");
  const int scans = settings.scans_or(50);
  Settings one = settings;
  one.jobs = 1;
  std::vector<fs::path> files;
  for (int i = 0; i < scans; ++i) {
    files.push_back(folder / "in" / fmt::format("scan{}.ply", i));
    write_grid(files.back(), static_cast<unsigned>(i));
  }
  fs::create_directories(folder / "single");
  fmt::print("ms for each of {} scans, wall (processor)\n", scans);
  fmt::print("| round | encode | batch | batch adds | done already |\n|--:|--:|--:|--:|--:|\n");
  const double ms = 1000.0 / scans;
  std::vector<double> walls, cpus;
  for (int round = 0; round < settings.rounds; ++round) {
    Run single;
    for (const fs::path& file : files) {
      const Run run = run_encode(settings, file, folder / "single", options);
      single.seconds += run.seconds;
      single.cpu_seconds += run.cpu_seconds;
    }
    const fs::path out = folder / fmt::format("out{}", round);
    const Run batch = run_batch(one, folder / "in", out, options, {"--threads", "1"});
    const Run again = run_batch(one, folder / "in", out, options, {"--threads", "1"});
    if (batch.exit_code != 0) return batch.exit_code;
    walls.push_back(ms * (batch.seconds - single.seconds));
    cpus.push_back(ms * (batch.cpu_seconds - single.cpu_seconds));
    fmt::print("| {} | {:.1f} ({:.1f}) | {:.1f} ({:.1f}) | {:+.1f} ({:+.1f}) | {:.1f} ({:.1f}) |\n",
               round + 1, ms * single.seconds, ms * single.cpu_seconds, ms * batch.seconds,
               ms * batch.cpu_seconds, walls.back(), cpus.back(), ms * again.seconds,
               ms * again.cpu_seconds);
    std::fflush(stdout);
  }
  std::ranges::sort(walls);
  std::ranges::sort(cpus);
  fmt::print("medians: the batch adds {:+.1f} ms ({:+.1f} ms of processor) to each\n",
             walls[walls.size() / 2], cpus[cpus.size() / 2]);
  return 0;
}

int main_of(int argc, char** argv) {
  Settings settings;
  CLI::App app("Measures nacre batch", "batch_runs");
  app.require_subcommand(1);
  app.add_option("--nacre", settings.nacre, "The command")->capture_default_str();
  app.add_option("--folder", settings.folder, "Work there and leave it; default: a temporary one");
  app.add_option("--scans", settings.scans, "How many; default: 300, 100, 12, 50");
  app.add_option("--kills", settings.kills, "For kill: how many")->capture_default_str();
  app.add_option("--seed", settings.seed)->capture_default_str();
  app.add_option("--max-memory", settings.max_memory, "For memory")->capture_default_str();
  app.add_option("--options", settings.options, "Of nacre encode; default: cheap ones");
  app.add_option("--jobs", settings.jobs, "Of nacre batch; default: its own");
  app.add_option("--rounds", settings.rounds, "For overhead: how often")->capture_default_str();
  app.add_option("--huge", settings.huge, "For memory: how many of 1M")->capture_default_str();
  app.add_option(
         "--regular-percent", settings.regular_percent,
         "For kill: how many of the small ones do not take the whole encoder; 100: no large ones")
      ->capture_default_str();
  app.add_flag("!--no-corpus", settings.corpus, "For kill: generated scans only");
  app.add_option("--leave-out", settings.leave_out, "For kill: a file of the corpus");
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
