// SPDX-License-Identifier: GPL-3.0-or-later
//
// One loop: start what may start, sleep until a child ends or a tenth of a second is over, look.
#include "app/batch/runner.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <system_error>
#include <utility>

#include "app/batch/encode_item.h"
#include "app/batch/estimate.h"
#include "app/exit_code.h"
#include "app/interrupt.h"
#include "app/sizes.h"

namespace nacre::app::batch {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr long kPollNanoseconds = 100'000'000;
constexpr double kGraceSeconds = 20;  ///< between the polite signal and the other one
// The sample is a moment old when it is acted on, and a scan allocates up to a gigabyte a second.
constexpr double kMemoryMargin = 0.97;
constexpr double kGrowthAfterKill = 1.5;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// The last line of what a child said.
std::string last_line(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string last;
  for (std::string line; std::getline(in, line);) {
    if (line.find_first_not_of(" \t\r") != std::string::npos) last = line;
  }
  return last;
}

/// Neither the same input nor the same options give another answer the next time.
bool is_final(int exit_code) {
  return exit_code == kExitUsage || exit_code == kExitGeometryRefused ||
         exit_code == kExitGoalUnreachable;
}

void replace_all(std::string& text, const std::string& what, const std::string& with) {
  for (std::size_t at = text.find(what); at != std::string::npos;
       at = text.find(what, at + with.size())) {
    text.replace(at, what.size(), with);
  }
}

/// Signals of children wake the loop instead of being dropped.
sigset_t child_signal() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGCHLD);
  return set;
}

}  // namespace

Runner::Runner(const Manifest& manifest, const Store& store, const RunCommand& command,
               fs::path work, Console& console)
    : manifest_(manifest),
      store_(store),
      command_(command),
      work_(std::move(work)),
      console_(console) {}

Result<Runner::Outcome> Runner::run(const std::vector<std::size_t>& items, const Limits& limits) {
  limits_ = limits;
  std::vector<Job> jobs;
  for (const std::size_t i : items) {
    const Item& item = manifest_.items[i];
    jobs.push_back({i, estimated_seconds(item), estimated_bytes(item)});
    seconds_total_ += jobs.back().seconds;
  }
  total_ = jobs.size();
  schedule_ = Schedule(std::move(jobs), limits);
  const sigset_t wake = child_signal();
  sigprocmask(SIG_BLOCK, &wake, nullptr);
  const timespec poll = {0, kPollNanoseconds};
  for (;;) {
    if (!stopping_) {
      if (Result<void> ok = start_what_may(); !ok) return ok.error();
      share_threads();
    }
    if (active_.empty()) break;
    sigtimedwait(&wake, nullptr, &poll);
    if (Result<void> ok = reap(); !ok) return ok.error();
    if (console_.cancelled()) stop_all();
    watch();
  }
  outcome_.interrupted = stopping_;
  return outcome_;
}

Result<void> Runner::start_what_may() {
  for (;;) {
    // All of them first: how many threads one gets depends on how many there are.
    std::vector<Job> jobs;
    while (const std::optional<Job> job = schedule_.start()) jobs.push_back(*job);
    if (jobs.empty()) return {};
    for (const Job& job : jobs) {
      if (Result<void> ok = start(job); !ok) return ok;
    }
  }
}

Result<void> Runner::start(const Job& job) {
  const Item& item = manifest_.items[job.item];
  // Another process may have made it since this one began: a shard can run twice.
  const bool force = command_.overwrite || command_.verify;
  if (!force && state_of(store_, manifest_, item, false, false) == State::kDone) {
    schedule_.finish(job.item);
    --total_;
    return {};
  }
  const fs::path folder = work_ / std::to_string(started_++);
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return Error{ErrorCode::kCannotWrite,
                 fmt::format("{}: cannot be made: {}", folder.string(), error.message())};
  }
  int threads = 1;
  for (const Schedule::Share& share : schedule_.threads()) {
    if (share.item == job.item) threads = share.threads;
  }
  const auto work = [&]() -> int {
    const Result<void> done =
        encode_item(store_, manifest_, item, folder, threads, force, install_interrupt_handler());
    if (done) return kExitDone;
    std::fprintf(stderr, "%s\n", done.error().message.c_str());
    return exit_code(done.error().code);
  };
  Result<Child> child = Child::start(work, threads, folder / "stderr");
  if (!child) return child.error();
  active_.emplace(job.item, Active{std::move(*child), folder, Clock::now()});
  return {};
}

Result<void> Runner::reap() {
  for (auto it = active_.begin(); it != active_.end();) {
    const std::optional<ChildEnd> end = it->second.child.poll();
    if (!end) {
      ++it;
      continue;
    }
    const std::size_t item = it->first;
    const Active active = std::move(it->second);
    it = active_.erase(it);
    Result<void> ok = ended(item, *end, active);
    std::error_code ignored;
    fs::remove_all(active.work, ignored);
    if (!ok) return ok;
  }
  return {};
}

Result<void> Runner::ended(std::size_t item, const ChildEnd& end, const Active& active) {
  if (end.exit_code == kExitDone) {
    finished_well(item, active);
    return {};
  }
  if (active.over_memory && !active.alone) {
    const auto more =
        static_cast<std::uint64_t>(kGrowthAfterKill * static_cast<double>(active.peak_bytes));
    schedule_.finish_and_repeat(item, std::max(more, estimated_bytes(manifest_.items[item])));
    console_.detail(fmt::format("{}: put off, memory was short", place(item)));
    return {};
  }
  // Nobody's fault: this run is being stopped, or somebody stopped the child by hand.
  if (stopping_ || end.exit_code == kExitInterrupted) {
    if (stopping_) {
      schedule_.finish(item);
    } else {
      schedule_.finish_and_repeat(item, estimated_bytes(manifest_.items[item]));
    }
    return {};
  }
  return failed(item, end, active);
}

