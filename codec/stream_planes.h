// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "codec/stream_format.h"

namespace nacre::codec {

/// Whether base positions are told by planes (FORMAT.md section 19) instead of section 8.
[[nodiscard]] inline bool has_planes(const Header& header) {
  return header.profile == Profile::kBest && header.levels == 0;
}

}  // namespace nacre::codec
