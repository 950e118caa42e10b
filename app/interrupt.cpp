// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/interrupt.h"

#include <unistd.h>

#include <csignal>

#include "app/exit_code.h"

namespace nacre::app {
namespace {

std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "the handler may only touch such a flag");

void on_signal(int) {
  if (interrupted.exchange(true)) _exit(kExitInterrupted);
}

}  // namespace

void request_stop() { interrupted = true; }

const std::atomic<bool>& install_interrupt_handler() {
  struct sigaction action = {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  return interrupted;
}

}  // namespace nacre::app
