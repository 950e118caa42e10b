// SPDX-License-Identifier: GPL-3.0-or-later
//
// Read me first: one body reader serves ascii and both binary orders; a `Values` class hands it the
// next number, whatever it is stored as. Every number passes through a double, which holds all
// 32-bit ids exactly.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <vector>

#include "io/formats.h"
#include "io/ply_header.h"
#include "io/soup.h"
#include "io/text.h"

namespace nacre::io {
namespace {

static_assert(std::endian::native == std::endian::little,
              "binary values are swapped to little-endian");

enum class Status : std::uint8_t { kOk, kEnd, kNotANumber };

class AsciiValues {
 public:
  AsciiValues(const Source& source, const PlyHeader& header)
      : source_(source), text_(source.bytes.substr(header.body)) {
    text_.set_line(header.body_line);
  }

  Status next(PlyType, double& value) {
    word_ = text_.word();
    if (word_.empty()) return Status::kEnd;
    return parse_number(word_, value) ? Status::kOk : Status::kNotANumber;
  }
  Status skip(PlyType, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      if (text_.word().empty()) return Status::kEnd;
    }
    return Status::kOk;
  }
  /// Bytes that a value takes at least: a digit and a separator, which the last one may lack.
  static std::size_t min_bytes(PlyType) { return 2; }
  [[nodiscard]] std::size_t bytes_left() const { return text_.bytes_left() + 1; }
  [[nodiscard]] bool at_end() { return text_.word().empty(); }
  void mark() {}
  [[nodiscard]] std::string found(double) const { return quote(word_); }
  [[nodiscard]] Error fail(const std::string& what) const {
    return error_at_line(source_, text_.line(), what);
  }

 private:
  const Source& source_;
  Text text_;
  std::string_view word_;
};

template <bool kSwap>
class BinaryValues {
 public:
  BinaryValues(const Source& source, const PlyHeader& header)
      : source_(source), at_(header.body), last_(header.body) {}

  Status next(PlyType type, double& value) {
    const std::size_t size = byte_size(type);
    last_ = at_;
    if (size > source_.bytes.size() - at_) return Status::kEnd;
    unsigned char raw[8];
    std::memcpy(raw, source_.bytes.data() + at_, size);
    if constexpr (kSwap) std::reverse(raw, raw + size);
    at_ += size;
    value = decode(type, raw);
    return Status::kOk;
  }
  Status skip(PlyType type, std::size_t count) {
    last_ = at_;
    if (count > (source_.bytes.size() - at_) / byte_size(type)) return Status::kEnd;
    at_ += count * byte_size(type);
    return Status::kOk;
  }
  static std::size_t min_bytes(PlyType type) { return byte_size(type); }
  [[nodiscard]] std::size_t bytes_left() const { return source_.bytes.size() - at_; }
  [[nodiscard]] bool at_end() const { return bytes_left() == 0; }
  /// Makes the next byte the place of an error.
  void mark() { last_ = at_; }
  [[nodiscard]] std::string found(double value) const {
    char text[32];
    const auto end = std::to_chars(text, text + sizeof text, value).ptr;
    return {text, end};
  }
  [[nodiscard]] Error fail(const std::string& what) const {
    return error_at_byte(source_, last_, what);
  }

 private:
  template <class T>
  static double as(const unsigned char* raw) {
    T value;
    std::memcpy(&value, raw, sizeof value);
    return static_cast<double>(value);
  }
  static double decode(PlyType type, const unsigned char* raw) {
    switch (type) {
      case PlyType::kInt8:
        return as<std::int8_t>(raw);
      case PlyType::kUint8:
        return as<std::uint8_t>(raw);
      case PlyType::kInt16:
        return as<std::int16_t>(raw);
      case PlyType::kUint16:
        return as<std::uint16_t>(raw);
      case PlyType::kInt32:
        return as<std::int32_t>(raw);
      case PlyType::kUint32:
        return as<std::uint32_t>(raw);
      case PlyType::kInt64:
        return as<std::int64_t>(raw);
      case PlyType::kUint64:
        return as<std::uint64_t>(raw);
      case PlyType::kFloat:
        return as<float>(raw);
      case PlyType::kDouble:
        return as<double>(raw);
    }
    return 0.0;
  }

