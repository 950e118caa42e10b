// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace CLI {
class App;
}

/// What the command line looks like, told to shells and to man, from the parser itself.
namespace nacre::app {

/// Completions of all verbs, options and their known values, for "bash", "zsh" or "fish"; of
/// anything else file names. "man": the manual page, docs/nacre.1.
[[nodiscard]] std::string completion_script(const CLI::App& app, std::string_view shell);

}  // namespace nacre::app
