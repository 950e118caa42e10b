// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/adjacency.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "map_checks.h"
#include "support/transforms.h"

namespace nacre::remesh {
namespace {

/// From the definition: every pair of sides is looked at.
std::vector<Triangle> slow_neighbors(const std::vector<Triangle>& triangles) {
  std::vector<Triangle> out(triangles.size(), Triangle{kNone, kNone, kNone});
  for (std::uint32_t f = 0; f < triangles.size(); ++f) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      std::uint32_t partner = kNone, partners = 0, twins = 0;
      for (std::uint32_t g = 0; g < triangles.size(); ++g) {
        for (std::uint32_t m = 0; m < 3; ++m) {
          const std::uint32_t a = triangles[g][m], b = triangles[g][(m + 1) % 3];
          if (a == triangles[f][(k + 1) % 3] && b == triangles[f][k]) partner = g, ++partners;
          if (a == triangles[f][k] && b == triangles[f][(k + 1) % 3]) ++twins;
        }
      }
      if (partners == 1 && twins == 1) out[f][k] = partner;
    }
  }
  return out;
}

std::vector<Scan> small_scans() {
  return {shapes::tetrahedron(), shapes::sphere(2),
          shapes::torus(7, 5),   shapes::grid(5, 4),
          shapes::hemisphere(2), shapes::holed_grid(5, 2, 3),
          shapes::plate(2),      shapes::icosahedron(),
          shapes::moebius(7),    {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}}};
}

TEST(SideNeighbors, AreThoseOfTheDefinition) {
  for (const Scan& plain : small_scans()) {
    const Scan scan = transforms::renumbered(plain, 5);
    EXPECT_EQ(side_neighbors(scan.triangles, static_cast<std::uint32_t>(scan.positions.size())),
              slow_neighbors(scan.triangles));
  }
}

TEST(SideNeighbors, LeaveCrowdedSidesAlone) {
  TestRandom random(3);
  for (int i = 0; i < 200; ++i) {
    std::vector<Triangle> triangles;
    const std::uint32_t vertices = 4 + random.below(10);
    for (std::uint32_t f = 0; f < 25; ++f) {
      const std::uint32_t a = random.below(vertices);
      const std::uint32_t b = (a + 1 + random.below(vertices - 1)) % vertices;
      std::uint32_t c = random.below(vertices);
      while (c == a || c == b) c = (c + 1) % vertices;
      triangles.push_back({a, b, c});
    }
    ASSERT_EQ(side_neighbors(triangles, vertices), slow_neighbors(triangles));
  }
}

TEST(CollectStar, HasEveryFaceOfTheVertexInOrder) {
  for (const Scan& plain : small_scans()) {
    const Scan scan = transforms::renumbered(plain, 9);
    if (!testing::facts_of(scan).defect.empty()) continue;  // not orientable: no order to have
    const auto neighbors =
        side_neighbors(scan.triangles, static_cast<std::uint32_t>(scan.positions.size()));
    const auto boundary = testing::boundary_vertices(scan);
    Star star;
    for (std::uint32_t f = 0; f < scan.triangles.size(); ++f) {
      for (const std::uint32_t v : scan.triangles[f]) {
        collect_star(scan.triangles, neighbors, v, f, star);
        EXPECT_EQ(star.boundary, boundary[v] != 0);
        EXPECT_EQ(star.ring.size(), star.faces.size() + (star.boundary ? 1 : 0));
        std::vector<std::uint32_t> expected, got = star.faces;
        for (std::uint32_t g = 0; g < scan.triangles.size(); ++g) {
          const Triangle& t = scan.triangles[g];
          if (std::find(t.begin(), t.end(), v) != t.end()) expected.push_back(g);
        }
        std::sort(got.begin(), got.end());
        EXPECT_EQ(got, expected);
        for (std::size_t m = 0; m < star.faces.size(); ++m) {
          const Triangle& t = scan.triangles[star.faces[m]];
          const std::uint32_t c = corner_of(t, v);
          EXPECT_EQ(t[(c + 1) % 3], star.ring[m]);
          EXPECT_EQ(t[(c + 2) % 3], star.ring_at(m + 1));
        }
      }
    }
  }
}

TEST(CollectStar, OfAnInteriorVertexStartsAtTheGivenFace) {
  const Scan scan = shapes::sphere(2);
  const auto neighbors =
      side_neighbors(scan.triangles, static_cast<std::uint32_t>(scan.positions.size()));
  Star star;
  for (std::uint32_t f = 0; f < scan.triangles.size(); ++f) {
    collect_star(scan.triangles, neighbors, scan.triangles[f][1], f, star);
    EXPECT_EQ(star.faces[0], f);
  }
}

TEST(FaceOfVertex, IsAFaceOfTheVertexOrNone) {
  Scan scan = shapes::grid(3, 3);
  scan.positions.emplace_back(9, 9, 9);
  const auto face =
      face_of_vertex(scan.triangles, static_cast<std::uint32_t>(scan.positions.size()));
  for (std::uint32_t v = 0; v + 1 < scan.positions.size(); ++v) {
    const Triangle& t = scan.triangles[face[v]];
    EXPECT_NE(std::find(t.begin(), t.end(), v), t.end());
  }
  EXPECT_EQ(face.back(), kNone);
}

}  // namespace
}  // namespace nacre::remesh
