// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "remesh/base_domain.h"

namespace nacre::remesh {

/// The base domain as an atlas: a plane coordinate system for any few base triangles that are close
/// to each other. Four kinds, from the least distorted up: one triangle; two triangles unfolded
/// over their common side; all triangles around a base vertex, z^(6/k) of them laid out flat; a net
/// of triangles unfolded around the one in their middle, cut open where it does not lie flat.
class Atlas {
 public:
  explicit Atlas(const BaseMesh& base);

  using Vec2 = Eigen::Vector2d;

  /// A base triangle laid out in the plane: where its corners are.
  struct NetFace {
    std::uint32_t face;
    std::array<Vec2, 3> corner;
  };

  class Chart {
   public:
    /// Where a point lies in the chart; nothing if its triangle is not part of it.
    [[nodiscard]] std::optional<Vec2> map(const DomainPoint& point) const;
    /// The domain point at a place of the chart. Outside the chart's triangles: the nearest place
    /// on the border of the triangle in that direction.
    [[nodiscard]] DomainPoint unmap(const Vec2& place) const;
    /// Made anew for each use, unlike the other kinds: dear.
    [[nodiscard]] bool is_net() const { return net_ != nullptr; }

   private:
    friend class Atlas;
    enum class Kind : std::uint8_t { kTriangle, kPair, kStar, kNet };
    Kind kind_ = Kind::kTriangle;
    std::uint32_t id_ = 0;    // triangle, or base vertex
    std::uint32_t side_ = 0;  // of a pair: the side of triangle id_
    const Atlas* atlas_ = nullptr;
    std::shared_ptr<const std::vector<NetFace>> net_;  // of a net
  };

  /// The least distorted chart that has all the given triangles; nothing if they are too far apart.
  [[nodiscard]] std::optional<Chart> common_chart(std::span<const std::uint32_t> triangles) const;
  /// The least distorted chart for all the given points (up to 4). A point on a side or corner
  /// belongs to every triangle there: if one triangle has them all, each is rewritten as a point of
  /// it.
  [[nodiscard]] std::optional<Chart> common_chart(std::span<DomainPoint> points) const;
  /// The same point as one of the given triangle, if it is on a side or corner of it.
  [[nodiscard]] std::optional<DomainPoint> seen_from(const DomainPoint& point,
                                                     std::uint32_t triangle) const;
  /// Twice the signed area of a triangle of the domain, in the chart that its corners share;
  /// nothing if they share none. Its sign says whether the triangle is turned over.
  [[nodiscard]] std::optional<double> doubled_area(std::array<DomainPoint, 3> corners) const;
  [[nodiscard]] Chart triangle_chart(std::uint32_t triangle) const;

  [[nodiscard]] const BaseMesh& base() const { return base_; }

 private:
  struct StarFace {
    std::uint32_t face, corner;
  };
  /// The net around the most central of the given triangles; null if they are too far apart.
  [[nodiscard]] std::shared_ptr<const std::vector<NetFace>> net_of(
      std::span<const std::uint32_t> triangles) const;
  [[nodiscard]] std::span<const StarFace> star(std::uint32_t vertex) const {
    return {star_faces_.data() + star_start_[vertex],
            star_start_[vertex + 1] - star_start_[vertex]};
  }

  const BaseMesh& base_;
  std::vector<std::uint32_t> star_start_;
  std::vector<StarFace> star_faces_;
  std::vector<double> exponent_;  // per vertex
};

}  // namespace nacre::remesh
