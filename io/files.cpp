// SPDX-License-Identifier: Apache-2.0
//
// Read me first: an output appears under its name only when it is complete. It is written to a
// temporary file in the same folder (a rename does not cross file systems), flushed to the disk,
// and renamed; without `overwrite` the rename itself refuses an existing name, so that of two
// writers racing for one name exactly one wins.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <system_error>

#include "io/write.h"

namespace nacre::io {
namespace {

namespace fs = std::filesystem;

// Some systems refuse transfers of 2 GiB and more at once.
constexpr std::size_t kTransferBytes = std::size_t{1} << 30;

std::string reason(int error) { return std::generic_category().message(error); }

Error cannot_write(const fs::path& file, const std::string& what) {
  return {ErrorCode::kCannotWrite, file.string() + ": " + what, 0};
}

Error cannot_read(const fs::path& file, const std::string& what) {
  return {ErrorCode::kUnreadableFile, file.string() + ": " + what, 0};
}

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const { return fd_; }
  /// 0, or the error: some file systems report a failed write only here.
  int close() {
    const int fd = fd_;
    fd_ = -1;
    return ::close(fd) == 0 ? 0 : errno;
  }

 private:
  int fd_;
};

/// 0 or the error.
int write_all(int fd, std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), std::min(bytes.size(), kTransferBytes));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    if (written == 0) return ENOSPC;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return 0;
}

/// Gives `temporary` the name `file` unless that exists. 0 or the error.
int rename_to_new(const fs::path& temporary, const fs::path& file) {
#if defined(__linux__) && defined(RENAME_NOREPLACE)
  if (::renameat2(AT_FDCWD, temporary.c_str(), AT_FDCWD, file.c_str(), RENAME_NOREPLACE) == 0)
    return 0;
  if (errno != EINVAL && errno != ENOSYS) return errno;
#endif
  // A hard link refuses an existing name as well.
  if (::link(temporary.c_str(), file.c_str()) == 0) {
    ::unlink(temporary.c_str());
    return 0;
  }
  if (errno == EEXIST) return errno;
  // No hard links here (FAT): claim the name with an empty file, then replace that.
  const int claimed = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (claimed < 0) return errno;
  ::close(claimed);
  if (::rename(temporary.c_str(), file.c_str()) == 0) return 0;
  const int error = errno;
  ::unlink(file.c_str());
  return error;
}

/// A new file in `folder`, removed again unless kept.
class Temporary {
 public:
  static constexpr int kAttempts = 100;

  explicit Temporary(const fs::path& folder) {
    static std::atomic<unsigned> counter{0};
    for (int i = 0; i < kAttempts && fd_ < 0; ++i) {
      path_ = folder /
              (".nacre-" + std::to_string(::getpid()) + "-" + std::to_string(counter++) + ".tmp");
      fd_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      if (fd_ < 0 && errno != EEXIST) break;
    }
    error_ = fd_ < 0 ? errno : 0;
  }
  ~Temporary() {
    if (error_ == 0 && !kept_) ::unlink(path_.c_str());
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  [[nodiscard]] int error() const { return error_; }
  [[nodiscard]] int descriptor() const { return fd_; }
  [[nodiscard]] const fs::path& path() const { return path_; }
  void keep() { kept_ = true; }

 private:
  fs::path path_;
  int fd_ = -1;
  int error_ = 0;
  bool kept_ = false;
};

/// A rename lasts through a power cut once its folder is on the disk. Not all file systems can, and
/// the output is whole either way, so a failure here is none of the caller's.
void flush_folder(const fs::path& folder) {
  const Descriptor opened(::open(folder.c_str(), O_RDONLY | O_CLOEXEC));
  if (opened.get() >= 0) (void)::fsync(opened.get());
}

Error exists_already(const fs::path& file) {
  return cannot_write(file, "exists already; give another name or allow overwriting (-f)");
}

Result<void> write_through(const fs::path& file, std::span<const std::uint8_t> bytes) {
  Descriptor out(::open(file.c_str(), O_WRONLY | O_CLOEXEC));
  if (out.get() < 0) return cannot_write(file, "cannot be opened: " + reason(errno));
  if (const int error = write_all(out.get(), bytes)) {
    return cannot_write(file, "cannot be written: " + reason(error));
  }
  return {};
}

Result<void> replace(const fs::path& file, std::span<const std::uint8_t> bytes, bool overwrite,
                     const struct stat* old) {
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  Temporary temporary(folder);
  if (temporary.error() != 0) {
    return cannot_write(file, "cannot be created in folder " + folder.string() + ": " +
                                  reason(temporary.error()) + "; check the folder");
  }
  Descriptor out(temporary.descriptor());
  int error = write_all(out.get(), bytes);
  if (error == 0 && old != nullptr && ::fchmod(out.get(), old->st_mode & 07777) != 0) error = errno;
  if (error == 0 && ::fsync(out.get()) != 0) error = errno;
  if (const int closed = out.close(); error == 0) error = closed;
  if (error != 0) {
    return cannot_write(file, "cannot be written: " + reason(error) + "; nothing was kept");
  }
  if (overwrite) {
    error = ::rename(temporary.path().c_str(), file.c_str()) == 0 ? 0 : errno;
  } else {
    error = rename_to_new(temporary.path(), file);
  }
  if (error == EEXIST) return exists_already(file);
  if (error != 0) return cannot_write(file, "cannot be put in place: " + reason(error));
  temporary.keep();
  flush_folder(folder);
  return {};
}

}  // namespace

Result<void> write_file(const fs::path& file, std::span<const std::uint8_t> bytes, bool overwrite) {
  if (!file.has_filename()) return cannot_write(file, "is not a file name");
  struct stat old {};
  if (::stat(file.c_str(), &old) != 0) {
    if (::lstat(file.c_str(), &old) == 0) {
      return cannot_write(file, "is a link to nothing; remove it or give another name");
    }
    return replace(file, bytes, overwrite, nullptr);
  }
  if (S_ISDIR(old.st_mode)) return cannot_write(file, "is a folder; give a file name");
  // A pipe or device (/dev/stdout) must not be replaced by a file, and holds nothing to lose.
  if (!S_ISREG(old.st_mode)) return write_through(file, bytes);
  if (!overwrite) return exists_already(file);
  std::error_code failed;
  const fs::path target = fs::canonical(file, failed);  // a link stays; what it names is replaced
  if (failed) return cannot_write(file, "cannot be followed: " + failed.message());
  return replace(target, bytes, true, &old);
}

Result<std::vector<std::uint8_t>> read_file(const fs::path& file) {
  const Descriptor in(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
  if (in.get() < 0) {
    return cannot_read(file, errno == ENOENT ? "no such file; check the path"
                                             : "cannot be opened: " + reason(errno));
  }
  struct stat status {};
  if (::fstat(in.get(), &status) != 0) return cannot_read(file, reason(errno));
  if (S_ISDIR(status.st_mode)) return cannot_read(file, "is a folder; name a file in it");
  // Pipes have no size: there, and should a file grow while it is read, the buffer follows.
  constexpr std::size_t kFirstBytes = std::size_t{1} << 16;
  std::vector<std::uint8_t> bytes(status.st_size > 0 ? static_cast<std::size_t>(status.st_size) + 1
                                                     : kFirstBytes);
  std::size_t size = 0;
  for (;;) {
    if (size == bytes.size()) bytes.resize(2 * size);
    const ssize_t got =
        ::read(in.get(), bytes.data() + size, std::min(bytes.size() - size, kTransferBytes));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return cannot_read(file, "cannot be read: " + reason(errno));
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace nacre::io
