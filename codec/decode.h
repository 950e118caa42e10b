// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "base/semi_regular_mesh.h"
#include "wavelet/wavelet.h"

namespace nacre::codec {

/// How the bands are coded.
enum class Profile : std::uint8_t {
  kPaper = 0,  ///< lattice points as product codes, stack-run
  kBest = 1,   ///< integers chosen by their cost, context-mixed bits
  // The coders that [LVQ] compares itself with, on the same mesh and in the same container. Their
  // decoders are no part of the decoding half: see DecodeOptions::comparators.
  kNmc = 2,   ///< zerotrees, bit plane by bit plane
  kEqmc = 3,  ///< variance classes, estimated from what is decoded around
};

/// "paper", "best", "nmc" or "eqmc".
[[nodiscard]] std::string_view profile_name(Profile profile);
/// Its inverse; nothing for other names.
[[nodiscard]] std::optional<Profile> profile_of_name(std::string_view name);

struct StreamLayout;
/// Details of the first `levels` bands of a stream, at most `max_vertices` on its finest level.
using BandsDecoder = Result<std::vector<std::vector<Vec3>>> (*)(std::span<const std::uint8_t> bytes,
                                                                const StreamLayout& layout,
                                                                const Topology& topology,
                                                                int levels,
                                                                std::uint64_t max_vertices);

struct DecodeOptions {
  int max_level = -1;  ///< decode no further than this level; -1: all that is there
  /// Refuse streams that would decode to more vertices (default 2^28) before allocating.
  std::uint64_t max_vertices = std::uint64_t{1} << 28;
  /// Accept a stream cut short: decode to the last whole band. Otherwise such a stream is corrupt.
  bool accept_prefix = false;
  /// Decodes profiles nmc and eqmc: decode_comparator_bands() of codec/comparators.h. Without it
  /// their streams are kUnsupportedVersion.
  BandsDecoder comparators = nullptr;
};

/// What a stream may say of how good its prefixes are: measured against the scan by who made it.
struct LevelTable {
  struct Cut {
    double psnr_db = 0;  ///< in steps of 0.05 dB, rounded down; 0 .. 204.75
    /// No point of either surface is farther from the other; model units, rounded up by less than
    /// 0.8 %. Infinite: not known.
    double max_error = 0;
  };
  double bbox_diagonal = 0;  ///< of the scan, model units, as binary32
  std::vector<Cut> cuts;     ///< of levels 0 .. J
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
  std::size_t bytes_header = 0, bytes_present = 0, bytes_whole = 0;
  std::optional<LevelTable> level_table;
  /// No point of the scan or of the whole decoded surface is farther from the other; model units.
  std::optional<double> certified_error;
};

/// No header is longer: what suffices to inspect() a file's beginning.
inline constexpr std::size_t kMaxHeaderBytes = 512;

/// Errors   kCorruptStream, kUnsupportedVersion, kLimitExceeded; `where` is the byte offset.
[[nodiscard]] Result<StreamInfo> inspect(std::span<const std::uint8_t> bytes,
                                         const DecodeOptions& options = {});

/// The same from a file's first kMaxHeaderBytes (all of a shorter file) and its size, whether or
/// not the file is whole; nothing is compared with any limit.
///
/// Errors   kCorruptStream, kUnsupportedVersion.
[[nodiscard]] Result<StreamInfo> inspect_header(std::span<const std::uint8_t> beginning,
                                                std::size_t file_bytes);

/// Decodes to the finest level that is there and asked for. Positions are bit-identical in every
/// build of this version.
///
/// Errors   as inspect(); a damaged section is found by its checksum before it is decoded.
[[nodiscard]] Result<SemiRegularMesh> decode(std::span<const std::uint8_t> bytes,
                                             const DecodeOptions& options = {});

}  // namespace nacre::codec
