// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/batch/machine.h"

#include <fmt/format.h>
#include <tbb/info.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <string>

namespace nacre::app::batch {
namespace {

namespace fs = std::filesystem;

std::optional<std::uint64_t> read_number(const fs::path& file) {
  std::ifstream in(file);
  std::uint64_t value = 0;
  if (!(in >> value)) return std::nullopt;  // "max" among others
  return value;
}

std::uint64_t available_bytes() {
  std::ifstream in("/proc/meminfo");
  for (std::string word; in >> word;) {
    std::uint64_t kib = 0;
    if (word == "MemAvailable:" && in >> kib) return kib * 1024;
  }
  return std::numeric_limits<std::uint64_t>::max();
}

/// What a control group and all above it leave; version 2 of them.
std::uint64_t group_bytes_left() {
  std::uint64_t least = std::numeric_limits<std::uint64_t>::max();
  std::ifstream in("/proc/self/cgroup");
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with("0::/")) continue;
    const fs::path root = "/sys/fs/cgroup";
    for (fs::path group = root / line.substr(4);; group = group.parent_path()) {
      const auto limit = read_number(group / "memory.max");
      const auto used = read_number(group / "memory.current");
      if (limit) least = std::min(least, *limit - std::min(*limit, used.value_or(0)));
      if (group == root || !group.has_relative_path()) break;
    }
  }
  return least;
}

}  // namespace

int usable_threads() { return std::max(1, tbb::info::default_concurrency()); }

std::uint64_t usable_memory() {
  const std::uint64_t bytes = std::min(available_bytes(), group_bytes_left());
  return bytes == std::numeric_limits<std::uint64_t>::max() ? 0 : bytes / 10 * 9;
}

}  // namespace nacre::app::batch
