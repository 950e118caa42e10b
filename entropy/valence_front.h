// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "base/geometry.h"

namespace nacre::entropy {

/// The border between the triangles already coded and the rest of a closed triangulation: loops of
/// nodes. A node is one wedge of uncoded triangles at a vertex; its slots are the uncoded edges
/// inside the wedge, so the wedge has slots + 1 triangles. Node n and its successor span an edge;
/// the uncoded triangle on it is (vertex of n, vertex of successor, ...), counter-clockwise.
///
/// Loops need no names: joining a node to one of its own loop splits the loop, joining it to one of
/// another loop merges the two, and both are the same relinking.
class ValenceFront {
 public:
  struct Node {
    std::uint32_t vertex;
    std::uint32_t slots;
    std::uint32_t previous, next;
    bool dummy;
    bool alive;
  };

  /// The two nodes that a join leaves at the joined vertex.
  struct Joined {
    std::uint32_t after_focus, before_successor;
  };

  [[nodiscard]] const Node& operator[](std::uint32_t node) const { return nodes_[node]; }
  [[nodiscard]] bool empty() const { return alive_count_ == 0; }
  [[nodiscard]] std::uint32_t alive_count() const { return alive_count_; }

  /// Opens a loop around one coded triangle (a, b, c); returns its nodes. Valences are >= 2.
  Triangle open(const Triangle& vertices, const Triangle& valences,
                const std::array<bool, 3>& dummies);

  /// The node to work on: one without slots; else a dummy; else one with the fewest slots, the
  /// latest to get that few. Not on an empty front.
  [[nodiscard]] std::uint32_t focus();

  // Each of the following codes one triangle. They return false, or kNone, and leave the front
  // unusable where no closed triangulation has such a triangle.

  /// Triangle (previous, node, next) at a node without slots.
  [[nodiscard]] bool close(std::uint32_t node);
  /// Triangle (node, next, a new vertex); returns the new node. Both have slots.
  [[nodiscard]] std::uint32_t add(std::uint32_t node, std::uint32_t vertex, std::uint32_t valence,
                                  bool dummy);
  /// Triangle (node, next, vertex of `other`), in other's wedge with `skipped` slots between
  /// other's successor and the triangle.
  [[nodiscard]] bool join(std::uint32_t node, std::uint32_t other, std::uint32_t skipped,
                          Joined& joined);

  // The triangles that a join could make, numbered node by node in order of creation. Nodes that
  // the focus cannot join (itself and two to either side) and dummies have none.
  [[nodiscard]] std::uint64_t join_count(std::uint32_t node);
  [[nodiscard]] std::uint64_t join_index(std::uint32_t node, std::uint32_t other,
                                         std::uint32_t skipped);
  struct JoinPlace {
    std::uint32_t other, skipped;
  };
  [[nodiscard]] JoinPlace join_place(std::uint32_t node, std::uint64_t index);

 private:
  std::uint32_t create(std::uint32_t vertex, std::uint32_t slots, bool dummy);
  void set_slots(std::uint32_t node, std::uint32_t slots);
  void remove(std::uint32_t node);
  void link(std::uint32_t first, std::uint32_t second);
  [[nodiscard]] std::size_t bucket_of(const Node& node) const;
  [[nodiscard]] std::uint64_t joins_at(const Node& node) const;
  void add_weight(std::uint32_t node, std::uint64_t change);
  [[nodiscard]] std::uint64_t weight_below(std::uint32_t node) const;
  void hide_neighbours(std::uint32_t node, bool hide);

  std::vector<Node> nodes_;
  std::uint32_t alive_count_ = 0;
  /// Nodes by urgency, the latest last; entries that no longer hold are skipped when met.
  std::vector<std::vector<std::uint32_t>> buckets_;
  /// Fenwick tree over nodes of the joins possible at each; sums wrap harmlessly modulo 2^64.
  std::vector<std::uint64_t> tree_;
};

}  // namespace nacre::entropy
