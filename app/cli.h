// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>

#include "app/options.h"
#include "base/result.h"

namespace nacre::app {

/// Turns the arguments (without the program's name) into a command.
///
/// Ensures  the goal of an encode is set: --quality 75 if the user named none.
/// Errors   kBadInput, with the remedy: what was meant, or which --help to read.
[[nodiscard]] Result<Command> parse_command_line(std::span<const std::string> arguments);

}  // namespace nacre::app
