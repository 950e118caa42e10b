// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "base/result.h"

namespace nacre::app::batch {

/// XXH3, 128 bits, as 32 hexadecimal digits; what `xxhsum -H2` prints. It finds changed files and
/// is no proof against somebody who makes two files with one hash.
[[nodiscard]] std::string hash_of(std::string_view bytes);

/// Errors   kUnreadableFile.
[[nodiscard]] Result<std::string> hash_file(const std::filesystem::path& file);

}  // namespace nacre::app::batch
