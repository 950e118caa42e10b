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
/// coordinates; the format is recognised by content, then by extension. STL corners stay unwelded,
/// faces with a repeated corner stay in; what is left out is counted or named in the report.
///
/// Ensures  (1) at least one triangle, every index in range, every coordinate within +-1e30
///          (2) triangles in the file's order, polygons cut in place, the winding kept
///          (3) positions relative to `origin`, which is zero unless the centre of the triangles'
///              bounding box is farther from zero than 16 of its diagonals
/// Cost     the file's bytes, plus 24 bytes a vertex and 12 a triangle.
/// Errors   kUnreadableFile: one line with file, place, what was expected and found, and remedy;
///          `where` is the line of a text or the byte. kLimitExceeded if memory runs out.
[[nodiscard]] Result<ReadResult> read_scan(const std::filesystem::path& file);

}  // namespace nacre::io
