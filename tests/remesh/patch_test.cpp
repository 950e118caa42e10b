// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/patch.h"

#include <gtest/gtest.h>

#include <utility>

#include "remesh/relax.h"
#include "remesh/simplify.h"
#include "support/shapes.h"
#include "wavelet/wavelet.h"

namespace nacre::remesh {
namespace {

using Movable = PatchUnfolder::Movable;

/// A sphere's normal mesh of two levels, as a Refinement that may be damaged.
class PatchUnfolderTest : public ::testing::Test {
 protected:
  PatchUnfolderTest()
      : scan_(shapes::sphere(4)),
        parameterisation_(mapped(scan_)),
        map_(scan_, parameterisation_),
        tree_(scan_),
        topology_(*Topology::build(parameterisation_.base.triangles, base_vertices(), 2)),
        mesh_(map_, parameterisation_.base, tree_, topology_) {
    PierceOptions options;
    options.levels = 2;
    const auto out = pierce(map_, parameterisation_, tree_, wavelet::predict_level, options);
    mesh_.resize(out->mesh.positions.size());
    for (std::size_t v = 0; v < out->mesh.positions.size(); ++v) {
      const Vec3& p = out->mesh.positions[v];
      mesh_.store(v, tree_.nearest(p), p, static_cast<Refinement::Kind>(out->kind[v]));
    }
  }

  static Parameterisation mapped(const Scan& scan) {
    SimplifyOptions options;
    options.base_vertices = 30;
    Parameterisation map = *simplify(scan, options);
    relax(scan, map, {});
    return map;
  }
  [[nodiscard]] std::uint32_t base_vertices() const {
    return static_cast<std::uint32_t>(parameterisation_.base.scan_vertex.size());
  }
  void swap_places(std::uint32_t a, std::uint32_t b) {
    const Refinement::Place place = mesh_.place(a);
    mesh_.put(a, mesh_.place(b));
    mesh_.put(b, place);
  }
  std::vector<std::uint32_t> unfold(Movable movable) {
    return PatchUnfolder(mesh_, 2, movable).run(mesh_.folded_triangles(2), 100'000);
  }

  Scan scan_;
  Parameterisation parameterisation_;
  SurfaceMap map_;
  LineTree tree_;
  Topology topology_;
  Refinement mesh_;
};

TEST_F(PatchUnfolderTest, LeavesWhatIsWellAlone) {
  const auto before = mesh_.positions;
  EXPECT_TRUE(mesh_.folded_triangles(2).empty());
  EXPECT_TRUE(unfold(Movable::kAll).empty());
  EXPECT_EQ(mesh_.positions, before);
}

TEST_F(PatchUnfolderTest, MendsTwoOfTheNewestThatHaveChangedPlaces) {
  // The middles of two sides of one triangle.
  const Triangle& t = topology_.level(2).triangles[4 * 7 + 3];
  swap_places(t[0], t[1]);
  const auto before = mesh_.positions;
  ASSERT_FALSE(mesh_.folded_triangles(2).empty());
  EXPECT_TRUE(unfold(Movable::kNewest).empty());
  EXPECT_TRUE(mesh_.folded_triangles(2).empty());
  for (std::uint32_t v = 0; v < topology_.level(1).vertex_count; ++v)
    EXPECT_EQ(mesh_.positions[v], before[v]) << v;
  for (std::size_t v = 0; v < mesh_.positions.size(); ++v)
    EXPECT_NEAR(
        (mesh_.positions[v] - position_of(mesh_.surface(v), scan_.triangles, scan_.positions))
            .norm(),
        0, 1e-9);
}

TEST_F(PatchUnfolderTest, MovesOlderVerticesOnlyWhereAllowed) {
  // Two vertices of level 1 that are joined by an edge of that level.
  const Triangle& t = topology_.level(1).triangles[4 * 5 + 3];
  swap_places(t[0], t[1]);
  const auto before = mesh_.positions;
  ASSERT_FALSE(mesh_.folded_triangles(2).empty());
  EXPECT_FALSE(unfold(Movable::kNewest).empty());
  EXPECT_EQ(mesh_.positions[t[0]], before[t[0]]);
  for (std::size_t v = 0; v < before.size(); ++v)
    EXPECT_TRUE(v >= topology_.level(1).vertex_count || mesh_.positions[v] == before[v]) << v;
}

TEST_F(PatchUnfolderTest, LeavesBaseCornersWhereTheyAreOnFinerLevels) {
  const Triangle& t = topology_.level(2).triangles[4 * 9 + 3];
  swap_places(t[1], t[2]);
  const auto before = mesh_.positions;
  EXPECT_TRUE(unfold(Movable::kAll).empty());
  for (std::uint32_t v = 0; v < base_vertices(); ++v) EXPECT_EQ(mesh_.positions[v], before[v]);
}

TEST_F(PatchUnfolderTest, SearchMendsWhatHasChangedPlacesAndLeavesTheRest) {
  const Triangle& t = topology_.level(2).triangles[4 * 7 + 3];
  swap_places(t[0], t[1]);
  const auto before = mesh_.positions;
  const auto folded = mesh_.opposed_triangles(2);
  ASSERT_FALSE(folded.empty());
  PatchUnfolder(mesh_, 2, Movable::kNewest).search(folded);
  EXPECT_TRUE(mesh_.opposed_triangles(2).empty());
  std::size_t moved = 0;
  for (std::size_t v = 0; v < before.size(); ++v) moved += mesh_.positions[v] != before[v];
  EXPECT_GE(moved, 1u);
  EXPECT_LE(moved, 12u);
  for (std::uint32_t v = 0; v < topology_.level(1).vertex_count; ++v)
    EXPECT_EQ(mesh_.positions[v], before[v]) << v;
}

TEST_F(PatchUnfolderTest, SearchLeavesWhatIsWellAlone) {
  const auto before = mesh_.positions;
  EXPECT_TRUE(mesh_.opposed_triangles(2).empty());
  PatchUnfolder(mesh_, 2, Movable::kAll).search({0, 1, 2, 3});
  EXPECT_EQ(mesh_.positions, before);
}

TEST_F(PatchUnfolderTest, JournalTakesAllBack) {
  const Triangle& t = topology_.level(2).triangles[4 * 7 + 3];
  swap_places(t[0], t[1]);
  const auto positions = mesh_.positions;
  const auto kinds = mesh_.kind;
  Refinement::Journal journal;
  mesh_.journal = &journal;
  EXPECT_TRUE(unfold(Movable::kAll).empty());
  mesh_.journal = nullptr;
  EXPECT_NE(mesh_.positions, positions);
  for (const auto& [vertex, earlier] : journal) mesh_.put(vertex, earlier.place);
  EXPECT_EQ(mesh_.positions, positions);
  EXPECT_EQ(mesh_.kind, kinds);
}

}  // namespace
}  // namespace nacre::remesh
