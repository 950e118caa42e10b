// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <chrono>
#include <string>
#include <string_view>

#include "app/options.h"
#include "base/run_context.h"

namespace nacre::app {

/// Everything that goes to stderr: a progress bar, and lines that do not tear it.
///
/// The bar is drawn only on a terminal (not TERM=dumb) and not with -q; -q silences notes, never
/// warnings. NO_COLOR (any non-empty value) turns colour off.
class Console {
 public:
  Console(Verbosity verbosity, const std::atomic<bool>& cancel);
  ~Console();
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  void note(std::string_view line);     ///< not with -q
  void detail(std::string_view line);   ///< only with -v
  void warning(std::string_view line);  ///< always
  [[nodiscard]] bool verbose() const { return verbosity_ == Verbosity::kVerbose; }

  /// Must not outlive the console.
  [[nodiscard]] RunContext context();
  [[nodiscard]] bool cancelled() const { return cancel_.load(); }

 private:
  void draw(std::string_view stage, double fraction);
  void erase();

  Verbosity verbosity_;
  const std::atomic<bool>& cancel_;
  bool bar_ = false, color_ = false, drawn_ = false;
  std::string stage_;
  std::chrono::steady_clock::time_point last_draw_;
};

/// One line of a progress bar without colour or line end: "remesh  [#####     ]  50 %".
[[nodiscard]] std::string progress_line(std::string_view stage, double fraction);

}  // namespace nacre::app
