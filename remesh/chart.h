// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "remesh/base_domain.h"

namespace nacre::remesh {

/// The base domain as an atlas: a plane coordinate system for any few base triangles that share a
/// corner. Three kinds, from the least distorted up: one triangle; two triangles unfolded over
/// their common side; all triangles around a base vertex as a regular polygon, linear on each.
class Atlas {
 public:
  explicit Atlas(const BaseMesh& base);

  using Vec2 = Eigen::Vector2d;

  class Chart {
   public:
    /// Where a point lies in the chart; nothing if its triangle is not part of it.
    [[nodiscard]] std::optional<Vec2> map(const DomainPoint& point) const;
    /// The domain point at a place of the chart. Outside the chart's triangles: the nearest place
    /// on the border of the triangle in that direction.
    [[nodiscard]] DomainPoint unmap(const Vec2& place) const;

   private:
    friend class Atlas;
    enum class Kind : std::uint8_t { kTriangle, kPair, kStar };
    Kind kind_ = Kind::kTriangle;
    std::uint32_t id_ = 0;    // triangle, or base vertex
    std::uint32_t side_ = 0;  // of a pair: the side of triangle id_
    const Atlas* atlas_ = nullptr;
  };

  /// The least distorted chart that has all the given triangles; nothing if they share no corner.
  [[nodiscard]] std::optional<Chart> common_chart(std::span<const std::uint32_t> triangles) const;
  [[nodiscard]] Chart triangle_chart(std::uint32_t triangle) const;

  [[nodiscard]] const BaseMesh& base() const { return base_; }

 private:
  struct StarFace {
    std::uint32_t face, corner;
  };
  [[nodiscard]] std::span<const StarFace> star(std::uint32_t vertex) const {
    return {star_faces_.data() + star_start_[vertex],
            star_start_[vertex + 1] - star_start_[vertex]};
  }
  /// Corner directions of the polygon: entry m of vertex v at star_start_[v] + v + m.
  [[nodiscard]] const Vec2* polygon(std::uint32_t vertex) const {
    return directions_.data() + star_start_[vertex] + vertex;
  }

  const BaseMesh& base_;
  std::vector<std::uint32_t> star_start_;
  std::vector<StarFace> star_faces_;
  std::vector<Vec2> directions_;
};

}  // namespace nacre::remesh
