// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace nacre::app {

/// SHA-256 as 64 hexadecimal digits, the same that `sha256sum` prints. Source   [FIPS180-4].
[[nodiscard]] std::string sha256(std::span<const std::uint8_t> bytes);
[[nodiscard]] std::string sha256(std::string_view text);

}  // namespace nacre::app
