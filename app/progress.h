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
/// warnings. NO_COLOR (any non-empty value) turns colour off. JSON progress needs no terminal and
/// no -q stops it.
class Console {
 public:
  Console(Verbosity verbosity, const std::atomic<bool>& cancel,
          ProgressStyle style = ProgressStyle::kAuto);
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
  using Clock = std::chrono::steady_clock;
  void draw(std::string_view stage, double fraction);
  void print_json(std::string_view stage, double fraction);
  /// Seconds that the stage has left if it goes on as it went so far; < 0: too early to say.
  [[nodiscard]] double seconds_left(std::string_view stage, double fraction, Clock::time_point now);
  void erase();

  Verbosity verbosity_;
  const std::atomic<bool>& cancel_;
  bool bar_ = false, color_ = false, drawn_ = false, json_ = false;
  std::string stage_;
  double last_fraction_ = 0, first_fraction_ = 0;
  Clock::time_point begin_ = Clock::now(), last_draw_, stage_begin_;
};

/// One line of a progress bar without colour or line end: "remesh  [#####     ]  50 %  12 s left".
/// The time is left out if it is negative.
[[nodiscard]] std::string progress_line(std::string_view stage, double fraction,
                                        double seconds_left = -1);

/// "12 s", "3 min 20 s", "1 h 5 min"
[[nodiscard]] std::string format_duration(double seconds);

}  // namespace nacre::app
