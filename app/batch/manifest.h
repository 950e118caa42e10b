// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"

namespace nacre::app::batch {

/// One scan to encode.
struct Item {
  std::string scan;    ///< below Manifest::input_root, or absolute
  std::string output;  ///< below Manifest::output_root, ends in ".ncr"; no two items have the same
  std::vector<std::string> options;  ///< words of `nacre encode`
  std::uint64_t file_bytes = 0;      ///< when planned
  std::uint64_t triangles = 0;       ///< from the header, or guessed from the bytes
  bool triangles_from_header = false;

  bool operator==(const Item&) const = default;
};

/// What a batch shall do. A text file of JSON lines: first the roots, then one line per scan, so
/// that grep, split, jq and an editor work on it.
struct Manifest {
  std::filesystem::path input_root, output_root;  ///< absolute
  std::vector<Item> items;                        ///< sorted by output
};

[[nodiscard]] std::string to_json_lines(const Manifest& manifest);

/// Errors   kUnreadableFile with file and line: no such file, not JSON, a field is missing or of
///          another type, an output leaves its root or is another's too, a newer schema.
[[nodiscard]] Result<Manifest> read_manifest(const std::filesystem::path& file);

[[nodiscard]] std::filesystem::path scan_path(const Manifest& manifest, const Item& item);
[[nodiscard]] std::filesystem::path output_path(const Manifest& manifest, const Item& item);

}  // namespace nacre::app::batch
