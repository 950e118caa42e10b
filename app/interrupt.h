// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>

namespace nacre::app {

/// From now on SIGINT and SIGTERM set the returned flag, which stages poll; a second signal ends
/// the process at once, with exit code 75. Outputs are written last and by rename, so either way
/// nothing half-made is left behind.
const std::atomic<bool>& install_interrupt_handler();

/// Sets that flag, as a signal would.
void request_stop();

}  // namespace nacre::app
