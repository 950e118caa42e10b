// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/support.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <tbb/info.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>

#include "app/report.h"
#include "tests/support/corpus.h"

namespace nacre::bench {
namespace {

namespace fs = std::filesystem;

std::string shell_quoted(const std::string& word) {
  const char* const plain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=,:+@%";
  if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string read_all(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string last_line(const std::string& text) {
  const std::size_t end = text.find_last_not_of("\r\n");
  if (end == std::string::npos) return "";
  const std::size_t begin = text.find_last_of("\r\n", end);
  return text.substr(begin == std::string::npos ? 0 : begin + 1, end - (begin + 1) + 1);
}

/// In the child: never returns.
[[noreturn]] void become(const std::vector<std::string>& arguments, const fs::path& out,
                         const fs::path& err) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // an interrupted benchmark leaves nothing running
  const int out_fd = open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  const int err_fd = open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  if (out_fd < 0 || err_fd < 0 || dup2(out_fd, 1) < 0 || dup2(err_fd, 2) < 0) _exit(127);
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  execvp(argv[0], argv.data());
  std::perror(argv[0]);
  _exit(127);
}

}  // namespace

void print_head(int argc, const char* const* argv) {
  std::string line;
  for (int i = 0; i < argc; ++i) {
    if (i > 0) line += ' ';
    line += shell_quoted(argv[i]);
  }
  fmt::print("`{}`\n\n{} threads\n\n", line, tbb::info::default_concurrency());
  std::fflush(stdout);
}

void Table::print_header() const {
  std::string names = "|", rules = "|";
  for (const Column& column : columns_) {
    names += fmt::format(" {} |", column.name);
    rules += column.is_text ? "---|" : "--:|";
  }
  fmt::print("{}\n{}\n", names, rules);
  std::fflush(stdout);
}

void Table::print_row(const std::vector<std::string>& cells) const {
  std::string line = "|";
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    std::string cell = i < cells.size() ? cells[i] : "";
    std::replace(cell.begin(), cell.end(), '|', '/');
    line += fmt::format(" {} |", cell);
  }
  fmt::print("{}\n", line);
  std::fflush(stdout);
}

std::string ChildRun::outcome() const {
  if (timed_out) return fmt::format("over {:.0f} s", seconds);
  if (signal != 0) return fmt::format("signal {} ({})", signal, strsignal(signal));
  if (exit_code == 0) return "ok";
  return fmt::format("exit {}: {}", exit_code, last_line(err));
}

ChildRun run_child(const std::vector<std::string>& arguments, double timeout_seconds) {
  using Clock = std::chrono::steady_clock;
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "stdout", err = folder.path() / "stderr";
  const Clock::time_point begin = Clock::now();
  const auto elapsed = [&] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
  const pid_t pid = fork();
  if (pid < 0) throw std::runtime_error("fork failed");
  if (pid == 0) become(arguments, out, err);

  ChildRun run;
  int status = 0;
  rusage usage = {};
  while (wait4(pid, &status, WNOHANG, &usage) == 0) {
    if (!run.timed_out && elapsed() > timeout_seconds) {
      run.timed_out = true;
      kill(pid, SIGKILL);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  run.seconds = elapsed();
  run.peak_bytes = static_cast<std::size_t>(usage.ru_maxrss) * 1024;
  if (WIFEXITED(status)) run.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) run.signal = WTERMSIG(status);
  run.out = read_all(out);
  run.err = read_all(err);
  return run;
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (fs::temp_directory_path() / "nacre-bench-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder: " + name);
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

std::vector<std::string> corpus_meshes() {
  std::error_code none;
  std::vector<std::pair<std::uintmax_t, std::string>> found;
  for (const auto& entry : fs::directory_iterator(corpus::folder(), none)) {
    const std::string extension = entry.path().extension().string();
    if (extension == ".ply" || extension == ".obj" || extension == ".off" || extension == ".stl")
      found.emplace_back(entry.file_size(), entry.path().lexically_normal().string());
  }
  std::sort(found.begin(), found.end());
  std::vector<std::string> names;
  for (const auto& [size, name] : found) names.push_back(name);
  return names;
}

double psnr_of_maximum_db(const metric::Comparison& comparison) {
  return metric::psnr_db(comparison.bbox_diagonal, app::max_error(comparison));
}

}  // namespace nacre::bench
