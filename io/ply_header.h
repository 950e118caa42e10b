// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "io/source.h"

namespace nacre::io {

enum class PlyType : std::uint8_t {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat,
  kDouble
};
enum class PlyOrder : std::uint8_t { kAscii, kLittleEndian, kBigEndian };

[[nodiscard]] constexpr std::size_t byte_size(PlyType type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat;  ///< of the value, or of a list's entries
  bool is_list = false;
  PlyType count_type = PlyType::kUint8;  ///< an integer type; lists only
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  /// The index of a property, or properties.size().
  [[nodiscard]] std::size_t find(std::string_view property) const;
};

struct PlyHeader {
  PlyOrder order = PlyOrder::kAscii;
  std::vector<PlyElement> elements;
  std::size_t body = 0;       ///< byte offset of the first value
  std::size_t body_line = 0;  ///< line number of the first value, for ascii
};

/// Errors   kUnreadableFile with the line.
[[nodiscard]] Result<PlyHeader> read_ply_header(const Source& source);

}  // namespace nacre::io
