// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/scan.h"

namespace nacre::io {

enum class MeshFormat : std::uint8_t { kPly, kObj, kOff, kStl, kGlb };

/// By extension, any case. Errors   kBadInput, naming the known ones.
[[nodiscard]] Result<MeshFormat> mesh_format(const std::filesystem::path& file);

/// Optional per-vertex channels, written to PLY only; empty or one entry per vertex.
struct VertexChannels {
  std::vector<float> quality;
  std::vector<std::array<std::uint8_t, 3>> color;
};

/// The file's bytes. PLY and STL are binary little-endian.
///
/// Coordinates are absolute (position + origin) in all but GLB. PLY, OBJ and OFF hold floats while
/// `origin` is zero, else doubles; the decimals of OBJ and OFF are the shortest that read back as
/// the same number. GLB has floats relative to the origin, which is the root node's translation.
/// STL has nothing but floats: with an origin it keeps 24 bits of the absolute coordinate (at 5e6
/// m, half a metre).
///
/// Errors   kBadInput if a triangle names a missing vertex, a channel has another size than
///          `positions`, a coordinate is not finite or does not fit a float, or a GLB has no
///          triangles; `where` is the element. kLimitExceeded for a GLB or STL past its 32-bit
///          sizes.
[[nodiscard]] Result<std::vector<std::uint8_t>> serialize_mesh(const TriangleMesh& mesh,
                                                               MeshFormat format,
                                                               const VertexChannels& channels = {});

/// Writes all bytes or nothing: temporary file in the same folder, fsync, rename. A file that is
/// replaced keeps its permissions, a symbolic link stays and what it names is replaced. A pipe or
/// device is written through.
///
/// Errors   kCannotWrite: exists and not `overwrite`, no folder, disk full. No temporary is left.
[[nodiscard]] Result<void> write_file(const std::filesystem::path& file,
                                      std::span<const std::uint8_t> bytes, bool overwrite);

/// The whole file, or all that a pipe gives. Errors   kUnreadableFile.
[[nodiscard]] Result<std::vector<std::uint8_t>> read_file(const std::filesystem::path& file);

}  // namespace nacre::io
