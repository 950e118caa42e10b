// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>

/// Checks of numbers, for the files that see CLI11.
namespace nacre::app {

/// Refuses what is not from `low` to `high`, which `description` says in words. CLI11's own range
/// check lets "nan" pass and names its bounds in 300 digits.
[[nodiscard]] inline CLI::Validator number_within(double low, double high,
                                                  const char* description) {
  const auto check = [=](const std::string& text) {
    double value = 0;
    const bool fine = CLI::detail::lexical_cast(text, value) && value >= low && value <= high;
    return fine ? std::string() : fmt::format("'{}' is not {}", text, description);
  };
  return CLI::Validator(check, "");
}

/// Nothing a scan or a run can be measured by is outside of this.
[[nodiscard]] inline CLI::Validator positive_number() {
  return number_within(1e-300, 1e300, "a positive number");
}

}  // namespace nacre::app
