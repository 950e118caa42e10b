// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/semi_regular_mesh.h"
#include "wavelet/wavelet.h"

namespace nacre::codec {

/// How the bands are coded.
enum class Profile : std::uint8_t {
  kPaper = 0,  ///< lattice points as product codes, stack-run
  kBest = 1,   ///< integers chosen by their cost, context-mixed bits
};

struct DecodeOptions {
  int max_level = -1;  ///< decode no further than this level; -1: all that is there
  /// Refuse streams that would decode to more vertices (default 2^28) before allocating.
  std::uint64_t max_vertices = std::uint64_t{1} << 28;
  /// Accept a stream cut short: decode to the last whole band. Otherwise such a stream is corrupt.
  bool accept_prefix = false;
};

/// What a stream says of itself, from its header and section lengths alone.
struct StreamInfo {
  struct Level {
    std::size_t bytes = 0;  ///< prefix of the file that decodes this level
    std::uint64_t vertices = 0, triangles = 0;
  };
  struct Section {
    std::string_view name;  ///< "base connectivity", "base positions", "band"
    std::size_t offset = 0, bytes = 0;
    double step = 0;  ///< of a band; model units
  };
  int version = 0;
  Profile profile = Profile::kPaper;
  wavelet::Transform transform = wavelet::Transform::kButterfly;
  std::uint32_t base_vertices = 0, base_triangles = 0;
  int base_bits = 0;
  Vec3 origin = Vec3::Zero();
  std::vector<Level> levels;
  std::vector<Section> sections;
  std::size_t bytes_present = 0, bytes_whole = 0;
};

/// Errors   kCorruptStream, kUnsupportedVersion, kLimitExceeded; `where` is the byte offset.
[[nodiscard]] Result<StreamInfo> inspect(std::span<const std::uint8_t> bytes,
                                         const DecodeOptions& options = {});

/// Decodes to the finest level that is there and asked for. Positions are bit-identical in every
/// build of this version.
///
/// Errors   as inspect(); a damaged section is found by its checksum before it is decoded.
[[nodiscard]] Result<SemiRegularMesh> decode(std::span<const std::uint8_t> bytes,
                                             const DecodeOptions& options = {});

}  // namespace nacre::codec
