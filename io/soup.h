// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "io/io.h"
#include "io/source.h"

namespace nacre::io {

/// Collects what a reader finds and makes a Scan of it. Faces may come before their vertices.
class Soup {
 public:
  std::vector<Vec3> positions;  ///< as in the file; each is_usable_coordinate

  /// `corners` will be in range of the final `positions`. Faces of fewer than three corners are
  /// counted and left out.
  void add_face(std::span<const std::uint32_t> corners);
  void reserve_triangles(std::size_t count) { triangles_.reserve(count); }

  /// Faces seen so far, of any number of corners.
  [[nodiscard]] std::size_t face_count() const { return face_count_; }

  /// Notes a thing that nacre does not keep, once each name.
  void note_not_carried(std::string_view name);

  /// Triangulates the polygons and moves a far-away scan near zero.
  ///
  /// Errors   kUnreadableFile if there is no triangle; the message tells a point cloud.
  [[nodiscard]] Result<ReadResult> finish(const Source& source, std::string format) &&;

 private:
  struct Polygon {
    std::size_t first_triangle;  ///< corners - 2 triangles are set aside from here
    std::size_t first_corner;
    std::size_t corner_count;
  };
  std::vector<Triangle> triangles_;
  std::vector<Polygon> polygons_;
  std::vector<std::uint32_t> polygon_corners_;
  std::vector<std::string> not_carried_;
  std::size_t face_count_ = 0;
  std::size_t skipped_ = 0;
};

/// Cuts a polygon into corner_count - 2 triangles of the same winding: ears in its mean plane, the
/// one with the shortest diagonal first; a fan where no ear is left (a self-crossing polygon).
void triangulate_polygon(std::span<const std::uint32_t> corners, std::span<const Vec3> positions,
                         std::span<Triangle> triangles);

/// The origin that io.h promises: zero unless the box of the triangles is far away. Its components
/// are multiples of a power of two near the box's diagonal, so that subtracting it is exact up to
/// one rounding at the scale of the diagonal.
[[nodiscard]] Vec3 choose_origin(const Scan& scan);

}  // namespace nacre::io
