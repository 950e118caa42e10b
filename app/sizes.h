// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/result.h"

/// Byte sizes and counts as people write them. Independent of the locale.
namespace nacre::app {

/// "6061", "6k" = 6,000, "6Ki" = 6,144, "1.5M"; also G and Gi, a trailing B, any case. A fraction
/// of a byte is dropped, exactly (no floating point).
///
/// Errors   kBadInput for anything else, zero, or more than 2^62 bytes.
[[nodiscard]] Result<std::uint64_t> parse_size(std::string_view text);

/// Three significant digits in powers of 1000: "512 B", "6.06 kB", "22.9 MB".
[[nodiscard]] std::string format_bytes(std::uint64_t bytes);

/// "1,204,331"
[[nodiscard]] std::string format_count(std::uint64_t count);

}  // namespace nacre::app
