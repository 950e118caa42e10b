// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/renumber.h"

#include <gtest/gtest.h>

#include <numeric>

#include "synthetic.h"

namespace nacre::codec {
namespace {

std::vector<Vec3> midpoint_positions(const Topology& topology, std::vector<Vec3> positions) {
  for (int j = 0; j < topology.level_count(); ++j)
    for (const Edge& e : topology.level(j).edges)
      positions.push_back((positions[e.vertex[0]] + positions[e.vertex[1]]) / 2);
  return positions;
}

/// The same base in another order of vertices, triangles and first corners.
struct Shuffled {
  std::vector<Triangle> triangles;
  std::vector<std::uint32_t> order;  // new vertex i is old vertex order[i]
};

Shuffled shuffle(const Scan& base, synthetic::Random& random) {
  Shuffled s;
  s.order.resize(base.positions.size());
  std::iota(s.order.begin(), s.order.end(), 0u);
  for (std::uint32_t i = static_cast<std::uint32_t>(s.order.size()); i > 1; --i)
    std::swap(s.order[i - 1], s.order[random.below(i)]);
  std::vector<std::uint32_t> inverse(s.order.size());
  for (std::uint32_t i = 0; i < s.order.size(); ++i) inverse[s.order[i]] = i;
  for (const Triangle& t : base.triangles) {
    const std::uint32_t turn = random.below(3);
    Triangle turned;
    for (std::uint32_t k = 0; k < 3; ++k) turned[k] = inverse[t[(k + turn) % 3]];
    s.triangles.push_back(turned);
  }
  for (std::uint32_t i = static_cast<std::uint32_t>(s.triangles.size()); i > 1; --i)
    std::swap(s.triangles[i - 1], s.triangles[random.below(i)]);
  return s;
}

TEST(CanonicalOrder, FindsEveryVertexOfEveryLevel) {
  synthetic::Random random(7);
  for (const Scan& base : {shapes::tetrahedron(), shapes::torus(5, 4), shapes::grid(3, 2),
                           synthetic::irregular_base()}) {
    const auto count = static_cast<std::uint32_t>(base.positions.size());
    const Shuffled other = shuffle(base, random);
    const Topology input = *Topology::build(base.triangles, count, 3);
    const Topology canonical = *Topology::build(other.triangles, count, 3);
    const auto order = canonical_order(input, canonical, other.order);
    ASSERT_TRUE(order.has_value());
    // Midpoint subdivision places a vertex by its ancestors alone, whatever the numbering.
    const auto expected = midpoint_positions(input, base.positions);
    std::vector<Vec3> start;
    for (const std::uint32_t v : other.order) start.push_back(base.positions[v]);
    const auto actual = midpoint_positions(canonical, start);
    for (std::size_t i = 0; i < actual.size(); ++i)
      ASSERT_LT((actual[i] - expected[(*order)[i]]).norm(), 1e-14) << i;
    std::vector<std::uint32_t> sorted = *order;
    std::sort(sorted.begin(), sorted.end());
    for (std::uint32_t i = 0; i < sorted.size(); ++i) ASSERT_EQ(sorted[i], i);
  }
}

TEST(CanonicalOrder, RefusesMeshesThatDiffer) {
  const Scan base = shapes::octahedron();
  const Topology input = *Topology::build(base.triangles, 6, 1);
  auto triangles = base.triangles;
  std::vector<std::uint32_t> order = {0, 1, 2, 3, 4, 5};
  std::swap(order[0], order[1]);  // a mirror image
  const auto mirrored = canonical_order(input, *Topology::build(triangles, 6, 1), order);
  ASSERT_FALSE(mirrored.has_value());
  EXPECT_EQ(mirrored.error().code, ErrorCode::kBadInput);
  EXPECT_FALSE(canonical_order(input, *Topology::build(triangles, 6, 2), order).has_value());
}

}  // namespace
}  // namespace nacre::codec
