// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/source.h"

namespace nacre::io {
namespace {

constexpr std::size_t kQuotedLength = 32;

Error error_at(const Source& source, const char* kind, std::size_t where, const std::string& what) {
  return {ErrorCode::kUnreadableFile,
          source.name + ": " + kind + " " + std::to_string(where) + ": " + what, where};
}

}  // namespace

std::string quote(std::string_view text) {
  std::string result = "'";
  for (const char c : text.substr(0, kQuotedLength)) result += c >= ' ' && c <= '~' ? c : '?';
  if (text.size() > kQuotedLength) result += "...";
  return result + "'";
}

Error error_at_line(const Source& source, std::size_t line, const std::string& what) {
  return error_at(source, "line", line, what);
}

Error error_at_byte(const Source& source, std::size_t byte, const std::string& what) {
  return error_at(source, "byte", byte, what);
}

}  // namespace nacre::io
