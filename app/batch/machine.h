// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace nacre::app::batch {

/// Processors that this process may use: its affinity mask.
[[nodiscard]] int usable_threads();

/// Bytes that may be used now: the machine's available memory, or what the control groups of this
/// process leave if that is less; a tenth is left to others. 0 if nothing is known.
[[nodiscard]] std::uint64_t usable_memory();

}  // namespace nacre::app::batch
