// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

namespace nacre::app {
namespace {

constexpr auto kRedrawInterval = std::chrono::milliseconds(80);
constexpr auto kJsonInterval = std::chrono::seconds(1);
/// Before this much of a stage, nothing is said of what is left of it.
constexpr double kLeastSpent = 1.0, kLeastDone = 0.05;

bool set_in_environment(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr && *value != '\0';
}

bool stderr_can_redraw() {
  const char* term = std::getenv("TERM");
  return isatty(STDERR_FILENO) == 1 && term != nullptr && std::string_view(term) != "dumb";
}

void put(std::string_view text) { std::fwrite(text.data(), 1, text.size(), stderr); }

}  // namespace

std::string format_duration(double seconds) {
  const auto whole = static_cast<std::int64_t>(std::ceil(std::clamp(seconds, 0.0, 1e9)));
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole % 3600 / 60);
}

std::string progress_line(std::string_view stage, double fraction, double seconds_left) {
  constexpr int kWidth = 30;
  const double share = std::isfinite(fraction) ? std::clamp(fraction, 0.0, 1.0) : 0.0;
  const int filled = static_cast<int>(std::floor(share * kWidth));
  std::string line = fmt::format("{:<20} [{:<{}}] {:3.0f} %", stage,
                                 std::string(static_cast<std::size_t>(filled), '#'), kWidth,
                                 std::floor(share * 100));
  if (seconds_left >= 0) line += fmt::format("  {} left", format_duration(seconds_left));
  return line;
}

Console::Console(Verbosity verbosity, const std::atomic<bool>& cancel, ProgressStyle style)
    : verbosity_(verbosity), cancel_(cancel) {
  bar_ = style == ProgressStyle::kAuto && verbosity != Verbosity::kQuiet && stderr_can_redraw();
  json_ = style == ProgressStyle::kJson;
  color_ = bar_ && !set_in_environment("NO_COLOR");
}

Console::~Console() { erase(); }

void Console::note(std::string_view line) {
  if (verbosity_ == Verbosity::kQuiet) return;
  erase();
  put(fmt::format("{}\n", line));
}

void Console::detail(std::string_view line) {
  if (verbose()) note(line);
}

void Console::warning(std::string_view line) {
  erase();
  put(color_ ? fmt::format("\x1b[33mwarning:\x1b[0m {}\n", line)
             : fmt::format("warning: {}\n", line));
}

RunContext Console::context() {
  RunContext context;
  context.cancel = &cancel_;
  if (bar_) {
    context.progress = [this](std::string_view stage, double fraction) { draw(stage, fraction); };
  } else if (json_) {
    context.progress = [this](std::string_view stage, double fraction) {
      print_json(stage, fraction);
    };
  }
  return context;
}

double Console::seconds_left(std::string_view stage, double fraction, Clock::time_point now) {
  if (stage != stage_ || fraction < last_fraction_) {  // begins, or begins again
    stage_begin_ = now;
    first_fraction_ = fraction;
  }
  last_fraction_ = fraction;
  const double spent = std::chrono::duration<double>(now - stage_begin_).count();
  const double done = fraction - first_fraction_;
  if (spent < kLeastSpent || done < kLeastDone) return -1;
  return spent * std::max(1 - fraction, 0.0) / done;
}

void Console::draw(std::string_view stage, double fraction) {
  const auto now = Clock::now();
  const double left = seconds_left(stage, fraction, now);
  if (drawn_ && stage == stage_ && fraction < 1 && now - last_draw_ < kRedrawInterval) return;
  stage_ = stage;
  last_draw_ = now;
  drawn_ = true;
  const std::string line = progress_line(stage, fraction, left);
  put(color_ ? fmt::format("\r\x1b[36m{}\x1b[0m\x1b[K", line) : fmt::format("\r{}\x1b[K", line));
  std::fflush(stderr);
}

void Console::print_json(std::string_view stage, double fraction) {
  const auto now = Clock::now();
  const double left = seconds_left(stage, fraction, now);
  if (stage == stage_ && now - last_draw_ < kJsonInterval) return;
  stage_ = stage;
  last_draw_ = now;
  // Names of stages are our own and need no escapes.
  const std::string left_text = left < 0 ? "null" : fmt::format("{:.1f}", left);
  put(
      fmt::format("{{\"progress\": {{\"stage\": \"{}\", \"fraction\": {:.3f}, "
                  "\"elapsed_seconds\": {:.1f}, \"stage_seconds_left\": {}}}}}\n",
                  stage, std::isfinite(fraction) ? std::clamp(fraction, 0.0, 1.0) : 0.0,
                  std::chrono::duration<double>(now - begin_).count(), left_text));
}

void Console::erase() {
  if (!drawn_) return;
  put("\r\x1b[K");
  drawn_ = false;
}

}  // namespace nacre::app
