// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <malloc.h>

namespace nacre::app {

/// For main(): glibc's allocator set so that the memory in use is little more than what is asked
/// for.
inline void set_up_allocator() {
  // What one thread frees another can have.
  mallopt(M_ARENA_MAX, 1);
  // Large arrays go back to the system when they are freed; left alone, only until the first is.
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
}

}  // namespace nacre::app
