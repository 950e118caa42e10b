// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "base/scan.h"
#include "io/formats.h"
#include "io/io.h"
#include "io/write.h"

namespace nacre::io {

/// A folder that goes with the test.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "nacre_io_XXXXXX").string();
    path_ = ::mkdtemp(pattern.data());
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const {
    return path_ / name;
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::size_t entry_count() const {
    const std::filesystem::directory_iterator files(path_);
    return static_cast<std::size_t>(std::distance(begin(files), end(files)));
  }

 private:
  std::filesystem::path path_;
};

inline std::vector<std::uint8_t> bytes_of(std::string_view text) {
  return {text.begin(), text.end()};
}

inline std::string text_of(const std::vector<std::uint8_t>& bytes) {
  return {bytes.begin(), bytes.end()};
}

/// Reads `content` as a file called `name`.
inline Result<ReadResult> read_as(const std::string& name, std::string_view content) {
  const TemporaryFolder folder;
  std::ofstream(folder / name, std::ios::binary) << content;
  return read_scan(folder / name);
}

inline Result<ReadResult> read_as(const std::string& name,
                                  const std::vector<std::uint8_t>& content) {
  return read_as(name, text_of(content));
}

/// Appends values as they lie in memory, or with their bytes reversed.
template <class T>
void append(std::string& out, T value, bool swap = false) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  if (swap) std::reverse(raw, raw + sizeof value);
  out.append(raw, sizeof value);
}

/// Expects the failure and its place, and that the message is one line with the file and `part`.
inline void expect_unreadable(const Result<ReadResult>& result, std::size_t where,
                              const std::string& part) {
  ASSERT_FALSE(result.has_value()) << "accepted; expected: " << part;
  EXPECT_EQ(result.error().code, ErrorCode::kUnreadableFile);
  EXPECT_EQ(result.error().where, where) << result.error().message;
  EXPECT_NE(result.error().message.find(part), std::string::npos) << result.error().message;
  EXPECT_EQ(result.error().message.find('\n'), std::string::npos) << result.error().message;
}

/// The tetrahedron that the hand-written files below hold.
inline const std::vector<Vec3> kCorners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
inline const std::vector<Triangle> kFaces = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};

inline void expect_tetrahedron(const Result<ReadResult>& result) {
  ASSERT_TRUE(result.has_value()) << result.error().message;
  EXPECT_EQ((*result).scan.positions, kCorners);
  EXPECT_EQ((*result).scan.triangles, kFaces);
  EXPECT_TRUE((*result).scan.origin.isZero(0.0));
}

using Names = std::vector<std::string>;

}  // namespace nacre::io
