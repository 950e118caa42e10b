// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "base/result.h"
#include "io/io.h"
#include "io/source.h"

/// One reader per format, over a file in memory. Errors are kUnreadableFile with a one-line
/// message.
namespace nacre::io {

/// Ascii and both binary orders; any numeric types; other properties and elements are passed over;
/// faces from `vertex_indices` or `vertex_index` lists and from `tristrips`.
[[nodiscard]] Result<ReadResult> read_ply(const Source& source);

/// `v` and `f`; other statements are named in the report.
[[nodiscard]] Result<ReadResult> read_obj(const Source& source);

/// OFF, COFF, NOFF, STOFF and their combinations, as text.
[[nodiscard]] Result<ReadResult> read_off(const Source& source);

/// Ascii and binary.
[[nodiscard]] Result<ReadResult> read_stl(const Source& source);

/// True if the size is that of a binary STL with the facet count it states. Such a file may start
/// with `solid`, as ascii ones do.
[[nodiscard]] bool is_binary_stl(std::string_view bytes);

}  // namespace nacre::io
