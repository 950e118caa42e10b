// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>

#include "base/result.h"

namespace nacre::io {

/// A file in memory, and its name for messages.
struct Source {
  std::string name;
  std::string_view bytes;
};

/// No scan is larger than this in any unit; beyond it lie misread bytes, and squares that overflow.
inline constexpr double kLargestCoordinate = 1e30;

/// False for NaN as well.
inline bool is_usable_coordinate(double x) { return std::abs(x) <= kLargestCoordinate; }

/// A piece of the file for a one-line message: short, printable, in quotes.
[[nodiscard]] std::string quote(std::string_view text);

/// "NAME: line N: WHAT", kUnreadableFile.
[[nodiscard]] Error error_at_line(const Source& source, std::size_t line, const std::string& what);

/// "NAME: byte N: WHAT", kUnreadableFile.
[[nodiscard]] Error error_at_byte(const Source& source, std::size_t byte, const std::string& what);

// Remedies that several readers give.
inline constexpr const char* kRemedyCut = "the file is cut short: copy or download it again";
inline constexpr const char* kRemedyExport = "export the mesh again";

}  // namespace nacre::io