void Runner::finished_well(std::size_t item, const Active& active) {
  schedule_.finish(item);
  ++outcome_.encoded;
  seconds_done_ += estimated_seconds(manifest_.items[item]);
  const std::optional<Record> record = store_.record(manifest_.items[item]);
  if (record) {
    console_.note(fmt::format("{}: {} -> {}, PSNR {}, {:.1f} s, {}", place(item),
                              format_bytes(record->input.bytes), format_bytes(record->output_bytes),
                              record->psnr_db ? fmt::format("{:.2f} dB", *record->psnr_db) : "-",
                              seconds_since(active.begin), format_bytes(record->peak_bytes)));
  }
}

Result<void> Runner::failed(std::size_t item, const ChildEnd& end, const Active& active) {
  const Item& entry = manifest_.items[item];
  Failure failure;
  failure.key =
      failure_key(stamp_of(scan_path(manifest_, entry)).value_or(FileStamp{}), entry.options);
  const std::optional<Failure> before = store_.failure(entry);
  // Of a shard that runs twice at once, the other copy may have counted the last one already.
  const int counted = before && before->key == failure.key ? before->attempts : 0;
  failure.attempts = std::min(counted + 1, kMostAttempts);
  failure.exit_code = end.exit_code;
  failure.signal = end.signal;
  failure.message = last_line(active.work / "stderr");
  replace_all(failure.message, (active.work / "out.ncr").string(), entry.output);
  if (active.over_memory || active.timed_out) {
    failure.exit_code = kExitLimit;
    failure.signal = 0;
    failure.message =
        active.over_memory
            ? fmt::format("needs more than --max-memory allows ({}), even alone",
                          format_bytes(limits_.bytes))
            : fmt::format("took longer than --timeout ({} s)", command_.timeout_seconds);
  } else if (end.signal != 0) {
    failure.message =
        fmt::format("killed by signal {} ({}){}{}", end.signal, strsignal(end.signal),
                    end.signal == SIGKILL ? ", probably because the machine ran out of memory" : "",
                    failure.message.empty() ? "" : "; its last words: " + failure.message);
  }
  failure.final = active.over_memory || active.timed_out || is_final(end.exit_code) ||
                  failure.attempts >= kMostAttempts;
  if (Result<void> ok = store_.write(entry, failure, work_); !ok) return ok;
  console_.warning(fmt::format(
      "{}: failed with exit code {}: {}{}", place(item), failure.exit_code, failure.message,
      failure.final ? "" : fmt::format(" (attempt {} of {})", failure.attempts, kMostAttempts)));
  if (!failure.final) {
    // A scan that died of memory is given more room the next time.
    const std::uint64_t more = end.signal == SIGKILL ? 2 * active.peak_bytes : 0;
    schedule_.finish_and_repeat(item, std::max(more, estimated_bytes(entry)));
    return {};
  }
  schedule_.finish(item);
  ++outcome_.failed;
  seconds_done_ += estimated_seconds(entry);
  return {};
}

void Runner::watch() {
  watch_memory();
  for (auto& [item, active] : active_) {
    if (command_.timeout_seconds > 0 && !active.timed_out &&
        seconds_since(active.begin) > command_.timeout_seconds) {
      active.timed_out = true;
      active.child.send(SIGKILL);
    }
  }
  if (stopping_ && !killed_ && seconds_since(stop_begin_) > kGraceSeconds) {
    killed_ = true;
    for (auto& [item, active] : active_) active.child.send(SIGKILL);
  }
  console_.context().report("batch", seconds_total_ > 0 ? seconds_done_ / seconds_total_ : 1);
}

/// The last line of defence behind the estimates. Whoever began last has least to lose.
void Runner::watch_memory() {
  std::uint64_t total = resident_bytes(getpid());
  Active* youngest = nullptr;
  for (auto& [item, active] : active_) {
    const std::uint64_t bytes = active.child.resident_bytes();
    active.peak_bytes = std::max(active.peak_bytes, bytes);
    schedule_.charge(item, bytes);
    total += bytes;
    if (active.over_memory) return;  // it is dying, and its memory is still counted
    if (youngest == nullptr || active.begin > youngest->begin) youngest = &active;
  }
  outcome_.peak_bytes = std::max(outcome_.peak_bytes, total);
  const double limit = kMemoryMargin * static_cast<double>(limits_.bytes);
  if (youngest == nullptr || limits_.bytes == 0 || static_cast<double>(total) <= limit) return;
  youngest->over_memory = true;
  youngest->alone = active_.size() == 1;
  youngest->child.send(SIGKILL);
}

void Runner::share_threads() {
  for (const Schedule::Share& share : schedule_.threads()) {
    const auto found = active_.find(share.item);
    if (found != active_.end()) found->second.child.set_threads(share.threads);
  }
}

void Runner::stop_all() {
  if (stopping_) return;
  stopping_ = true;
  stop_begin_ = Clock::now();
  schedule_.drop_waiting();
  for (auto& [item, active] : active_) active.child.send(SIGTERM);
}

std::string Runner::place(std::size_t item) const {
  const std::size_t ended = outcome_.encoded + outcome_.failed;
  return fmt::format("[{}/{}] {}", ended, total_, manifest_.items[item].scan);
}

}  // namespace nacre::app::batch
