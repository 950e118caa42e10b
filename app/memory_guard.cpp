// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/memory_guard.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>

#include "app/exit_code.h"
#include "app/interrupt.h"
#include "app/sizes.h"

namespace nacre::app {
namespace {

constexpr auto kInterval = std::chrono::milliseconds(20);

/// Resident bytes now; 0 if the system does not say.
std::uint64_t resident_bytes() {
  std::FILE* file = std::fopen("/proc/self/statm", "r");
  if (file == nullptr) return 0;
  unsigned long long total = 0, resident = 0;
  const int read = std::fscanf(file, "%llu %llu", &total, &resident);
  std::fclose(file);
  return read == 2 ? resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) : 0;
}

}  // namespace

MemoryGuard::MemoryGuard(std::uint64_t limit) : limit_(limit) {
  if (limit_ == 0) return;
  look();
  thread_ = std::thread([this] { watch(); });
}

MemoryGuard::~MemoryGuard() {
  done_ = true;
  if (thread_.joinable()) thread_.join();
}

std::uint64_t MemoryGuard::look() {
  const std::uint64_t now = resident_bytes();
  if (now > limit_ && !exceeded_.exchange(true)) request_stop();
  return now;
}

void MemoryGuard::watch() {
  while (!done_) {
    if (look() > limit_ + limit_ / 2) {
      std::fprintf(stderr, "\nnacre: %s\n", error().message.c_str());
      _exit(kExitLimit);
    }
    std::this_thread::sleep_for(kInterval);
  }
}

Error MemoryGuard::error() const {
  return {ErrorCode::kLimitExceeded,
          fmt::format("took more than --max-memory {}; nothing was written. Give it more, or ask "
                      "for fewer --levels",
                      format_bytes(limit_))};
}

}  // namespace nacre::app
