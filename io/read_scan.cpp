// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <exception>
#include <new>

#include "io/formats.h"
#include "io/io.h"
#include "io/text.h"
#include "io/write.h"

namespace nacre::io {
namespace {

using Reader = Result<ReadResult> (*)(const Source&);

constexpr const char* kKnownFormats = "PLY, OBJ, OFF or STL";

std::string lower_extension(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return extension;
}

bool is_obj_keyword(std::string_view word) {
  for (const char* known : {"v", "vt", "vn", "f", "g", "o", "mtllib", "usemtl"}) {
    if (word == known) return true;
  }
  return false;
}

/// By content where that is certain, else by extension; null if neither tells.
Reader find_reader(std::string_view bytes, const std::string& extension) {
  if (bytes.starts_with("ply") && bytes.find_first_of(" \t\r\n", 3) == 3) return read_ply;
  if (extension == ".stl" || is_binary_stl(bytes)) return read_stl;
  const std::string_view word = Text(bytes, {.comment = '#', .continuation = false}).word();
  if (word.size() <= 7 && word.ends_with("OFF")) return read_off;
  if (extension == ".ply") return read_ply;
  if (extension == ".obj") return read_obj;
  if (extension == ".off") return read_off;
  if (word == "solid") return read_stl;
  return is_obj_keyword(word) ? read_obj : nullptr;
}

/// What a file of another kind most likely is, and what to do about it; empty if not known.
std::string name_other_kind(std::string_view bytes) {
  if (bytes.starts_with("\x1F\x8B") || bytes.starts_with("PK\x03\x04") ||
      bytes.starts_with("\x28\xB5\x2F\xFD") ||
      bytes.starts_with("\xFD"
                        "7zXZ")) {
    return "this is a compressed archive; unpack it first";
  }
  if (bytes.starts_with("glTF")) return "GLB is written but not read; convert it to PLY";
  return "";
}

}  // namespace

Result<ReadResult> read_scan(const std::filesystem::path& file) try {
  const Result<std::vector<std::uint8_t>> content = read_file(file);
  if (!content) return content.error();
  const Source source{file.string(),
                      {reinterpret_cast<const char*>((*content).data()), (*content).size()}};
  if (source.bytes.empty()) {
    return error_at_byte(source, 0, "the file is empty; check what wrote it");
  }
  if (const std::string kind = name_other_kind(source.bytes); !kind.empty()) {
    return error_at_byte(source, 0, kind);
  }
  const Reader reader = find_reader(source.bytes, lower_extension(file));
  if (reader == nullptr) {
    return error_at_byte(source, 0,
                         std::string("unknown format; expected ") + kKnownFormats +
                             ", so convert the mesh or correct the name's ending");
  }
  return reader(source);
} catch (const std::bad_alloc&) {
  return Error{
      ErrorCode::kLimitExceeded,
      file.string() + ": not enough memory for this mesh; simplify it or use a larger machine", 0};
} catch (const std::exception& e) {
  return Error{ErrorCode::kUnreadableFile, file.string() + ": " + e.what(), 0};
}

}  // namespace nacre::io
