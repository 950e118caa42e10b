// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/batch/work_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <string>
#include <system_error>

namespace nacre::app::batch {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLockName = "lock";
constexpr auto kForeignAge = std::chrono::hours(24);

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 && name[0] != '\0' ? name.data() : "host";
}

/// Whether nobody holds the folder's lock. A folder without a lock file is one being made, or one
/// half removed.
bool is_free(const fs::path& folder) {
  const int lock = ::open((folder / kLockName).c_str(), O_RDWR | O_CLOEXEC);
  if (lock < 0) return errno == ENOENT;
  const bool free = ::flock(lock, LOCK_EX | LOCK_NB) == 0;
  ::close(lock);
  return free;
}

bool is_older(const fs::path& folder, std::chrono::seconds age) {
  std::error_code failed;
  const auto written = fs::last_write_time(folder, failed);
  return !failed && fs::file_time_type::clock::now() - written > age;
}

}  // namespace

Result<WorkFolder> WorkFolder::make(const fs::path& below) {
  std::error_code failed;
  fs::create_directories(below, failed);
  std::string name = below / (host_name() + "-XXXXXX");
  if (failed || ::mkdtemp(name.data()) == nullptr) {
    const std::string why = failed ? failed.message() : std::generic_category().message(errno);
    return Error{ErrorCode::kCannotWrite,
                 fmt::format("{}: a folder for unfinished work cannot be made: {}; check the "
                             "output folder",
                             below.string(), why)};
  }
  const int lock = ::open((fs::path(name) / kLockName).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  // Where the file system has no locks, the folder's age protects it from other machines.
  if (lock >= 0) (void)::flock(lock, LOCK_EX | LOCK_NB);
  return WorkFolder(name, lock);
}

WorkFolder::WorkFolder(WorkFolder&& other) noexcept
    : path_(std::move(other.path_)), lock_(other.lock_) {
  other.path_.clear();
  other.lock_ = -1;
}

WorkFolder::~WorkFolder() {
  if (path_.empty()) return;
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  if (lock_ >= 0) ::close(lock_);
}

void remove_abandoned(const fs::path& below) {
  std::error_code ignored;
  const std::string here = host_name() + "-";
  constexpr std::size_t kSuffix = 6;
  for (const fs::directory_entry& entry : fs::directory_iterator(below, ignored)) {
    const std::string name = entry.path().filename();
    const bool ours = name.starts_with(here) && name.size() == here.size() + kSuffix;
    const bool old =
        is_older(entry.path(), ours ? std::chrono::seconds(2) : std::chrono::seconds(kForeignAge));
    // Two seconds: between making a folder and locking it, another process may look.
    if (old && is_free(entry.path())) fs::remove_all(entry.path(), ignored);
  }
}

int count_live(const fs::path& below) {
  std::error_code ignored;
  int live = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(below, ignored)) {
    if (!is_free(entry.path())) ++live;
  }
  return live;
}

}  // namespace nacre::app::batch
