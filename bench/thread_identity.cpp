// SPDX-License-Identifier: GPL-3.0-or-later
//
// Whether the same scan and options give the same bytes at different thread counts.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>

#include "bench/support.h"
#include "io/write.h"

namespace nacre::bench {
namespace {

struct Settings {
  std::vector<std::string> meshes;
  std::vector<int> threads = {1, 2};
  std::string profile = "best", nacre = NACRE_COMMAND;
  double bits_per_input_vertex = 4;
  double timeout_seconds = 300;
};

struct Outcome {
  std::string verdict;
  std::vector<std::string> sizes, seconds;
};

Outcome run_mesh(const std::string& mesh, const Settings& settings) {
  const TemporaryFolder folder;
  const std::string stream = folder.path() / "out.ncr";
  Outcome outcome{"OK", {}, {}};
  std::vector<std::uint8_t> first;
  for (const int threads : settings.threads) {
    const ChildRun run =
        run_child({settings.nacre, "encode", mesh, "-o", stream, "-q", "-f", "--samples", "1000",
                   "--profile", settings.profile, "--threads", std::to_string(threads),
                   "--bits-per-vertex", fmt::format("{}", settings.bits_per_input_vertex)},
                  settings.timeout_seconds);
    const auto bytes = run.ok() ? io::read_file(stream) : Error{};
    if (!bytes) {
      outcome.verdict = fmt::format("{} threads: {}", threads, run.outcome());
      return outcome;
    }
    if (outcome.sizes.empty()) first = *bytes;
    if (*bytes != first) {
      const auto at = std::mismatch(first.begin(), first.end(), bytes->begin(), bytes->end()).first;
      outcome.verdict = fmt::format("DIFFERS from byte {}", at - first.begin());
    }
    outcome.sizes.push_back(std::to_string(bytes->size()));
    outcome.seconds.push_back(fmt::format("{:.1f}", run.seconds));
  }
  return outcome;
}

int main_of(int argc, char** argv) {
  Settings settings;
  CLI::App app("Compares the bytes that different thread counts give", "thread_identity");
  app.add_option("MESH", settings.meshes, "Scans; default: all of the corpus");
  app.add_option("--threads", settings.threads, "Thread counts")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--bits-per-vertex", settings.bits_per_input_vertex)->capture_default_str();
  app.add_option("--profile", settings.profile, "As nacre encode takes it")->capture_default_str();
  app.add_option("--timeout", settings.timeout_seconds, "Seconds for one encoding")
      ->capture_default_str();
  app.add_option("--nacre", settings.nacre, "The command")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  if (settings.meshes.empty()) settings.meshes = corpus_meshes();
  print_head(argc, argv);
  const std::string counts = fmt::format("{}", fmt::join(settings.threads, " / "));
  const Table table({{"mesh", true},
                     {"bytes at " + counts + " threads"},
                     {"encode s at " + counts + " threads"},
                     {"same bytes", true}});
  table.print_header();
  bool all_same = true;
  for (const std::string& mesh : settings.meshes) {
    const Outcome outcome = run_mesh(mesh, settings);
    all_same = all_same && outcome.verdict == "OK";
    table.print_row({std::filesystem::path(mesh).stem().string(),
                     fmt::format("{}", fmt::join(outcome.sizes, " / ")),
                     fmt::format("{}", fmt::join(outcome.seconds, " / ")), outcome.verdict});
  }
  return all_same ? 0 : 1;
}

}  // namespace
}  // namespace nacre::bench

int main(int argc, char** argv) { return nacre::bench::main_of(argc, argv); }
