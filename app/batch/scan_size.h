// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>

namespace nacre::app::batch {

struct ScanSize {
  std::uint64_t file_bytes = 0;
  std::uint64_t triangles = 0;
  bool from_header = false;  ///< else guessed from the bytes
};

/// How many triangles a scan has, from its first 64 kB: PLY's `element face`, OFF's counts, binary
/// STL's count, as far as the file is long enough for it; else what a file of that format and
/// length usually has. Never fails: a file that cannot be read is of size zero, and reading it
/// properly is what tells why.
[[nodiscard]] ScanSize scan_size(const std::filesystem::path& file);

}  // namespace nacre::app::batch
