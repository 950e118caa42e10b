// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/geometry.h"
#include "base/result.h"

/// Arrays as numpy reads and writes them: .npy, format 1.0, little-endian, in C order.
namespace nacre::app {

/// What an element of a C++ array is in the file: numpy's name of its numbers, and how many it has.
/// `columns` 0: single numbers, a one-dimensional array.
template <class Row>
struct NpyRow;
template <>
struct NpyRow<double> {
  static constexpr std::string_view kType = "<f8";
  static constexpr std::size_t kColumns = 0;
};
template <>
struct NpyRow<std::uint32_t> {
  static constexpr std::string_view kType = "<u4";
  static constexpr std::size_t kColumns = 0;
};
template <>
struct NpyRow<std::uint8_t> {
  static constexpr std::string_view kType = "|u1";
  static constexpr std::size_t kColumns = 0;
};
template <>
struct NpyRow<Vec3> {
  static constexpr std::string_view kType = "<f8";
  static constexpr std::size_t kColumns = 3;
};
template <std::size_t N>
struct NpyRow<std::array<double, N>> {
  static constexpr std::string_view kType = "<f8";
  static constexpr std::size_t kColumns = N;
};
template <std::size_t N>
struct NpyRow<std::array<std::uint32_t, N>> {
  static constexpr std::string_view kType = "<u4";
  static constexpr std::size_t kColumns = N;
};
template <std::size_t N>
struct NpyRow<std::array<std::int32_t, N>> {
  static constexpr std::string_view kType = "<i4";
  static constexpr std::size_t kColumns = N;
};

/// The shape that a file states, and its numbers as they lie in it. `columns` 0: one-dimensional.
struct NpyView {
  std::string_view type;
  std::size_t rows = 0, columns = 0;
  std::span<const std::uint8_t> data;
};

[[nodiscard]] std::vector<std::uint8_t> npy_bytes(const NpyView& array);

/// Errors   kUnreadableFile: not .npy of version 1.0, an array of more than two dimensions, in
///          Fortran order, big-endian, or with more or fewer bytes than its shape asks for.
[[nodiscard]] Result<NpyView> read_npy(std::span<const std::uint8_t> file);

template <class Row>
[[nodiscard]] std::vector<std::uint8_t> to_npy(std::span<const Row> rows) {
  const auto* data = reinterpret_cast<const std::uint8_t*>(rows.data());
  return npy_bytes(
      {NpyRow<Row>::kType, rows.size(), NpyRow<Row>::kColumns, {data, rows.size_bytes()}});
}

/// The complaint about an array that is not what it should be.
[[nodiscard]] Error unexpected_array(const NpyView& found, std::string_view type,
                                     std::size_t columns);

/// Errors   kUnreadableFile: as read_npy(), or other numbers or columns than Row's.
template <class Row>
[[nodiscard]] Result<std::vector<Row>> from_npy(std::span<const std::uint8_t> file) {
  Result<NpyView> view = read_npy(file);
  if (!view) return view.error();
  if (view->type != NpyRow<Row>::kType || view->columns != NpyRow<Row>::kColumns)
    return unexpected_array(*view, NpyRow<Row>::kType, NpyRow<Row>::kColumns);
  std::vector<Row> rows(view->rows);
  if (!rows.empty())
    std::memcpy(static_cast<void*>(rows.data()), view->data.data(), view->data.size());
  return rows;
}

}  // namespace nacre::app
