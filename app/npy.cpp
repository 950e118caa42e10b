// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/npy.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

namespace nacre::app {
namespace {

constexpr std::string_view kMagic("\x93NUMPY\x01\x00", 8);
constexpr std::size_t kPrefix = 10;     // magic, version, 16 bits of header length
constexpr std::size_t kAlignment = 64;  // of the data, as numpy has it

struct TypeSize {
  std::string_view name;
  std::size_t bytes;
};
constexpr std::array<TypeSize, 7> kTypes = {
    {{"<f8", 8}, {"<f4", 4}, {"<u4", 4}, {"<i4", 4}, {"<i8", 8}, {"<u8", 8}, {"|u1", 1}}};

std::optional<TypeSize> known_type(std::string_view name) {
  const auto it = std::ranges::find(kTypes, name, &TypeSize::name);
  return it == kTypes.end() ? std::nullopt : std::optional(*it);
}

std::string shape_text(std::size_t rows, std::size_t columns) {
  return columns == 0 ? fmt::format("({},)", rows) : fmt::format("({}, {})", rows, columns);
}

Error bad(std::string what) { return {ErrorCode::kUnreadableFile, std::move(what)}; }

/// What follows `'key':` in a header, without leading blanks; nothing if the key is not there.
std::optional<std::string_view> value_of(std::string_view header, std::string_view key) {
  const std::string quoted = fmt::format("'{}':", key);
  const std::size_t at = header.find(quoted);
  if (at == std::string_view::npos) return std::nullopt;
  std::string_view rest = header.substr(at + quoted.size());
  rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
  return rest;
}

/// "(12, 3)", "(12,)"
std::optional<std::pair<std::size_t, std::size_t>> shape_of(std::string_view text) {
  if (!text.starts_with('(')) return std::nullopt;
  text.remove_prefix(1);
  std::array<std::size_t, 2> sizes{};
  std::size_t count = 0;
  while (!text.starts_with(')')) {
    if (count == sizes.size()) return std::nullopt;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), sizes[count]);
    if (error != std::errc()) return std::nullopt;
    ++count;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    text.remove_prefix(std::min(text.find_first_not_of(", "), text.size()));
    if (text.empty()) return std::nullopt;
  }
  if (count == 0) return std::nullopt;
  if (count == 2 && sizes[1] == 0) return std::nullopt;
  return std::pair{sizes[0], sizes[1]};
}

}  // namespace

std::vector<std::uint8_t> npy_bytes(const NpyView& array) {
  std::string header = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}",
                                   array.type, shape_text(array.rows, array.columns));
  const std::size_t used = (kPrefix + header.size() + 1) % kAlignment;
  header.append(used == 0 ? 0 : kAlignment - used, ' ');
  header += '\n';
  std::vector<std::uint8_t> out(kMagic.begin(), kMagic.end());
  out.reserve(kPrefix + header.size() + array.data.size());
  out.push_back(static_cast<std::uint8_t>(header.size() & 0xFF));
  out.push_back(static_cast<std::uint8_t>(header.size() >> 8));
  out.insert(out.end(), header.begin(), header.end());
  out.insert(out.end(), array.data.begin(), array.data.end());
  return out;
}

Result<NpyView> read_npy(std::span<const std::uint8_t> file) {
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  if (text.size() < kPrefix || !text.starts_with(kMagic))
    return bad("is no .npy file of version 1.0; write it with numpy.save");
  const std::size_t length = file[8] | (std::size_t{file[9]} << 8);
  if (text.size() - kPrefix < length) return bad("ends inside its header");
  const std::string_view header = text.substr(kPrefix, length);
  const auto type = value_of(header, "descr"), order = value_of(header, "fortran_order"),
             shape = value_of(header, "shape");
  if (!type || !order || !shape) return bad("its header lacks descr, fortran_order or shape");
  if (!order->starts_with("False"))
    return bad("is in Fortran order; save numpy.ascontiguousarray of it");
  const std::optional<TypeSize> known =
      type->size() > 4 ? known_type(type->substr(1, 3)) : std::nullopt;
  if (!known || (*type)[0] != '\'' || (*type)[4] != '\'')
    return bad("holds numbers of a kind that is not used here");
  const auto sizes = shape_of(*shape);
  if (!sizes) return bad("has no shape of one or two dimensions");
  NpyView view{known->name, sizes->first, sizes->second, file.subspan(kPrefix + length)};
  const std::size_t row_bytes = known->bytes * std::max<std::size_t>(view.columns, 1);
  if (view.columns > file.size() || view.data.size() % row_bytes != 0 ||
      view.data.size() / row_bytes != view.rows)
    return bad(fmt::format("has {} bytes of data, which is not {} of {}", view.data.size(),
                           shape_text(view.rows, view.columns), known->name));
  return view;
}

Error unexpected_array(const NpyView& found, std::string_view type, std::size_t columns) {
  return bad(fmt::format("holds {} of {}; expected {} of {}", shape_text(found.rows, found.columns),
                         found.type, columns == 0 ? "(n,)" : fmt::format("(n, {})", columns),
                         type));
}

}  // namespace nacre::app
