// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/result.h"
#include "base/scan.h"

/// What the mesh writers share.
namespace nacre::io {

static_assert(std::endian::native == std::endian::little,
              "values are written as they lie in memory");

inline void put_text(std::vector<std::uint8_t>& out, std::string_view text) {
  const std::size_t at = out.size();
  out.resize(at + text.size());
  std::copy(text.begin(), text.end(), out.begin() + static_cast<std::ptrdiff_t>(at));
}

/// Appends the bytes of a value, little-endian.
template <class T>
void put_value(std::vector<std::uint8_t>& out, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  const std::size_t at = out.size();
  out.resize(at + sizeof value);
  std::memcpy(out.data() + at, &value, sizeof value);
}

/// Appends the shortest decimal that reads back as the same number.
template <class T>
void put_number(std::vector<std::uint8_t>& out, T value) {
  char text[32];  // the longest double takes 24
  const char* const end = std::to_chars(text, text + sizeof text, value).ptr;
  put_text(out, {text, static_cast<std::size_t>(end - text)});
}

/// glTF 2.0 binary: one scene, node, mesh and primitive; float positions relative to the origin,
/// which is the node's translation.
///
/// Errors   kBadInput without triangles, which glTF cannot say. kLimitExceeded past 4 GiB.
[[nodiscard]] Result<std::vector<std::uint8_t>> write_glb(const TriangleMesh& mesh);

}  // namespace nacre::io
