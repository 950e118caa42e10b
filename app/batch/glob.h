// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

namespace nacre::app::batch {

/// Whether a pattern names a path, both with '/' between the parts. `*` is any run of characters of
/// one part, `?` one of them, `**` any number of whole parts. A pattern without '/' is compared
/// with the last part alone, so that "*.ply" means every PLY at any depth.
[[nodiscard]] bool glob_match(std::string_view pattern, std::string_view path);

}  // namespace nacre::app::batch
