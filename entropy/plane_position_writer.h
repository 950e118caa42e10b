// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "entropy/connectivity.h"
#include "entropy/plane_prediction.h"

namespace nacre::entropy {

/// Writes base positions by planes, vertex by vertex, so that who chooses them can see what the
/// decoder will know of each and what a choice would cost.
///
/// for (v = w.next(); v != kNone; v = w.next()) w.write(point);   then w.finish()
class PlanePositionWriter {
 public:
  /// Preconditions: a mesh that close_mesh() takes, 1 <= bits <= 24.
  PlanePositionWriter(const Connectivity& connectivity, int bits);
  ~PlanePositionWriter();
  PlanePositionWriter(PlanePositionWriter&&) noexcept;
  PlanePositionWriter& operator=(PlanePositionWriter&&) noexcept;

  /// The vertex to write next; kNone after the last.
  [[nodiscard]] std::uint32_t next();
  /// What is known of it.
  [[nodiscard]] const Outlook& outlook() const;
  /// Whether a choice can tell a point: coarse coordinates must be whole coarse steps away from
  /// where they are expected, all inside the grid.
  [[nodiscard]] bool can_tell(const PositionChoice& choice, const GridPoint& point) const;
  /// In 1/4096 bit. Precondition: can_tell().
  [[nodiscard]] std::uint32_t cost(const PositionChoice& choice, const GridPoint& point) const;
  /// The choice that tells a point of the grid at the least cost.
  [[nodiscard]] PositionChoice cheapest(const GridPoint& point) const;
  /// By the cheapest choice.
  void write(const GridPoint& point);
  /// After the last vertex, once. What decode_positions_by_planes() reads.
  [[nodiscard]] std::vector<std::uint8_t> finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Points that were chosen before.
[[nodiscard]] std::vector<std::uint8_t> encode_positions_by_planes(
    std::span<const GridPoint> points, const Connectivity& connectivity, int bits);

}  // namespace nacre::entropy
