// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>

/// What the readers of text formats share: a cursor over words and lines, and number parsing that
/// does not depend on the locale.
namespace nacre::io {

/// A cursor over a text. Lines end with LF, CR LF or CR alone; a byte order mark is skipped.
class Text {
 public:
  struct Syntax {
    char comment = '\0';        ///< starts a comment that runs to the end of the line; 0: none
    bool continuation = false;  ///< a backslash before the end of a line joins it with the next
  };

  explicit Text(std::string_view text, Syntax syntax)
      : at_(text.data()), end_(text.data() + text.size()), syntax_(syntax) {
    if (text.substr(0, 3) == "\xEF\xBB\xBF") at_ += 3;
  }
  explicit Text(std::string_view text) : Text(text, Syntax{}) {}

  /// Line of the word read last, from 1.
  [[nodiscard]] std::size_t line() const { return line_; }
  void set_line(std::size_t line) { line_ = line; }
  [[nodiscard]] std::size_t bytes_left() const { return static_cast<std::size_t>(end_ - at_); }

  /// The next word on this line; empty at the end of the line.
  std::string_view word_on_line() {
    skip_blanks();
    const char* const start = at_;
    while (at_ != end_ && !is_space(*at_) && !is_comment(*at_)) ++at_;
    return {start, static_cast<std::size_t>(at_ - start)};
  }

  /// The next word on this line or a later one; empty at the end of the text.
  std::string_view word() {
    for (;;) {
      const std::string_view found = word_on_line();
      if (!found.empty() || at_ == end_) return found;
      next_line();
    }
  }

  /// Moves past the end of this line.
  void next_line() {
    while (at_ != end_ && !is_line_end(at_)) ++at_;
    if (at_ == end_) return;
    ++at_;
    ++line_;
  }

  /// True if no word is left on this line.
  [[nodiscard]] bool at_line_end() {
    skip_blanks();
    return at_ == end_ || is_line_end(at_);
  }

 private:
  static bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }
  [[nodiscard]] bool is_comment(char c) const { return c == syntax_.comment && c != '\0'; }
  /// The CR of a CR LF is a blank; the LF ends the line.
  [[nodiscard]] bool is_line_end(const char* p) const {
    return *p == '\n' || (*p == '\r' && (p + 1 == end_ || p[1] != '\n'));
  }
  void skip_blanks() {
    while (at_ != end_) {
      if (is_comment(*at_)) {
        while (at_ != end_ && !is_line_end(at_)) ++at_;
        return;
      }
      if (syntax_.continuation && *at_ == '\\' && skip_continuation()) continue;
      if (!is_space(*at_) || is_line_end(at_)) return;
      ++at_;
    }
  }
  bool skip_continuation() {
    const char* p = at_ + 1;
    while (p != end_ && is_space(*p) && !is_line_end(p)) ++p;
    if (p == end_ || !is_line_end(p)) return false;
    at_ = p + 1;
    ++line_;
    return true;
  }

  const char* at_;
  const char* end_;
  Syntax syntax_;
  std::size_t line_ = 1;
};

/// True if a decimal number too large or too small for a double is too large.
inline bool is_too_large(std::string_view number) {
  const std::size_t e = number.find_first_of("eE");
  const std::string_view mantissa = number.substr(0, e);
  long long exponent = 0;
  if (e != std::string_view::npos) {
    std::string_view digits = number.substr(e + 1);
    if (!digits.empty() && digits[0] == '+') digits.remove_prefix(1);
    const auto parsed = std::from_chars(digits.data(), digits.data() + digits.size(), exponent);
    if (parsed.ec != std::errc{}) return digits.empty() || digits[0] != '-';
  }
  // The place of the first digit that is not 0 decides where the exponent does not.
  const std::size_t first = mantissa.find_first_of("123456789");
  if (first == std::string_view::npos) return false;
  const std::size_t dot = mantissa.find('.');
  const auto place = static_cast<long long>(dot == std::string_view::npos ? mantissa.size() : dot) -
                     static_cast<long long>(first);
  return exponent > -place;
}

/// Reads all of `word` as a number; "nan" and "inf" count, too large becomes infinite and too small
/// zero. False if it is not one number.
inline bool parse_number(std::string_view word, double& value) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const char* const end = word.data() + word.size();
  const auto parsed = std::from_chars(word.data(), end, value);
  if (parsed.ptr != end) return false;
  if (parsed.ec == std::errc::result_out_of_range) {
    value = is_too_large(word) ? std::numeric_limits<double>::infinity() : 0.0;
    return true;
  }
  return parsed.ec == std::errc{};
}

inline bool parse_integer(std::string_view word, std::int64_t& value) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const char* const end = word.data() + word.size();
  const auto parsed = std::from_chars(word.data(), end, value);
  return parsed.ptr == end && parsed.ec == std::errc{};
}

}  // namespace nacre::io
