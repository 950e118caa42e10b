// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/mesh_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "base/parallel.h"
#include "remesh/distance_to_triangle.h"

namespace nacre::remesh {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

float rounded_down(double x) {
  const auto y = static_cast<float>(x);
  return y > x ? std::nextafter(y, -kInfinity) : y;
}
float rounded_up(double x) {
  const auto y = static_cast<float>(x);
  return y < x ? std::nextafter(y, kInfinity) : y;
}

}  // namespace

struct MeshTree::Search {
  Vec3 query;
  double nearest = std::numeric_limits<double>::infinity();
  /// Boxes beyond its square hold nothing nearer.
  [[nodiscard]] bool reaches(double squared) const { return squared < nearest * nearest; }
};

void MeshTree::Bounds::add(const Bounds& o) {
  for (std::size_t i = 0; i < 3; ++i) {
    low[i] = std::min(low[i], o.low[i]);
    high[i] = std::max(high[i], o.high[i]);
  }
}

double MeshTree::squared_distance(const Bounds& bounds, const Vec3& p) {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double x = p[static_cast<Eigen::Index>(i)];
    const double off = std::max(
        {static_cast<double>(bounds.low[i]) - x, 0.0, x - static_cast<double>(bounds.high[i])});
    sum += off * off;
  }
  return sum;
}

MeshTree::Bounds MeshTree::bounds_of(const Triangle& t) const {
  Bounds bounds{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    const double a = mesh_.positions[t[0]][axis], b = mesh_.positions[t[1]][axis],
                 c = mesh_.positions[t[2]][axis];
    bounds.low[i] = rounded_down(std::min({a, b, c}));
    bounds.high[i] = rounded_up(std::max({a, b, c}));
  }
  return bounds;
}

MeshTree::MeshTree(const Scan& mesh, int levels) : mesh_(mesh), levels_(levels) {
  std::size_t count = mesh.triangles.size() >> (2 * levels);
  for (int level = 0; level < levels; ++level) bounds_.emplace_back(count << (2 * level));
  for (int level = levels - 1; level >= 0; --level) {
    auto& bounds = bounds_[static_cast<std::size_t>(level)];
    parallel_for_each_index(bounds.size(), [&](std::size_t i) {
      const auto child = [&](std::size_t k) {
        return level + 1 == levels ? bounds_of(mesh.triangles[4 * i + k])
                                   : bounds_[static_cast<std::size_t>(level) + 1][4 * i + k];
      };
      bounds[i] = child(0);
      for (std::size_t k = 1; k < 4; ++k) bounds[i].add(child(k));
    });
  }
  if (count == 0) return;
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  nodes_.reserve(2 * count);
  build(order.data(), order.data() + count);
}

std::uint32_t MeshTree::build(std::uint32_t* first, std::uint32_t* last) {
  const auto bounds_at = [&](std::uint32_t face) {
    return levels_ > 0 ? bounds_[0][face] : bounds_of(mesh_.triangles[face]);
  };
  Node node{bounds_at(*first), {*first, kNone}};
  for (const std::uint32_t* face = first + 1; face != last; ++face)
    node.bounds.add(bounds_at(*face));
  if (last - first > 1) {
    std::size_t axis = 0;
    const auto length = [&](std::size_t i) { return node.bounds.high[i] - node.bounds.low[i]; };
    for (std::size_t i = 1; i < 3; ++i)
      if (length(i) > length(axis)) axis = i;
    const auto centre = [&](std::uint32_t face) {
      const Bounds b = bounds_at(face);
      return std::pair(b.low[axis] + b.high[axis], face);
    };
    std::uint32_t* const middle = first + (last - first) / 2;
    std::nth_element(first, middle, last,
                     [&](std::uint32_t a, std::uint32_t b) { return centre(a) < centre(b); });
    node.child[0] = build(first, middle);
    node.child[1] = build(middle, last);
  }
  nodes_.push_back(node);
  return static_cast<std::uint32_t>(nodes_.size() - 1);
}

void MeshTree::visit_triangle(int level, std::size_t i, Search& search) const {
  if (level == levels_) {
    const Triangle& t = mesh_.triangles[i];
    const auto& p = mesh_.positions;
    search.nearest =
        std::min(search.nearest, distance_to_triangle(search.query, p[t[0]], p[t[1]], p[t[2]]));
    return;
  }
  if (level + 1 == levels_) {
    for (std::size_t k = 0; k < 4; ++k) visit_triangle(levels_, 4 * i + k, search);
    return;
  }
  std::array<std::pair<double, std::size_t>, 4> children;
  for (std::size_t k = 0; k < 4; ++k)
    children[k] = {
        squared_distance(bounds_[static_cast<std::size_t>(level) + 1][4 * i + k], search.query),
        4 * i + k};
  std::sort(children.begin(), children.end());
  for (const auto& [squared, child] : children)
    if (search.reaches(squared)) visit_triangle(level + 1, child, search);
}

void MeshTree::visit_node(std::uint32_t index, Search& search) const {
  const Node& node = nodes_[index];
  if (node.child[1] == kNone) {
    visit_triangle(0, node.child[0], search);
    return;
  }
  std::array<std::pair<double, std::uint32_t>, 2> children;
  for (std::size_t k = 0; k < 2; ++k)
    children[k] = {squared_distance(nodes_[node.child[k]].bounds, search.query), node.child[k]};
  if (children[1] < children[0]) std::swap(children[0], children[1]);
  for (const auto& [squared, child] : children)
    if (search.reaches(squared)) visit_node(child, search);
}

double MeshTree::distance(const Vec3& query) const {
  Search search{query};
  if (!nodes_.empty()) visit_node(static_cast<std::uint32_t>(nodes_.size() - 1), search);
  return search.nearest;
}

}  // namespace nacre::remesh
