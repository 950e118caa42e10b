// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <vector>

#include "io/formats.h"
#include "io/soup.h"
#include "io/text.h"

namespace nacre::io {
namespace {

// What one vertex and one face take at least: "0 0 0\n", and "0\n" for a face of no corners.
constexpr std::size_t kMinVertexBytes = 6;
constexpr std::size_t kMinFaceBytes = 2;

class OffReader {
 public:
  explicit OffReader(const Source& source)
      : source_(source), text_(source.bytes, {.comment = '#', .continuation = false}) {}

  Result<ReadResult> read() {
    if (Result<void> done = read_header(); !done) return done.error();
    if (Result<void> done = read_vertices(); !done) return done.error();
    if (Result<void> done = read_faces(); !done) return done.error();
    return std::move(soup_).finish(source_, "off");
  }

 private:
  /// [ST][C][N][4][n]OFF, which may be left out, then the counts of vertices, faces and, mostly,
  /// edges, on the same line or a later one.
  Result<void> read_header() {
    std::string_view word = text_.word();
    if (word.ends_with("OFF")) {
      std::string_view prefix = word.substr(0, word.size() - 3);
      const auto takes = [&](std::string_view part, const char* what) {
        if (!prefix.starts_with(part)) return;
        prefix.remove_prefix(part.size());
        soup_.note_not_carried(what);
        has_extras_ = true;
      };
      takes("ST", "texture coordinates");
      takes("C", "vertex colour");
      takes("N", "vertex normal");
      if (!prefix.empty()) {
        return fail("expected OFF, COFF, NOFF or STOFF, found " + quote(word) +
                    "; convert it to three-dimensional OFF");
      }
      word = text_.word();
      if (word == "BINARY")
        return fail("this is a binary OFF; convert it to an ascii OFF or to PLY");
    }
    if (Result<void> done = read_count(word, "vertex", vertex_count_); !done) return done;
    if (Result<void> done = read_count(text_.word(), "face", face_count_); !done) return done;
    text_.next_line();
    const std::size_t left = text_.bytes_left() + 1;  // the last line may lack its end
    if (vertex_count_ >= kNone || vertex_count_ > left / kMinVertexBytes ||
        face_count_ > (left - vertex_count_ * kMinVertexBytes) / kMinFaceBytes) {
      return fail("the header promises " + std::to_string(vertex_count_) + " vertices and " +
                  std::to_string(face_count_) + " faces, but only " + std::to_string(left - 1) +
                  " bytes follow; " + kRemedyCut);
    }
    return {};
  }

  Result<void> read_count(std::string_view word, const char* what, std::size_t& count) {
    std::int64_t value = 0;
    if (!parse_integer(word, value) || value < 0) {
      return fail("expected the " + std::string(what) + " count of an OFF file, found " +
                  found(word) + "; check that this is an OFF file");
    }
    count = static_cast<std::size_t>(value);
    return {};
  }

  // One vertex a line: what follows x y z there (normals, colours) is told apart by nothing else.
  Result<void> read_vertices() {
    soup_.positions.resize(vertex_count_);
    for (std::size_t v = 0; v < vertex_count_; ++v) {
      for (int k = 0; k < 3; ++k) {
        double& x = soup_.positions[v][k];
        const std::string_view word = text_.word();
        if (parse_number(word, x) && is_usable_coordinate(x)) continue;
        const std::string place = std::string(1, "xyz"[k]) + " of vertex " + std::to_string(v);
        return fail("expected a finite number for " + place + " of " +
                    std::to_string(vertex_count_) + ", found " + found(word) + "; " + remedy(word));
      }
      if (!text_.at_line_end()) {
        if (!has_extras_) soup_.note_not_carried("values after x y z");
        has_extras_ = true;
        text_.next_line();
      }
    }
    return {};
  }

  Result<void> read_faces() {
    soup_.reserve_triangles(std::min(face_count_, text_.bytes_left() / 6 + 1));
    std::vector<std::uint32_t> corners;
    for (std::size_t f = 0; f < face_count_; ++f) {
      const std::string_view word = text_.word();
      std::int64_t count = 0;
      if (!parse_integer(word, count) || count < 0) {
        return fail("expected the corner count of " + face_name(f) + ", found " + found(word) +
                    "; " + remedy(word));
      }
      corners.clear();
      for (std::int64_t k = 0; k < count; ++k) {
        const std::string_view corner = text_.word();
        std::int64_t index = 0;
        if (!parse_integer(corner, index)) {
          return fail("expected corner " + std::to_string(k + 1) + " of the " +
                      std::to_string(count) + " of " + face_name(f) + ", found " + found(corner) +
                      "; " + remedy(corner));
        }
        if (index < 0 || static_cast<std::uint64_t>(index) >= vertex_count_) {
          return fail("face " + std::to_string(f) + " names vertex " + std::to_string(index) +
                      ", but the " + std::to_string(vertex_count_) + " vertices count from 0; " +
                      kRemedyExport);
        }
        corners.push_back(static_cast<std::uint32_t>(index));
      }
      soup_.add_face(corners);
      if (!text_.at_line_end()) {
        soup_.note_not_carried("face colour");
        text_.next_line();
      }
    }
    return {};
  }

  [[nodiscard]] Error fail(const std::string& what) const {
    return error_at_line(source_, text_.line(), what);
  }
  static std::string found(std::string_view word) {
    return word.empty() ? "the end of the file" : quote(word);
  }
  static const char* remedy(std::string_view word) {
    return word.empty() ? kRemedyCut : kRemedyExport;
  }
  [[nodiscard]] std::string face_name(std::size_t f) const {
    return "face " + std::to_string(f) + " of " + std::to_string(face_count_);
  }

  const Source& source_;
  Text text_;
  Soup soup_;
  std::size_t vertex_count_ = 0;
  std::size_t face_count_ = 0;
  bool has_extras_ = false;  // as the header says, or found
};

}  // namespace

Result<ReadResult> read_off(const Source& source) { return OffReader(source).read(); }

}  // namespace nacre::io
