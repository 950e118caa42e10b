// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/sizes.h"

#include <fmt/format.h>

#include <cctype>
#include <cstddef>
#include <optional>

namespace nacre::app {
namespace {

constexpr std::uint64_t kMaxBytes = std::uint64_t{1} << 62;

/// The factor that a suffix stands for.
std::optional<std::uint64_t> unit_of(std::string_view suffix) {
  std::string unit;
  for (const char c : suffix) {
    unit.push_back(static_cast<char>(std::tolower(static_cast<unsigned char>(c))));
  }
  if (!unit.empty() && unit.back() == 'b') unit.pop_back();
  if (unit.empty()) return 1;
  if (unit == "k") return 1'000;
  if (unit == "m") return 1'000'000;
  if (unit == "g") return 1'000'000'000;
  if (unit == "ki") return std::uint64_t{1} << 10;
  if (unit == "mi") return std::uint64_t{1} << 20;
  if (unit == "gi") return std::uint64_t{1} << 30;
  return std::nullopt;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

Result<std::uint64_t> parse_size(std::string_view text) {
  const Error bad{
      ErrorCode::kBadInput,
      fmt::format("'{}' is not a size: write bytes, or 6k (= 6000), 6Ki (= 6144), 1.5M", text)};
  std::size_t i = 0;
  std::uint64_t whole = 0;
  for (; i < text.size() && is_digit(text[i]); ++i) {
    if (whole > kMaxBytes / 16) return bad;
    whole = whole * 10 + static_cast<std::uint64_t>(text[i] - '0');
  }
  const std::size_t whole_digits = i;
  // Nine decimals: numerator times the largest unit, 2^30, still fits in 64 bits.
  std::uint64_t numerator = 0, denominator = 1;
  if (i < text.size() && text[i] == '.') {
    for (++i; i < text.size() && is_digit(text[i]); ++i) {
      if (denominator == 1'000'000'000) return bad;
      numerator = numerator * 10 + static_cast<std::uint64_t>(text[i] - '0');
      denominator *= 10;
    }
  }
  if (whole_digits == 0 && denominator == 1) return bad;
  const std::optional<std::uint64_t> unit = unit_of(text.substr(i));
  if (!unit || whole > kMaxBytes / *unit) return bad;
  const std::uint64_t bytes = whole * *unit + numerator * *unit / denominator;
  if (bytes == 0 || bytes > kMaxBytes) return bad;
  return bytes;
}

std::string format_bytes(std::uint64_t bytes) {
  if (bytes < 1000) return fmt::format("{} B", bytes);
  constexpr std::string_view kUnits[] = {"kB", "MB", "GB", "TB", "PB", "EB"};
  double value = static_cast<double>(bytes) / 1000.0;
  std::size_t unit = 0;
  while (value >= 999.5 && unit + 1 < std::size(kUnits)) {
    value /= 1000.0;
    ++unit;
  }
  const int decimals = value < 9.995 ? 2 : value < 99.95 ? 1 : 0;
  return fmt::format("{:.{}f} {}", value, decimals, kUnits[unit]);
}

std::string format_count(std::uint64_t count) {
  std::string digits = std::to_string(count);
  for (std::size_t i = digits.size(); i > 3;) {
    i -= 3;
    digits.insert(i, 1, ',');
  }
  return digits;
}

}  // namespace nacre::app
