// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/ply_header.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "io/text.h"

namespace nacre::io {
namespace {

// Far above what any exporter writes; keeps the work for one element of a hostile file bounded.
constexpr std::size_t kMaxProperties = 4096;

std::optional<PlyType> type_named(std::string_view name) {
  using enum PlyType;
  static constexpr std::array<std::pair<std::string_view, PlyType>, 20> kTypes = {{
      {"char", kInt8},   {"int8", kInt8},      {"uchar", kUint8},   {"uint8", kUint8},
      {"short", kInt16}, {"int16", kInt16},    {"ushort", kUint16}, {"uint16", kUint16},
      {"int", kInt32},   {"int32", kInt32},    {"uint", kUint32},   {"uint32", kUint32},
      {"int64", kInt64}, {"longlong", kInt64}, {"uint64", kUint64}, {"ulonglong", kUint64},
      {"float", kFloat}, {"float32", kFloat},  {"double", kDouble}, {"float64", kDouble},
  }};
  for (const auto& [known, type] : kTypes) {
    if (name == known) return type;
  }
  return std::nullopt;
}

class HeaderReader {
 public:
  explicit HeaderReader(const Source& source) : source_(source) {}

  Result<PlyHeader> read() {
    const std::size_t end = source_.bytes.find_first_of("\r\n");
    if (Text(source_.bytes.substr(0, end)).word() != "ply") {
      return fail("expected 'ply', found " + quote(source_.bytes.substr(0, end)) +
                  "; check that this is a PLY file");
    }
    // Lines end as the first does: a binary body may start with the other byte.
    const bool cr_only = end != std::string_view::npos && source_.bytes[end] == '\r' &&
                         source_.bytes.substr(end, 2) != "\r\n";
    const char line_end = cr_only ? '\r' : '\n';
    std::size_t at = 0;
    bool done = false;
    while (!done) {
      const std::size_t stop = source_.bytes.find(line_end, at);
      if (stop == std::string_view::npos && !is_last_line(at)) {
        return fail("the header has no end_header; " + std::string(kRemedyCut));
      }
      Text line(source_.bytes.substr(at, std::min(stop, source_.bytes.size()) - at));
      if (line_ > 1) {
        if (Result<void> read = read_line(line, done); !read) return read.error();
      }
      at = stop == std::string_view::npos ? source_.bytes.size() : stop + 1;
      ++line_;
    }
    if (!has_format_) return fail("the header has no format line; " + std::string(kRemedyExport));
    header_.body = at;
    header_.body_line = line_;
    return std::move(header_);
  }

 private:
  /// A file may end right after end_header, without a line end.
  [[nodiscard]] bool is_last_line(std::size_t at) const {
    return Text(source_.bytes.substr(at)).word() == "end_header";
  }

  Result<void> read_line(Text& line, bool& done) {
    const std::string_view keyword = line.word_on_line();
    if (keyword == "end_header") {
      done = true;
      return {};
    }
    if (keyword.empty() || keyword == "comment" || keyword == "obj_info") return {};
    if (keyword == "format") return read_format(line.word_on_line());
    if (keyword == "element") return read_element(line);
    if (keyword == "property") return read_property(line);
    return fail("expected element, property, comment or end_header, found " + quote(keyword) +
                "; " + kRemedyExport);
  }

  Result<void> read_format(std::string_view name) {
    has_format_ = true;
    if (name == "ascii") {
      header_.order = PlyOrder::kAscii;
    } else if (name == "binary_little_endian") {
      header_.order = PlyOrder::kLittleEndian;
    } else if (name == "binary_big_endian") {
      header_.order = PlyOrder::kBigEndian;
    } else {
      return fail("expected format ascii, binary_little_endian or binary_big_endian, found " +
                  quote(name) + "; " + kRemedyExport);
    }
    return {};
  }

  Result<void> read_element(Text& line) {
    PlyElement element;
    element.name = line.word_on_line();
    const std::string_view count = line.word_on_line();
    std::int64_t value = 0;
    if (element.name.empty() || !parse_integer(count, value) || value < 0) {
      return fail("expected a name and a count after 'element', found " + quote(element.name) +
                  " and " + quote(count) + "; " + kRemedyExport);
    }
    for (const PlyElement& other : header_.elements) {
      if (other.name == element.name) {
        return fail("a second element " + quote(element.name) + "; " + kRemedyExport);
      }
    }
    element.count = static_cast<std::uint64_t>(value);
    header_.elements.push_back(std::move(element));
    return {};
  }

  Result<void> read_property(Text& line) {
    PlyProperty property;
    std::string_view type = line.word_on_line();
    if (type == "list") {
      property.is_list = true;
      const std::string_view count_name = line.word_on_line();
      const std::optional<PlyType> count_type = type_named(count_name);
      if (!count_type || *count_type == PlyType::kFloat || *count_type == PlyType::kDouble) {
        return fail("expected an integer type for a list's length, found " + quote(count_name) +
                    "; " + kRemedyExport);
      }
      property.count_type = *count_type;
      type = line.word_on_line();
    }
    const std::optional<PlyType> found = type_named(type);
    property.name = line.word_on_line();
    if (!found || property.name.empty()) {
      return fail("expected a type such as float or int and a name, found " + quote(type) +
                  " and " + quote(property.name) + "; " + kRemedyExport);
    }
    property.type = *found;
    if (header_.elements.empty()) {
      return fail("property " + quote(property.name) + " before any element; " + kRemedyExport);
    }
    PlyElement& element = header_.elements.back();
    if (element.find(property.name) != element.properties.size()) {
      return fail("a second property " + quote(property.name) + " of " + quote(element.name) +
                  "; " + kRemedyExport);
    }
    if (++property_count_ > kMaxProperties) {
      return fail("more than " + std::to_string(kMaxProperties) + " properties; " + kRemedyExport);
    }
    element.properties.push_back(std::move(property));
    return {};
  }

  [[nodiscard]] Error fail(const std::string& what) const {
    return error_at_line(source_, line_, what);
  }

  const Source& source_;
  PlyHeader header_;
  std::size_t line_ = 1;
  std::size_t property_count_ = 0;
  bool has_format_ = false;
};

}  // namespace

std::size_t PlyElement::find(std::string_view property) const {
  const auto at = std::find_if(properties.begin(), properties.end(),
                               [&](const PlyProperty& p) { return p.name == property; });
  return static_cast<std::size_t>(at - properties.begin());
}

Result<PlyHeader> read_ply_header(const Source& source) { return HeaderReader(source).read(); }

}  // namespace nacre::io
