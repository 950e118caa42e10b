// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/geometry.h"
#include "base/result.h"

namespace nacre::entropy {

/// A base mesh's triangles as the decoder will see them.
struct Connectivity {
  std::uint32_t vertex_count = 0;
  std::vector<Triangle> triangles;
};

struct EncodedConnectivity {
  std::vector<std::uint8_t> bytes;
  Connectivity decoded;                     ///< what decode_connectivity(bytes) returns
  std::vector<std::uint32_t> vertex_order;  ///< decoded vertex i is input vertex vertex_order[i]
};

/// Valence-driven coding of an oriented 2-manifold: any genus, boundaries, several components.
///
/// Ensures  decoded is the input up to the order of vertices and triangles and the triangles' first
///          corners; orientation is kept. Vertices and triangles come in the coder's traversal
///          order, so that neighbours are close in the sequence.
/// Errors   kBadInput if the triangles are no oriented manifold or a vertex has no triangle.
/// Source   [ToumaGotsman1998], [AlliezDesbrun2001].
[[nodiscard]] Result<EncodedConnectivity> encode_connectivity(std::span<const Triangle> triangles,
                                                              std::uint32_t vertex_count);

/// Errors   kCorruptStream on any bytes encode_connectivity() does not write (never crashes, hangs
///          or allocates more than in proportion to max_triangles).
[[nodiscard]] Result<Connectivity> decode_connectivity(std::span<const std::uint8_t> bytes,
                                                       std::uint32_t max_triangles);

using GridPoint = std::array<std::int32_t, 3>;

/// Base positions on an integer grid, each coordinate in [0, 2^bits), 1 <= bits <= 24, predicted
/// along the triangles in their decoded order (parallelogram, averaged where several apply).
[[nodiscard]] std::vector<std::uint8_t> encode_base_positions(std::span<const GridPoint> points,
                                                              const Connectivity& connectivity,
                                                              int bits);

/// Errors   kCorruptStream.
[[nodiscard]] Result<std::vector<GridPoint>> decode_base_positions(
    std::span<const std::uint8_t> bytes, const Connectivity& connectivity, int bits);

}  // namespace nacre::entropy
