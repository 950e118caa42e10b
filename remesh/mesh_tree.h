// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "base/scan.h"

namespace nacre::remesh {

/// Distances to the finest triangles of a semi-regular mesh, which need no sorting: those of a base
/// triangle, of its quarters and so on stand together. It takes 8 bytes for each triangle, where a
/// LineTree takes 130. Keeps a reference to the mesh; safe to share between threads.
class MeshTree {
 public:
  /// `mesh` has 4^levels triangles for each one of its base, all coordinates finite.
  MeshTree(const Scan& mesh, int levels);
  /// Of a point from the nearest triangle; infinity if there is none.
  [[nodiscard]] double distance(const Vec3& query) const;

 private:
  /// Rounded outwards.
  struct Bounds {
    std::array<float, 3> low, high;
    void add(const Bounds& o);
  };
  /// Over base triangles; a leaf has one.
  struct Node {
    Bounds bounds;
    std::uint32_t child[2];  // child[1] == kNone: a leaf, and child[0] is its base triangle
  };
  struct Search;

  [[nodiscard]] Bounds bounds_of(const Triangle& t) const;
  std::uint32_t build(std::uint32_t* first, std::uint32_t* last);
  static double squared_distance(const Bounds& bounds, const Vec3& p);
  void visit_node(std::uint32_t node, Search& search) const;
  /// Triangle `i` of the level.
  void visit_triangle(int level, std::size_t i, Search& search) const;

  const Scan& mesh_;
  int levels_;
  std::vector<std::vector<Bounds>> bounds_;  // of the triangles of each level but the finest
  std::vector<Node> nodes_;                  // the last one is the root
};

}  // namespace nacre::remesh
