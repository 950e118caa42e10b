// SPDX-License-Identifier: GPL-3.0-or-later
#include <array>
#include <limits>
#include <vector>

#include "io/formats.h"
#include "io/soup.h"
#include "io/text.h"

namespace nacre::io {
namespace {

class ObjReader {
 public:
  explicit ObjReader(const Source& source)
      : source_(source), text_(source.bytes, {.comment = '#', .continuation = true}) {}

  Result<ReadResult> read() {
    while (text_.bytes_left() > 0) {
      const std::string_view keyword = text_.word_on_line();
      Result<void> done;
      if (keyword == "v") {
        done = read_vertex();
      } else if (keyword == "f" || keyword == "fo") {
        done = read_face();
      } else if (!keyword.empty()) {
        note_statement(keyword);
      }
      if (!done) return done.error();
      text_.next_line();
    }
    if (largest_.index > soup_.positions.size()) {
      return out_of_range(largest_.line, largest_.face, std::to_string(largest_.index));
    }
    return std::move(soup_).finish(source_, "obj");
  }

 private:
  Result<void> read_vertex() {
    Vec3 p;
    for (int k = 0; k < 3; ++k) {
      const std::string_view word = text_.word_on_line();
      if (!parse_number(word, p[k]) || !is_usable_coordinate(p[k])) {
        return error_at_line(source_, text_.line(),
                             "expected a finite number for " + std::string(1, "xyz"[k]) +
                                 " of vertex " + std::to_string(soup_.positions.size() + 1) +
                                 ", found " + (word.empty() ? "the end of the line" : quote(word)) +
                                 "; " + kRemedyExport);
      }
    }
    // x y z w is a weight that only curves use; x y z r g b is a colour many scanners write.
    if (!text_.at_line_end()) {
      int more = 0;
      while (more < 3 && !text_.word_on_line().empty()) ++more;
      soup_.note_not_carried(more == 3 ? "vertex colour" : "vertex weight");
    }
    if (soup_.positions.size() >= kNone - 1) {
      return error_at_line(source_, text_.line(), "more than 2^32 - 2 vertices; split the mesh");
    }
    soup_.positions.push_back(p);
    return {};
  }

  Result<void> read_face() {
    corners_.clear();
    for (;;) {
      const std::string_view word = text_.word_on_line();
      if (word.empty()) break;
      const std::string_view number = word.substr(0, word.find('/'));
      if (number.size() != word.size()) soup_.note_not_carried("face texture or normal indices");
      std::int64_t index = 0;
      if (!parse_integer(number, index)) {
        return error_at_line(source_, text_.line(),
                             "expected a vertex number in face " + face_name() + ", found " +
                                 quote(word) + "; " + kRemedyExport);
      }
      const auto count = static_cast<std::int64_t>(soup_.positions.size());
      if (index < 0 && index >= -count) index += count + 1;
      if (index < 1 || index >= kNone) {
        return out_of_range(text_.line(), soup_.face_count() + 1, std::string(number));
      }
      // A face may come before its vertices, so the last word on its range falls at the end.
      if (static_cast<std::uint64_t>(index) > largest_.index) {
        largest_ = {static_cast<std::uint64_t>(index), text_.line(), soup_.face_count() + 1};
      }
      corners_.push_back(static_cast<std::uint32_t>(index - 1));
    }
    soup_.add_face(corners_);
    return {};
  }

  void note_statement(std::string_view keyword) {
    static constexpr std::array<std::string_view, 14> kKnown = {
        "vt", "vn",     "vp",     "g",    "o",     "s",    "l",
        "p",  "usemtl", "mtllib", "curv", "curv2", "surf", "cstype"};
    for (const std::string_view known : kKnown) {
      if (keyword == known) return soup_.note_not_carried(known);
    }
    soup_.note_not_carried("unknown statement " + quote(keyword));
  }

  Error out_of_range(std::size_t line, std::size_t face, const std::string& index) const {
    return error_at_line(source_, line,
                         "face " + std::to_string(face) + " names vertex " + index +
                             ", but there are " + std::to_string(soup_.positions.size()) +
                             " vertices" + (index[0] == '-' ? " before it; " : "; ") +
                             kRemedyExport);
  }
  [[nodiscard]] std::string face_name() const { return std::to_string(soup_.face_count() + 1); }

  struct Largest {
    std::uint64_t index = 0;
    std::size_t line = 0, face = 0;
  };
  const Source& source_;
  Text text_;
  Soup soup_;
  Largest largest_;
  std::vector<std::uint32_t> corners_;
};

}  // namespace

Result<ReadResult> read_obj(const Source& source) { return ObjReader(source).read(); }

}  // namespace nacre::io
