// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/scan.h"

/// Mesh files in. Writing is in io/write.h, which the decoding half shares. See README.md.
namespace nacre::io {

struct ReadReport {
  std::string format;  ///< "ply-ascii", "ply-le", "ply-be", "obj", "off", "stl-ascii", "stl-binary"
  std::size_t file_bytes = 0;
  std::size_t polygons_triangulated = 0;  ///< faces with more than three corners
  std::size_t faces_skipped = 0;          ///< faces with fewer than three corners
  std::vector<std::string> not_carried;   ///< properties that nacre does not keep, by name
};

struct ReadResult {
  Scan scan;
  ReadReport report;
};

/// Reads PLY (ascii, both binary orders), OBJ, OFF or STL as a triangle soup with double
/// coordinates; the format is recognised by content, then by extension. STL corners stay unwelded.
///
/// Ensures  every index in range, every coordinate finite; positions relative to `origin`, which is
///          zero unless the bounding box is farther from zero than 16 of its diagonals.
/// Errors   kUnreadableFile with file, place (line or byte) and remedy.
[[nodiscard]] Result<ReadResult> read_scan(const std::filesystem::path& file);

}  // namespace nacre::io
