// SPDX-License-Identifier: GPL-3.0-or-later
//
// fork without exec: the caller has one thread and a few megabytes, so a child is there in about a
// millisecond, and gets its work as a function instead of as words to parse again.
#include "app/batch/child.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <fstream>
#include <new>
#include <system_error>
#include <thread>
#include <utility>

#include "app/exit_code.h"

namespace nacre::app::batch {
namespace {

constexpr int kSignalled = 128;  // as shells say
constexpr auto kThreadsPoll = std::chrono::milliseconds(100);

void unmap(std::atomic<int>* shared) { ::munmap(shared, sizeof(*shared)); }

/// First in line for the kernel when memory runs out, so that the scheduler and its neighbours
/// stay.
void offer_to_oom_killer() {
  const int file = ::open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC);
  if (file < 0) return;
  (void)!::write(file, "1000", 4);
  ::close(file);
}

using ThreadLimit = tbb::global_control;

std::unique_ptr<ThreadLimit> limit_threads(int threads) {
  return std::make_unique<ThreadLimit>(ThreadLimit::max_allowed_parallelism,
                                       static_cast<std::size_t>(threads));
}

/// Follows the number that the parent lends.
[[noreturn]] void follow_threads(const std::atomic<int>& lent, int threads,
                                 std::unique_ptr<ThreadLimit> limit) {
  for (;;) {
    std::this_thread::sleep_for(kThreadsPoll);
    const int now = lent.load(std::memory_order_relaxed);
    if (now == threads) continue;
    threads = now;
    limit.reset();  // the least of all limits counts, so the old one would hold a rise back
    limit = limit_threads(threads);
  }
}

int run_guarded(const std::function<int()>& work) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    std::fputs("out of memory; try fewer --levels, or a machine with more\n", stderr);
    return kExitLimit;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "unexpected failure: %s\n", error.what());
  }
  return kExitUnexpected;
}

[[noreturn]] void become_child(const std::function<int()>& work, const std::atomic<int>& lent,
                               const std::filesystem::path& stderr_file, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(kExitInterrupted);  // it was gone before the line above
  offer_to_oom_killer();
  const int err = ::open(stderr_file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  if (err >= 0) ::dup2(err, STDERR_FILENO);
  const int null = ::open("/dev/null", O_RDWR);
  if (null >= 0) {
    ::dup2(null, STDIN_FILENO);
    ::dup2(null, STDOUT_FILENO);
  }
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  const int threads = lent.load();
  std::thread([&lent, threads, limit = limit_threads(threads)]() mutable {
    follow_threads(lent, threads, std::move(limit));
  }).detach();
  const int code = run_guarded(work);
  std::fflush(stderr);
  _exit(code);  // the parent's objects are not this process's to destroy
}

}  // namespace

Result<Child> Child::start(const std::function<int()>& work, int threads,
                           const std::filesystem::path& stderr_file) {
  const auto failed = [](const char* what) {
    return Error{ErrorCode::kCannotWrite, fmt::format("{}: {}; try fewer --jobs", what,
                                                      std::generic_category().message(errno))};
  };
  void* page = ::mmap(nullptr, sizeof(std::atomic<int>), PROT_READ | PROT_WRITE,
                      MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (page == MAP_FAILED) return failed("no memory for another process");
  SharedInt lent(new (page) std::atomic<int>(threads), &unmap);
  std::fflush(nullptr);  // or the child would print what is buffered once more
  const pid_t parent = ::getpid(), pid = ::fork();
  if (pid < 0) return failed("no further process can be started");
  if (pid == 0) become_child(work, *lent, stderr_file, parent);
  return Child(pid, std::move(lent));
}

std::optional<ChildEnd> Child::poll() {
  int status = 0;
  if (::waitpid(pid_, &status, WNOHANG) != pid_) return std::nullopt;
  ChildEnd end;
  if (WIFEXITED(status)) end.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) {
    end.signal = WTERMSIG(status);
    end.exit_code = kSignalled + end.signal;
  }
  return end;
}

std::uint64_t Child::resident_bytes() const { return batch::resident_bytes(pid_); }

void Child::send(int signal) const { ::kill(pid_, signal); }

std::uint64_t resident_bytes(pid_t pid) {
  std::ifstream in(fmt::format("/proc/{}/statm", pid));
  std::uint64_t total = 0, resident = 0;
  if (!(in >> total >> resident)) return 0;
  return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

}  // namespace nacre::app::batch
