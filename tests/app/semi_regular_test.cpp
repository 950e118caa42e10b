// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/semi_regular.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <set>

#include "app/files.h"
#include "base/topology.h"
#include "support/shapes.h"

namespace nacre::app::test {
namespace {

/// Other numbers for vertices, another order of triangles and of each one's corners.
Scan shuffled(const Scan& scan, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::uint32_t> number(scan.positions.size());
  std::iota(number.begin(), number.end(), 0u);
  std::ranges::shuffle(number, random);
  Scan out = scan;
  for (std::size_t v = 0; v < number.size(); ++v) out.positions[number[v]] = scan.positions[v];
  for (Triangle& t : out.triangles) {
    const auto turn = static_cast<std::size_t>(random() % 3);
    t = {number[t[turn]], number[t[(turn + 1) % 3]], number[t[(turn + 2) % 3]]};
  }
  std::ranges::shuffle(out.triangles, random);
  return out;
}

using Point = std::array<double, 3>;
using Face = std::array<Point, 3>;

/// A mesh without numbers: triangles by their corners' places, each begun at its lowest.
std::multiset<Face> faces_of(const Scan& scan) {
  std::multiset<Face> faces;
  for (const Triangle& t : scan.triangles) {
    Face face;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& p = scan.positions[t[k]];
      face[k] = {p[0], p[1], p[2]};
    }
    std::ranges::rotate(face, std::ranges::min_element(face));
    faces.insert(face);
  }
  return faces;
}

void expect_same_mesh(const Scan& scan, int levels, std::size_t base_triangles) {
  const auto found = recognise_subdivision(scan);
  ASSERT_TRUE(found.has_value()) << found.error().message;
  EXPECT_EQ(found->level_count, levels);
  EXPECT_EQ(found->base_triangles.size(), base_triangles);
  const auto back = to_triangles(*found);
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->positions.size(), scan.positions.size());
  EXPECT_EQ(faces_of(*back), faces_of(scan));
}

/// Random places, so that nothing but the connectivity helps.
Scan crumpled(Scan scan) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-1, 1);
  for (Vec3& p : scan.positions) p = {place(random), place(random), place(random)};
  return scan;
}

TEST(SemiRegular, FindsTheSplitsOfClosedAndOpenMeshes) {
  expect_same_mesh(crumpled(shapes::sphere(4)), 4, 8);
  expect_same_mesh(shapes::split(shapes::icosahedron(), 3), 3, 20);
  expect_same_mesh(shapes::split(shapes::torus(5, 7), 2), 2, 70);
  expect_same_mesh(crumpled(shapes::split(shapes::grid(3, 5), 2)), 2, 30);
}

TEST(SemiRegular, TheOrderOfVerticesAndTrianglesIsOfNoMatter) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    expect_same_mesh(shuffled(crumpled(shapes::split(shapes::icosahedron(), 3)), seed), 3, 20);
    expect_same_mesh(shuffled(crumpled(shapes::split(shapes::grid(3, 5), 2)), seed), 2, 30);
  }
}

/// A grid split in half everywhere: four choices at each level, of which some end early.
TEST(SemiRegular, RegularAllOver) {
  expect_same_mesh(shuffled(shapes::torus(16, 12), 3), 2, 24);
  expect_same_mesh(shuffled(shapes::torus(6, 10), 3), 1, 30);
}

TEST(SemiRegular, PiecesGoAsFarAsTheLeastOne) {
  const Scan both = shapes::joined(shapes::sphere(2), shapes::moved(shapes::sphere(4), {5, 0, 0}));
  expect_same_mesh(shuffled(both, 7), 2, 8 + 128);
}

TEST(SemiRegular, AsManyLevelsAsAreAskedFor) {
  const auto two = recognise_subdivision(shapes::sphere(4), 2);
  ASSERT_TRUE(two.has_value());
  EXPECT_EQ(two->level_count, 2);
  EXPECT_EQ(two->base_triangles.size(), 128u);
  const auto five = recognise_subdivision(shapes::sphere(4), 5);
  ASSERT_FALSE(five.has_value());
  EXPECT_EQ(five.error().code, ErrorCode::kGeometryRefused);
  EXPECT_NE(five.error().message.find("4 times, 5 were asked for"), std::string::npos);
}

TEST(SemiRegular, CornersThatNobodyJoinedAreWelded) {
  const Scan whole = shapes::sphere(3);
  Scan soup;
  for (const Triangle& t : whole.triangles) {
    const auto first = static_cast<std::uint32_t>(soup.positions.size());
    for (const std::uint32_t v : t) soup.positions.push_back(whole.positions[v]);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  const auto found = recognise_subdivision(soup);
  ASSERT_TRUE(found.has_value()) << found.error().message;
  EXPECT_EQ(found->level_count, 3);
  EXPECT_EQ(found->positions.size(), whole.positions.size());
}

TEST(SemiRegular, RefusesWhatNoSplitsMake) {
  const auto refusal = [](const Scan& scan) {
    const auto found = recognise_subdivision(scan);
    EXPECT_FALSE(found.has_value());
    if (found) return std::string();
    EXPECT_EQ(found.error().code, ErrorCode::kGeometryRefused);
    return found.error().message;
  };
  EXPECT_NE(refusal(shapes::icosahedron()).find("piece 0 of 1 (20 triangles)"), std::string::npos);
  refusal(shapes::tetrahedron());
  refusal(shapes::grid(3, 3));
  EXPECT_NE(refusal(shapes::joined(shapes::sphere(2), shapes::icosahedron())).find("piece 1 of 2"),
            std::string::npos);
  Scan torn = shapes::sphere(3);  // one flipped edge
  for (std::size_t f = 0; f < torn.triangles.size(); ++f) {
    Triangle &a = torn.triangles[0], &b = torn.triangles[f];
    for (std::size_t k = 0; k < 3 && f > 0; ++k) {
      if (b[k] != a[1] || b[(k + 1) % 3] != a[0]) continue;
      const std::uint32_t far = b[(k + 2) % 3];
      b = {far, a[1], a[2]};
      a = {far, a[2], a[0]};
      f = torn.triangles.size();
      break;
    }
  }
  refusal(torn);
  Scan turned = shapes::sphere(2);
  std::swap(turned.triangles[3][0], turned.triangles[3][1]);
  EXPECT_NE(refusal(turned).find("no oriented manifold"), std::string::npos);
}

}  // namespace
}  // namespace nacre::app::test
