// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

#include "base/result.h"
#include "base/scan.h"
#include "base/semi_regular_mesh.h"

/// What the verbs share about files: checks before any work, loading, and errors with a name on.
namespace nacre::app {

/// The error as it is printed: one line that names the file.
[[nodiscard]] Error in_file(Error error, const std::filesystem::path& file);

/// As in_file(), for what went wrong while reading a .ncr: a size out of bounds or a bad mesh is
/// then a corrupt stream.
[[nodiscard]] Error stream_error(Error error, const std::filesystem::path& file);

/// As in_file(), for what went wrong with a scan's surface: kBadInput is then a refused geometry.
[[nodiscard]] Error surface_error(Error error, const std::filesystem::path& file);

[[nodiscard]] bool has_extension(const std::filesystem::path& file, std::string_view extension);
[[nodiscard]] bool is_stream_name(const std::filesystem::path& file);  ///< *.ncr, any case

/// The cheap checks of an output, before minutes of work: does it exist, and may its folder be
/// written? `input` must not be the same file, whatever -f says.
///
/// Errors   kBadInput: exists and not `overwrite`, is a folder, is the input. kCannotWrite: the
///          folder is missing or may not be written.
[[nodiscard]] Result<void> check_output(const std::filesystem::path& output, bool overwrite,
                                        const std::filesystem::path& input);

/// Errors   as check_output(); kBadInput if the name does not end in `extension` (any case).
[[nodiscard]] Result<void> check_output_named(const std::filesystem::path& output,
                                              std::string_view extension, bool overwrite,
                                              const std::filesystem::path& input);

/// io::write_file with the file's name on its errors.
[[nodiscard]] Result<void> write_output(const std::filesystem::path& output,
                                        std::span<const std::uint8_t> bytes, bool overwrite);
[[nodiscard]] Result<void> write_output(const std::filesystem::path& output, std::string_view text,
                                        bool overwrite);

/// The triangles of level `level` (-1: the finest) with their positions and origin.
[[nodiscard]] Result<TriangleMesh> to_triangles(const SemiRegularMesh& mesh, int level = -1);

/// A scan, or what a .ncr file decodes to.
[[nodiscard]] Result<Scan> load_surface(const std::filesystem::path& file);

/// The scan as it is drawn: raw scans may be inside out, or have a corner of its own for each face;
/// both look wrong though the surface is right. Where cleaning refuses, it stays as it is.
[[nodiscard]] Scan drawable(const Scan& scan);

/// Whether any triangle has an area: without one there is no surface to code or to measure.
[[nodiscard]] bool has_area(const Scan& scan);

/// Diagonal of the bounding box of the vertices that lie on a face.
[[nodiscard]] double bbox_diagonal(const Scan& scan);

struct Box {
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();
};
/// Of the vertices that lie on a face, without the origin; zero if there is none.
[[nodiscard]] Box bounding_box(const Scan& scan);

}  // namespace nacre::app
