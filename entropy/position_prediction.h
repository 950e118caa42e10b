// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "entropy/closed_mesh.h"
#include "entropy/connectivity.h"

namespace nacre::entropy {

/// Sums of grid coordinates and their products. Coordinates are below 2^24 and at most
/// kMostNeighbours of them meet in one sum, so products of two differences add up to below 2^62.
using Wide3 = std::array<std::int64_t, 3>;

inline constexpr std::int64_t kMostNeighbours = 256;

/// a / b rounded to nearest, halves away from zero; b > 0.
[[nodiscard]] constexpr std::int64_t divide(std::int64_t a, std::int64_t b) {
  return a >= 0 ? (a + b / 2) / b : -((-a + b / 2) / b);
}

[[nodiscard]] constexpr std::int64_t squared(const Wide3& a) {
  return a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
}

/// Hands out the vertices one by one. Next is always one with the most triangles whose other two
/// corners are out, then with the most neighbours out; the latest of equals.
class PositionOrder {
 public:
  explicit PositionOrder(const ClosedMesh& mesh);

  /// The vertex to do next; kNone when all are done.
  [[nodiscard]] std::uint32_t next();
  void finish(std::uint32_t vertex);

  /// Dummies are never done.
  [[nodiscard]] bool done(std::uint32_t vertex) const {
    return !mesh_.is_dummy(vertex) && done_[vertex];
  }
  /// Valence less 6, at most 3; dummies count as neighbours.
  [[nodiscard]] std::int64_t excess(std::uint32_t vertex) const {
    return std::int64_t{mesh_.valences[vertex] < 9 ? mesh_.valences[vertex] : 9} - 6;
  }

  /// Calls body(a, b, c) for each triangle (vertex, a, b), counter-clockwise, c being the vertex
  /// across edge (a, b). Any may be dummies.
  template <class Body>
  void for_each_triangle(std::uint32_t vertex, const Body& body) const {
    std::uint32_t h = edge_of_[vertex];
    do {
      const std::uint32_t across = mesh_.twins[next_side(h)];
      body(mesh_.from(next_side(h)), mesh_.from(previous_side(h)),
           mesh_.from(previous_side(across)));
      h = mesh_.twins[previous_side(h)];
    } while (h != edge_of_[vertex]);
  }
  /// The same, while body(a, b, c) is true.
  template <class Body>
  void for_triangles_while(std::uint32_t vertex, const Body& body) const {
    std::uint32_t h = edge_of_[vertex];
    do {
      const std::uint32_t across = mesh_.twins[next_side(h)];
      if (!body(mesh_.from(next_side(h)), mesh_.from(previous_side(h)),
                mesh_.from(previous_side(across))))
        return;
      h = mesh_.twins[previous_side(h)];
    } while (h != edge_of_[vertex]);
  }

 private:
  void raise(std::uint32_t vertex, std::uint32_t by);

  const ClosedMesh& mesh_;
  std::vector<std::uint32_t> edge_of_;  // vertex → the last half-edge from it
  std::vector<bool> done_;
  std::vector<std::uint32_t> keys_;
  std::vector<std::vector<std::uint32_t>> buckets_;
  std::uint32_t first_ = 0;
};

struct Prediction {
  Wide3 point{};       ///< inside the grid
  Wide3 fine_point{};  ///< the same in 1/16 of a step, not held inside
  Wide3 normal{};      ///< of the triangles beyond its neighbours; zero if there are none
  int scale = 0;       ///< bit length of the squared local edge length, at least 2
  int neighbours = 0;  ///< done ones, counted up to 4
};

/// How far parallelograms reach on one mesh, in 1/256 on top of what suits coarse scans; the
/// encoder chooses.
inline constexpr std::array<std::int64_t, 4> kReaches = {0, -28, 28, 72};

/// Predicts the position of a vertex from those done. `default_scale` is for where no edge is
/// known.
[[nodiscard]] Prediction predict_position(const PositionOrder& order,
                                          std::span<const GridPoint> points, std::uint32_t vertex,
                                          int bits, int default_scale, std::int64_t reach);

}  // namespace nacre::entropy
