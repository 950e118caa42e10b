// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "base/scan.h"

/// Draco in process, where its library is there (Debian: libdraco-dev).
namespace nacre::bench {

/// The scan with positions in so many bits, at a compression level from 0 to 10 (as
/// draco_encoder -cl); nothing without the library, or if Draco refuses.
[[nodiscard]] std::optional<std::vector<char>> draco_encode(const Scan& scan, int position_bits,
                                                            int level);

/// Decodes; vertices of the mesh.
[[nodiscard]] std::size_t draco_decode(const std::vector<char>& bytes);

}  // namespace nacre::bench
