// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "entropy/position_prediction.h"

namespace nacre::entropy {

/// Points on planes are told in 1/16 of a grid step, normals are shortened to 14 bits a component:
/// with coordinates below 2^24, what is multiplied here stays below 2^62.
inline constexpr std::int64_t kPlaneUnit = 16;
inline constexpr int kNormalBits = 14;

struct Plane {
  Wide3 point{};   ///< in 1/kPlaneUnit of a step
  Wide3 normal{};  ///< not zero
};

inline constexpr std::size_t kMostPlanes = 4;

/// How a vertex is told: by a plane, and by how finely it lies in it.
struct PositionChoice {
  std::uint32_t plane = 0;                  ///< that gives the last coordinate
  std::array<std::uint8_t, 2> levels = {};  ///< of the plane's first and second axis: fineness
  std::uint32_t second_plane = kNone;       ///< that gives the second coordinate; kNone: none

  bool operator==(const PositionChoice&) const = default;
};

/// Which of a plane's two axes comes first: the coarser.
constexpr std::size_t first_told(const PositionChoice& choice) {
  return choice.levels[0] > choice.levels[1] ? 1 : 0;
}

/// A vertex is flat, on a crease, or a corner: 1 + the number of its axes of kFineLevel and more;
/// 0 if not done.
using VertexKind = std::uint8_t;
inline constexpr std::uint8_t kFineLevel = 2;
inline constexpr std::uint8_t kNoLevel = 15;

/// What the coder remembers of a vertex that is done.
struct ToldVertex {
  VertexKind kind = 0;
  std::array<std::uint8_t, 3> levels = {kNoLevel, kNoLevel, kNoLevel};  ///< by axis
  std::uint8_t last_length = 0;    ///< bit length of what was left along its plane's normal
  std::uint8_t coarse_length = 0;  ///< largest bit length of its coarse residuals
};

/// What is known of a vertex before it is told.
struct Outlook {
  Prediction near;
  std::array<Plane, kMostPlanes> planes{};
  std::uint32_t plane_count = 0;
  int coarse_bits = 0;    ///< the coarsest steps are 2^coarse_bits of the grid's
  bool is_level = false;  ///< all triangles across its gates are in the first plane
  // Of neighbours that are done.
  std::array<int, 4> kinds{};  ///< how many of each kind
  int least_last = 0, mean_last = 0, most_coarse = 0;
  std::array<int, 3> mean_levels{};  ///< by axis, in halves; kNoLevel if none
  std::uint32_t gate_kinds = 0;      ///< of the ends of one gate, 4 a + b, a <= b

  /// Coordinates of a level are told in 2^shift steps.
  [[nodiscard]] int shift(int level) const { return std::max(0, coarse_bits - 2 * level); }
  /// Levels above are no finer.
  [[nodiscard]] int finest_level() const { return (coarse_bits + 1) / 2; }
};

/// The axes of a plane: those along which its coordinate is told, least of the normal first, and
/// the one that follows from them.
[[nodiscard]] std::array<std::size_t, 3> plane_axes(const Wide3& normal);

[[nodiscard]] Outlook look_out(const PositionOrder& order, std::span<const GridPoint> points,
                               std::span<const ToldVertex> told, std::uint32_t vertex, int bits,
                               int default_scale, std::int64_t reach);

/// Coordinate `axis` of the point of a plane whose other coordinates are those of `point`; rounded,
/// inside the grid. The plane's normal must not be zero along `axis`.
[[nodiscard]] std::int64_t solve_plane(const Plane& plane, std::size_t axis, const GridPoint& point,
                                       int bits);

/// Whether two planes' line crosses planes of constant `axis` steeply enough to be told by it.
[[nodiscard]] bool have_line(const Plane& one, const Plane& other, std::size_t axis);
/// Coordinate `second` of the place where both planes have coordinate `axis` of `point`.
/// Precondition: have_line().
[[nodiscard]] std::int64_t solve_line(const Plane& one, const Plane& other, std::size_t axis,
                                      std::size_t second, const GridPoint& point, int bits);

}  // namespace nacre::entropy
