// SPDX-License-Identifier: Apache-2.0
#pragma once

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

/// The file's bytes. PLY and STL are binary little-endian; PLY has float coordinates unless
/// `origin` is not zero, then double; GLB puts the origin into the root node's translation.
///
/// Errors   kLimitExceeded for a GLB or STL past its 32-bit sizes.
[[nodiscard]] Result<std::vector<std::uint8_t>> serialize_mesh(const TriangleMesh& mesh,
                                                               MeshFormat format,
                                                               const VertexChannels& channels = {});

/// Writes all bytes or nothing: temporary file in the same folder, fsync, rename.
///
/// Errors   kCannotWrite: exists and not `overwrite`, no folder, disk full.
[[nodiscard]] Result<void> write_file(const std::filesystem::path& file,
                                      std::span<const std::uint8_t> bytes, bool overwrite);

/// The whole file. Errors   kUnreadableFile.
[[nodiscard]] Result<std::vector<std::uint8_t>> read_file(const std::filesystem::path& file);

}  // namespace nacre::io
