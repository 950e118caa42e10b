// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/geometry.h"
#include "codec/band_coder.h"
#include "entropy/connectivity.h"

namespace nacre::codec {

struct ChosenPositions {
  std::vector<entropy::GridPoint> grid;
  std::vector<std::uint8_t> payload;
};

/// Grid points for the vertices of a mesh without levels, told by planes.
///
/// A vertex is free to slide wherever its triangles stay in their planes: inside flats, along
/// creases. Of the points that can be told cheaply each gets the one of the least error +
/// `bit_price` times bits; the error is the mean squared distance between the planes of the mesh as
/// it was and the triangles as they become, knowing how those before it were moved. No triangle
/// turns over.
///
/// Units    `positions` in steps of the grid, from its corner; `bit_price` in squared steps per
///          vertex.
/// Requires grid points of rounded positions in [0, 2^bits).
[[nodiscard]] ChosenPositions choose_positions(std::span<const Vec3> positions,
                                               const entropy::Connectivity& connectivity, int bits,
                                               double bit_price);

/// The same at a step, as encode_base() has it. `distortion` is that of vertices, whether their
/// slides matter or not.
[[nodiscard]] CodedBase encode_base_by_planes(std::span<const Vec3> positions,
                                              const entropy::Connectivity& connectivity,
                                              int step_index, double bit_price);

}  // namespace nacre::codec
