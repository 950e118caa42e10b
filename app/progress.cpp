// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace nacre::app {
namespace {

constexpr auto kRedrawInterval = std::chrono::milliseconds(80);

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

std::string progress_line(std::string_view stage, double fraction) {
  constexpr int kWidth = 30;
  const double share = std::isfinite(fraction) ? std::clamp(fraction, 0.0, 1.0) : 0.0;
  const int filled = static_cast<int>(std::floor(share * kWidth));
  return fmt::format("{:<20} [{:<{}}] {:3.0f} %", stage,
                     std::string(static_cast<std::size_t>(filled), '#'), kWidth,
                     std::floor(share * 100));
}

Console::Console(Verbosity verbosity, const std::atomic<bool>& cancel)
    : verbosity_(verbosity), cancel_(cancel) {
  bar_ = verbosity != Verbosity::kQuiet && stderr_can_redraw();
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
  }
  return context;
}

void Console::draw(std::string_view stage, double fraction) {
  const auto now = std::chrono::steady_clock::now();
  if (drawn_ && stage == stage_ && fraction < 1 && now - last_draw_ < kRedrawInterval) return;
  stage_ = stage;
  last_draw_ = now;
  drawn_ = true;
  const std::string line = progress_line(stage, fraction);
  put(color_ ? fmt::format("\r\x1b[36m{}\x1b[0m\x1b[K", line) : fmt::format("\r{}\x1b[K", line));
  std::fflush(stderr);
}

void Console::erase() {
  if (!drawn_) return;
  put("\r\x1b[K");
  drawn_ = false;
}

}  // namespace nacre::app
