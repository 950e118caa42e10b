// SPDX-License-Identifier: GPL-3.0-or-later
#include <array>
#include <bit>
#include <cstring>
#include <vector>

#include "io/formats.h"
#include "io/soup.h"
#include "io/text.h"

namespace nacre::io {
namespace {

static_assert(std::endian::native == std::endian::little,
              "binary STL is read as it lies in memory");

constexpr std::size_t kHeaderBytes = 84;
constexpr std::size_t kFacetBytes = 50;
constexpr std::size_t kNormalBytes = 12;

std::uint32_t facet_count(std::string_view bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + kHeaderBytes - 4, 4);
  return count;
}

Result<ReadResult> read_binary(const Source& source) {
  const std::string_view bytes = source.bytes;
  if (bytes.size() < kHeaderBytes) {
    return error_at_byte(
        source, bytes.size(),
        "a binary STL starts with a header of 84 bytes; " + std::string(kRemedyCut));
  }
  const std::size_t count = facet_count(bytes);
  if (count > (bytes.size() - kHeaderBytes) / kFacetBytes) {
    return error_at_byte(source, bytes.size(),
                         "the header promises " + std::to_string(count) + " facets, " +
                             std::to_string(kHeaderBytes + count * kFacetBytes) +
                             " bytes in all, but the file ends here; " + kRemedyCut);
  }
  if (count * 3 >= kNone) {
    return error_at_byte(
        source, kHeaderBytes - 4,
        std::to_string(count) + " facets have more than 2^32 - 2 corners; split the mesh");
  }
  Soup soup;
  soup.positions.reserve(count * 3);
  soup.reserve_triangles(count);
  bool has_attributes = false;
  for (std::size_t f = 0; f < count; ++f) {
    const std::size_t start = kHeaderBytes + f * kFacetBytes + kNormalBytes;
    std::array<float, 9> x;
    std::memcpy(x.data(), bytes.data() + start, sizeof x);
    for (std::size_t k = 0; k < x.size(); ++k) {
      if (is_usable_coordinate(x[k])) continue;
      return error_at_byte(source, start + 4 * k,
                           "expected a finite number for " + std::string(1, "xyz"[k % 3]) +
                               " of corner " + std::to_string(k / 3) + " of facet " +
                               std::to_string(f) + ", found " + std::to_string(x[k]) + "; " +
                               kRemedyExport);
    }
    has_attributes = has_attributes || bytes[start + 36] != 0 || bytes[start + 37] != 0;
    const auto first = static_cast<std::uint32_t>(soup.positions.size());
    for (std::size_t k = 0; k < 9; k += 3) soup.positions.emplace_back(x[k], x[k + 1], x[k + 2]);
    soup.add_face(std::array{first, first + 1, first + 2});
  }
  soup.note_not_carried("facet normals");
  if (has_attributes) soup.note_not_carried("facet attributes");
  if (bytes.size() != kHeaderBytes + count * kFacetBytes) {
    soup.note_not_carried("bytes after the last facet");
  }
  return std::move(soup).finish(source, "stl-binary");
}

/// Keywords in any case; names after `solid` and normals are passed over, as some are not numbers.
class AsciiReader {
 public:
  explicit AsciiReader(const Source& source) : source_(source), text_(source.bytes) {}

  Result<ReadResult> read() {
    bool inside = false;
    for (;;) {
      const std::string_view word = text_.word();
      if (word.empty()) break;
      Result<void> done;
      if (is(word, "solid")) {
        inside = true;
        text_.next_line();
      } else if (is(word, "endsolid")) {
        inside = false;
        text_.next_line();
      } else if (is(word, "facet")) {
        soup_.note_not_carried("facet normals");
        done = read_facet();
      } else {
        done = fail("expected 'facet' or 'endsolid', found " + quote(word) +
                    "; check that this is an STL file");
      }
      if (!done) return done.error();
    }
    if (inside)
      return fail("expected 'facet' or 'endsolid', found the end of the file; " +
                  std::string(kRemedyCut));
    return std::move(soup_).finish(source_, "stl-ascii");
  }

 private:
  /// After `facet`: normal, `outer loop`, corners, `endloop`, `endfacet`.
  Result<void> read_facet() {
    text_.next_line();
    if (Result<void> done = expect("outer"); !done) return done;
    if (Result<void> done = expect("loop"); !done) return done;
    corners_.clear();
    for (;;) {
      const std::string_view word = text_.word();
      if (is(word, "endloop")) break;
      if (!is(word, "vertex")) return unexpected("'vertex' or 'endloop'", word);
      Vec3 p;
      for (int k = 0; k < 3; ++k) {
        const std::string_view number = text_.word();
        if (!parse_number(number, p[k]) || !is_usable_coordinate(p[k])) {
          return unexpected("a finite number for " + std::string(1, "xyz"[k]) + " of corner " +
                                std::to_string(corners_.size()),
                            number);
        }
      }
      if (soup_.positions.size() >= kNone - 1) {
        return fail("more than 2^32 - 2 corners; split the mesh");
      }
      corners_.push_back(static_cast<std::uint32_t>(soup_.positions.size()));
      soup_.positions.push_back(p);
    }
    soup_.add_face(corners_);
    return expect("endfacet");
  }

  Result<void> expect(std::string_view keyword) {
    const std::string_view word = text_.word();
    if (is(word, keyword)) return {};
    return unexpected(quote(keyword), word);
  }

  static bool is(std::string_view word, std::string_view keyword) {
    if (word.size() != keyword.size()) return false;
    for (std::size_t i = 0; i < word.size(); ++i) {
      if ((word[i] >= 'A' && word[i] <= 'Z' ? word[i] - 'A' + 'a' : word[i]) != keyword[i])
        return false;
    }
    return true;
  }

  [[nodiscard]] Error fail(const std::string& what) const {
    return error_at_line(source_, text_.line(), what);
  }
  [[nodiscard]] Error unexpected(const std::string& expected, std::string_view word) const {
    return fail("expected " + expected + " in facet " + std::to_string(soup_.face_count()) +
                ", found " +
                (word.empty() ? "the end of the file; " + std::string(kRemedyCut)
                              : quote(word) + "; " + kRemedyExport));
  }

  const Source& source_;
  Text text_;
  Soup soup_;
  std::vector<std::uint32_t> corners_;
};

}  // namespace

bool is_binary_stl(std::string_view bytes) {
  return bytes.size() >= kHeaderBytes &&
         bytes.size() == kHeaderBytes + std::size_t{facet_count(bytes)} * kFacetBytes;
}

Result<ReadResult> read_stl(const Source& source) {
  if (is_binary_stl(source.bytes)) return read_binary(source);
  // Text has no zero bytes; binary headers and small floats are full of them.
  const bool is_text = source.bytes.substr(0, 1024).find('\0') == std::string_view::npos;
  return is_text ? AsciiReader(source).read() : read_binary(source);
}

}  // namespace nacre::io
