// SPDX-License-Identifier: GPL-3.0-or-later
//
// Not io's readers: they want the whole file, and this is run over thousands of them.
#include "app/batch/scan_size.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

#include "app/files.h"

namespace nacre::app::batch {
namespace {

constexpr std::size_t kHeadBytes = std::size_t{1} << 16;
// Bytes of a file per triangle where nothing says their number, from the corpus: a text line each
// for the triangle and for half a vertex, or binary floats.
constexpr std::uint64_t kTextBytesPerTriangle = 40, kPlyBytesPerTriangle = 20,
                        kAsciiStlBytesPerTriangle = 250, kBinaryStlBytesPerTriangle = 50;
constexpr std::uint64_t kLeastBytesPerTriangle = 4;  // no format does with less
constexpr std::uint64_t kStlHeadBytes = 84;

std::string_view next_word(std::string_view& text) {
  constexpr const char* kBlank = " \t\r\n";
  text.remove_prefix(std::min(text.find_first_not_of(kBlank), text.size()));
  const std::string_view word = text.substr(0, text.find_first_of(kBlank));
  text.remove_prefix(word.size());
  return word;
}

std::optional<std::uint64_t> number(std::string_view word) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

std::optional<std::uint64_t> ply_faces(std::string_view head) {
  while (!head.empty()) {
    std::string_view line = head.substr(0, head.find('\n'));
    head.remove_prefix(std::min(line.size() + 1, head.size()));
    const std::string_view keyword = next_word(line);
    if (keyword == "end_header") break;
    if (keyword == "element" && next_word(line) == "face") return number(next_word(line));
  }
  return std::nullopt;
}

/// "OFF" (or COFF, NOFF, ...), comments, then vertices, faces and edges.
std::optional<std::uint64_t> off_faces(std::string_view head) {
  std::array<std::optional<std::uint64_t>, 2> counts;
  std::size_t found = 0;
  while (!head.empty() && found < counts.size()) {
    std::string_view line = head.substr(0, head.find('\n'));
    head.remove_prefix(std::min(line.size() + 1, head.size()));
    line = line.substr(0, line.find('#'));
    for (std::string_view word = next_word(line); !word.empty() && found < counts.size();
         word = next_word(line)) {
      if (word.ends_with("OFF")) continue;
      counts[found] = number(word);
      if (!counts[found++]) return std::nullopt;
    }
  }
  return found == counts.size() ? counts[1] : std::nullopt;
}

/// Of a binary STL, which is exactly as long as its count says.
std::optional<std::uint64_t> stl_triangles(std::string_view head, std::uint64_t file_bytes) {
  if (head.size() < kStlHeadBytes) return std::nullopt;
  std::uint64_t count = 0;
  for (std::size_t i = 4; i-- > 0;) {
    count = count << 8 | static_cast<unsigned char>(head[kStlHeadBytes - 4 + i]);
  }
  if (file_bytes < kStlHeadBytes + kBinaryStlBytesPerTriangle * count) return std::nullopt;
  return count;
}

}  // namespace

ScanSize scan_size(const std::filesystem::path& file) {
  ScanSize size;
  std::error_code failed;
  const std::uintmax_t bytes = std::filesystem::file_size(file, failed);
  if (failed) return size;
  size.file_bytes = bytes;
  std::string head(kHeadBytes, '\0');
  std::ifstream in(file, std::ios::binary);
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(std::max<std::streamsize>(in.gcount(), 0)));

  std::optional<std::uint64_t> count;
  std::uint64_t bytes_per_triangle = kTextBytesPerTriangle;
  if (head.starts_with("ply")) {
    count = ply_faces(head);
    bytes_per_triangle = kPlyBytesPerTriangle;
  } else if (has_extension(file, ".off")) {
    count = off_faces(head);
  } else if (has_extension(file, ".stl")) {
    const bool text = head.starts_with("solid") && head.find("facet") != std::string::npos;
    if (!text) count = stl_triangles(head, bytes);
    bytes_per_triangle = text ? kAsciiStlBytesPerTriangle : kBinaryStlBytesPerTriangle;
  }
  if (count && *count > bytes / kLeastBytesPerTriangle) count.reset();  // the file is cut, or lies
  size.from_header = count.has_value();
  size.triangles = count.value_or(bytes / bytes_per_triangle);
  return size;
}

}  // namespace nacre::app::batch