  const Source& source_;
  std::size_t at_;
  std::size_t last_;  // where the value handed out last starts
};

template <class Values>
class BodyReader {
 public:
  BodyReader(const Source& source, const PlyHeader& header)
      : source_(source), header_(header), values_(source, header) {}

  Result<ReadResult> read(std::string format) {
    for (const PlyElement& element : header_.elements) {
      if (element.name == "vertex") vertex_count_ = element.count;
    }
    if (vertex_count_ >= kNone) {
      return values_.fail(std::to_string(vertex_count_) +
                          " vertices are more than 2^32 - 2; split the mesh");
    }
    for (const PlyElement& element : header_.elements) {
      values_.mark();
      Result<void> done = check_count(element);
      if (done) {
        if (element.name == "vertex") {
          done = read_vertices(element);
        } else if (element.name == "face") {
          done = read_lists(element, {"vertex_indices", "vertex_index"}, false);
        } else if (element.name == "tristrips") {
          done = read_lists(element, {"vertex_indices", "vertex_index"}, true);
        } else {
          if (element.count > 0) soup_.note_not_carried("element " + element.name);
          done = skip_element(element);
        }
      }
      if (!done) return done.error();
    }
    if (!values_.at_end()) soup_.note_not_carried("data after the last element");
    return std::move(soup_).finish(source_, std::move(format));
  }

 private:
  /// Refuses a count that the bytes left cannot hold, before anything is allocated for it.
  Result<void> check_count(const PlyElement& element) {
    std::size_t least = 0;
    for (const PlyProperty& p : element.properties) {
      least += Values::min_bytes(p.is_list ? p.count_type : p.type);
    }
    if (least == 0 || element.count <= values_.bytes_left() / least) return {};
    return values_.fail("the header promises " + std::to_string(element.count) + " of element " +
                        quote(element.name) + ", at least " + std::to_string(least) +
                        " bytes each, but only " + std::to_string(values_.bytes_left()) +
                        " bytes are left; " + kRemedyCut);
  }

  Result<void> read_vertices(const PlyElement& element) {
    constexpr int kOther = 3;
    std::vector<int> axis(element.properties.size(), kOther);
    for (int k = 0; k < 3; ++k) {
      const std::size_t at = element.find(std::string_view("xyz").substr(k, 1));
      if (at == element.properties.size() || element.properties[at].is_list) {
        return values_.fail("the vertices have no number " + quote(std::string(1, "xyz"[k])) +
                            "; " + kRemedyExport);
      }
      axis[at] = k;
    }
    for (std::size_t p = 0; p < axis.size(); ++p) {
      if (axis[p] == kOther) soup_.note_not_carried(element.properties[p].name);
    }
    soup_.positions.resize(element.count);
    for (std::size_t v = 0; v < element.count; ++v) {
      for (std::size_t p = 0; p < axis.size(); ++p) {
        const PlyProperty& property = element.properties[p];
        if (axis[p] == kOther) {
          if (Result<void> done = skip(element, v, property); !done) return done;
          continue;
        }
        double& x = soup_.positions[v][axis[p]];
        const Status status = values_.next(property.type, x);
        if (status != Status::kOk) return fail(status, element, v, property);
        if (!is_usable_coordinate(x)) {
          return values_.fail("expected a finite number for " + property.name + " of vertex " +
                              std::to_string(v) + ", found " + values_.found(x) + "; " +
                              kRemedyExport);
        }
      }
    }
    return {};
  }

  /// Faces or strips: one list property of vertex numbers, and others that are passed over.
  Result<void> read_lists(const PlyElement& element, std::initializer_list<const char*> names,
                          bool strips) {
    if (element.count == 0) return {};
    std::size_t corner_list = element.properties.size();
    for (const char* name : names) {
      if (corner_list == element.properties.size()) corner_list = element.find(name);
    }
    if (corner_list == element.properties.size() || !element.properties[corner_list].is_list) {
      return values_.fail("element " + quote(element.name) + " has no list vertex_indices; " +
                          kRemedyExport);
    }
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      if (p != corner_list) {
        soup_.note_not_carried(element.name + " " + element.properties[p].name);
      }
    }
    if (!strips) soup_.reserve_triangles(element.count);
    for (std::size_t f = 0; f < element.count; ++f) {
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        const PlyProperty& property = element.properties[p];
        Result<void> done = p == corner_list ? read_corners(element, f, property, strips)
                                             : skip(element, f, property);
        if (!done) return done;
      }
      if (strips) {
        add_strip();
      } else {
        soup_.add_face(corners_);
      }
    }
    return {};
  }

  Result<void> read_corners(const PlyElement& element, std::size_t f, const PlyProperty& property,
                            bool strips) {
    std::size_t count = 0;
    if (Result<void> done = read_count(element, f, property, count); !done) return done;
    corners_.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      double index = 0.0;
      const Status status = values_.next(property.type, index);
      if (status != Status::kOk) return fail(status, element, f, property);
      if (strips && index == -1.0) {
        corners_[i] = kNone;
        continue;
      }
      if (!(index >= 0.0 && index < static_cast<double>(vertex_count_)) ||
          index != std::floor(index)) {
        return values_.fail(element.name + " " + std::to_string(f) + " names vertex " +
                            values_.found(index) + ", but the " + std::to_string(vertex_count_) +
                            " vertices count from 0; " + kRemedyExport);
      }
      corners_[i] = static_cast<std::uint32_t>(index);
    }
    return {};
  }

  /// Every other triangle of a strip is wound the other way; -1 starts a new strip. A repeated
  /// vertex is how strips are joined: it makes no face.
  void add_strip() {
    std::size_t start = 0;
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      if (corners_[i] == kNone) start = i + 1;
      if (i < start + 2) continue;
      const bool flipped = (i - start) % 2 == 1;
      const Triangle t = {corners_[flipped ? i - 1 : i - 2], corners_[flipped ? i - 2 : i - 1],
                          corners_[i]};
      if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) soup_.add_face(t);
    }
  }

  Result<void> skip_element(const PlyElement& element) {
    if (element.properties.empty()) return {};
    for (std::size_t i = 0; i < element.count; ++i) {
      for (const PlyProperty& property : element.properties) {
        if (Result<void> done = skip(element, i, property); !done) return done;
      }
    }
    return {};
  }

  Result<void> skip(const PlyElement& element, std::size_t i, const PlyProperty& property) {
    std::size_t count = 1;
    if (property.is_list) {
      if (Result<void> done = read_count(element, i, property, count); !done) return done;
    }
    const Status status = values_.skip(property.type, count);
    if (status != Status::kOk) return fail(status, element, i, property);
    return {};
  }

  Result<void> read_count(const PlyElement& element, std::size_t i, const PlyProperty& property,
                          std::size_t& count) {
    double value = 0.0;
    const Status status = values_.next(property.count_type, value);
    if (status != Status::kOk) return fail(status, element, i, property);
    const std::size_t most = values_.bytes_left() / Values::min_bytes(property.type);
    if (!(value >= 0.0 && value <= static_cast<double>(most)) || value != std::floor(value)) {
      return values_.fail("the list " + property.name + " of " + element.name + " " +
                          std::to_string(i) + " has length " + values_.found(value) +
                          ", but the bytes left hold at most " + std::to_string(most) + "; " +
                          kRemedyCut);
    }
    count = static_cast<std::size_t>(value);
    return {};
  }

  Error fail(Status status, const PlyElement& element, std::size_t i,
             const PlyProperty& property) const {
    const std::string place = property.name + " of " + element.name + " " + std::to_string(i) +
                              " of " + std::to_string(element.count);
    if (status == Status::kEnd) {
      return values_.fail("the file ends before " + place + "; " + kRemedyCut);
    }
    return values_.fail("expected a number for " + place + ", found " + values_.found(0.0) + "; " +
                        kRemedyExport);
  }

  const Source& source_;
  const PlyHeader& header_;
  Values values_;
  Soup soup_;
  std::uint64_t vertex_count_ = 0;
  std::vector<std::uint32_t> corners_;
};

}  // namespace

Result<ReadResult> read_ply(const Source& source) {
  const Result<PlyHeader> header = read_ply_header(source);
  if (!header) return header.error();
  switch ((*header).order) {
    case PlyOrder::kAscii:
      return BodyReader<AsciiValues>(source, *header).read("ply-ascii");
    case PlyOrder::kLittleEndian:
      return BodyReader<BinaryValues<false>>(source, *header).read("ply-le");
    case PlyOrder::kBigEndian:
      return BodyReader<BinaryValues<true>>(source, *header).read("ply-be");
  }
  return error_at_byte(source, 0, "unknown byte order");
}

}  // namespace nacre::io
