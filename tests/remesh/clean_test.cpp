// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "remesh/remesh.h"
#include "support/manifold.h"
#include "support/random.h"
#include "support/shapes.h"

namespace nacre::remesh {
namespace {

using Ids = std::vector<std::size_t>;

constexpr std::size_t kAny = SIZE_MAX;

/// Expected actions: kind → how often and, unless empty, the first ids.
struct Expected {
  std::size_t count;
  Ids first_ids;
};
using Actions = std::map<std::string, Expected>;

void expect_manifold(const CleanScan& out) {
  const ManifoldFacts facts = manifold_facts(out.scan.triangles, out.scan.positions.size());
  ASSERT_EQ(facts.defect, "");
  EXPECT_EQ(out.report.vertices, out.scan.positions.size());
  EXPECT_EQ(out.report.triangles, out.scan.triangles.size());
  EXPECT_EQ(out.report.pieces, facts.pieces);
  EXPECT_EQ(out.report.closed_pieces, facts.closed_pieces);
  EXPECT_EQ(out.report.boundary_loops, facts.boundary_loops);
  EXPECT_EQ(out.report.genus, facts.genus);
  // Piece numbers: all of 0 .. pieces - 1, the same for all triangles of a vertex.
  ASSERT_EQ(out.piece.size(), out.scan.triangles.size());
  std::vector<std::uint32_t> of_vertex(out.scan.positions.size(), kNone);
  for (std::size_t f = 0; f < out.piece.size(); ++f) {
    for (const std::uint32_t v : out.scan.triangles[f]) {
      if (of_vertex[v] == kNone) of_vertex[v] = out.piece[f];
      EXPECT_EQ(of_vertex[v], out.piece[f]);
    }
  }
  const std::set<std::uint32_t> used(out.piece.begin(), out.piece.end());
  EXPECT_EQ(used.size(), facts.pieces);
  if (!used.empty()) {
    EXPECT_EQ(*used.rbegin() + 1, facts.pieces);
  }
}

void expect_actions(const CleanReport& report, const Actions& expected) {
  EXPECT_EQ(report.actions.size(), expected.size());
  for (const CleanAction& action : report.actions) {
    const auto it = expected.find(action.kind);
    if (it == expected.end()) {
      ADD_FAILURE() << "not asked for: " << action.count << " " << action.kind;
      continue;
    }
    if (it->second.count != kAny) {
      EXPECT_EQ(action.count, it->second.count) << action.kind;
    }
    EXPECT_EQ(action.first_ids.size(), std::min<std::size_t>(8, action.count)) << action.kind;
    if (!it->second.first_ids.empty()) {
      EXPECT_EQ(action.first_ids, it->second.first_ids) << action.kind;
    }
  }
}

struct Shape {
  std::size_t pieces, closed, loops;
  int genus;
};

CleanScan cleaned(const Scan& scan, const Actions& actions, const Shape& shape) {
  const auto out = clean(scan);
  EXPECT_TRUE(out.has_value());
  if (!out) return {};
  expect_manifold(*out);
  expect_actions(out->report, actions);
  EXPECT_EQ(out->report.pieces, shape.pieces);
  EXPECT_EQ(out->report.closed_pieces, shape.closed);
  EXPECT_EQ(out->report.boundary_loops, shape.loops);
  EXPECT_EQ(out->report.genus, shape.genus);
  return *out;
}

TEST(Clean, LeavesAHealthyScanAlone) {
  Scan far = shapes::torus(9, 7);
  far.origin = {1e6, 2e6, -3};
  const std::vector<std::pair<Scan, Shape>> healthy = {
      {shapes::tetrahedron(), {1, 1, 0, 0}},
      {shapes::sphere(3), {1, 1, 0, 0}},
      {far, {1, 1, 0, 1}},
      {shapes::plate(2), {1, 1, 0, 2}},
      {shapes::plate(5), {1, 1, 0, 5}},
      {shapes::grid(4, 3), {1, 0, 1, 0}},
      {shapes::holed_grid(6, 2, 4), {1, 0, 2, 0}},
      {shapes::hemisphere(3), {1, 0, 1, 0}},
      {shapes::joined(shapes::torus(6, 5), shapes::moved(shapes::grid(2, 2), {9, 9, 9})),
       {2, 1, 1, 1}},
  };
  for (const auto& [scan, shape] : healthy) {
    const CleanScan out = cleaned(scan, {}, shape);
    EXPECT_EQ(out.scan.triangles.size(), scan.triangles.size());
    EXPECT_EQ(out.scan.positions.size(), scan.positions.size());
    EXPECT_EQ(out.scan.origin, scan.origin);
    for (std::size_t f = 0; f < scan.triangles.size(); ++f)
      for (std::size_t k = 0; k < 3; ++k)
        EXPECT_EQ(out.scan.positions[out.scan.triangles[f][k]],
                  scan.positions[scan.triangles[f][k]]);
    for (const RepairPolicy policy : {RepairPolicy::kStrict, RepairPolicy::kNone})
      EXPECT_TRUE(clean(scan, policy).has_value());
  }
}

TEST(Clean, WeldsASoupWithoutSharedVertices) {
  // Triangles {0,1,2} {0,3,1} {0,2,3} {1,3,2}: of the soup's vertices 0, 1, 2 and 4 come first.
  const CleanScan out =
      cleaned(shapes::exploded(shapes::tetrahedron()),
              {{"welded vertices", {8, {3, 5, 6, 7, 8, 9, 10, 11}}}}, {1, 1, 0, 0});
  EXPECT_EQ(out.scan.positions.size(), 4u);
  cleaned(shapes::exploded(shapes::torus(8, 6)), {{"welded vertices", {96 * 3 - 48, {}}}},
          {1, 1, 0, 1});
}

TEST(Clean, DropsDegenerateAndDuplicateFacesAndIsolatedVertices) {
  Scan scan = shapes::octahedron();
  scan.positions.push_back(scan.positions[2]);  // 6: the same place as 2
  scan.positions.emplace_back(7, 7, 7);         // 7: on no face
  scan.triangles.push_back({0, 0, 2});          // 8: one corner twice
  scan.triangles.push_back({3, 3, 3});          // 9: three times
  scan.triangles.push_back({0, 2, 6});          // 10: twice once welded
  scan.triangles.push_back({1, 4, 2});          // 11: face 1 from another corner
  scan.triangles.push_back({4, 3, 1});          // 12: face 2 the other way round
  scan.triangles.push_back({6, 1, 4});          // 13: face 1 by welding
  const CleanScan out = cleaned(scan,
                                {{"welded vertices", {1, {6}}},
                                 {"dropped isolated vertices", {1, {7}}},
                                 {"dropped degenerate faces", {3, {8, 9, 10}}},
                                 {"dropped duplicate faces", {3, {11, 12, 13}}}},
                                {1, 1, 0, 0});
  EXPECT_EQ(out.scan.triangles.size(), 8u);
  EXPECT_EQ(out.scan.positions.size(), 6u);
}

TEST(Clean, DropsADuplicatedShell) {
  const Scan one = shapes::sphere(2);
  const std::size_t faces = one.triangles.size();
  Scan inverted = one;
  for (Triangle& t : inverted.triangles) std::swap(t[0], t[1]);
  for (const Scan& second : {one, inverted}) {
    const Ids ids = {faces,     faces + 1, faces + 2, faces + 3,
                     faces + 4, faces + 5, faces + 6, faces + 7};
    const CleanScan out = cleaned(shapes::joined(one, second),
                                  {{"welded vertices", {one.positions.size(), {}}},
                                   {"dropped duplicate faces", {faces, ids}}},
                                  {1, 1, 0, 0});
    EXPECT_NEAR(shapes::volume(out.scan), shapes::volume(one), 1e-12);
  }
}

TEST(Clean, SplitsABowTie) {
  // Two tetrahedra that share vertex 0, by index and by place.
  Scan scan = shapes::tetrahedron();
  const Scan other = shapes::tetrahedron();
  for (std::size_t v = 1; v < 4; ++v)
    scan.positions.push_back(2 * scan.positions[0] - other.positions[v]);
  for (const Triangle& t : other.triangles) {
    Triangle mirrored;
    for (std::size_t k = 0; k < 3; ++k) mirrored[k] = t[k] == 0 ? 0 : t[k] + 3;
    std::swap(mirrored[0], mirrored[1]);
    scan.triangles.push_back(mirrored);
  }
  const CleanScan out = cleaned(scan, {{"split non-manifold vertices", {1, {0}}}}, {2, 2, 0, 0});
  EXPECT_EQ(out.scan.positions.size(), 8u);
  EXPECT_NEAR(shapes::volume(out.scan), 2 * shapes::volume(other), 1e-12);
  // Two open triangles that meet in a point.
  const Scan open = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}},
                     {{0, 1, 2}, {0, 3, 4}}};
  cleaned(open, {{"split non-manifold vertices", {1, {0}}}}, {2, 0, 2, 0});
}

/// `scan` with the vertices of equal coordinates made one, and the others left alone.
Scan shared(const Scan& scan) {
  std::map<std::array<double, 3>, std::uint32_t> first;
  Scan out = scan;
  for (Triangle& t : out.triangles)
    for (std::uint32_t& v : t) {
      const Vec3& p = scan.positions[v];
      v = first.emplace(std::array{p[0], p[1], p[2]}, v).first->second;
    }
  return out;
}

TEST(Clean, PartsTwoSpheresThatTouchInAVertex) {
  const Scan one = shapes::sphere(2);
  const Scan scan = shapes::joined(one, shapes::moved(one, {2, 0, 0}));
  const std::size_t n = one.positions.size();
  // Each with a vertex of its own: there is nothing to do.
  EXPECT_EQ(cleaned(scan, {}, {2, 2, 0, 0}).scan.positions.size(), 2 * n);
  const CleanScan out = cleaned(
      shared(scan),
      {{"dropped isolated vertices", {1, {n + 1}}}, {"split non-manifold vertices", {1, {0}}}},
      {2, 2, 0, 0});
  EXPECT_EQ(out.scan.positions.size(), 2 * n);
  const CleanScan soup =
      cleaned(shapes::exploded(scan), {{"welded vertices", {kAny, {}}}}, {2, 2, 0, 0});
  EXPECT_EQ(soup.scan.positions.size(), 2 * n);
}

TEST(Clean, CutsAFinOffAFlatSheet) {
  // 2 × 2 squares; the fin stands on the inner edge from (1, 1) to (1, 0), vertices 4 and 3.
  Scan scan = shapes::grid(2, 2);
  scan.positions.emplace_back(1, 0.5, 1);
  scan.triangles.push_back({3, 4, 9});
  const CleanScan out = cleaned(
      scan,
      {{"cut edges of three or more faces", {1, {}}}, {"split non-manifold vertices", {2, {3, 4}}}},
      {2, 0, 2, 0});
  EXPECT_EQ(out.scan.triangles.size(), 9u);
  EXPECT_EQ(out.scan.positions.size(), 12u);
}

TEST(Clean, CutsAFinOffAClosedSurface) {
  // Wherever the fin comes in the list, whichever way it is wound, however steep it stands.
  for (const Scan& closed : {shapes::octahedron(), shapes::sphere(2)}) {
    for (const bool first : {true, false}) {
      for (const bool reversed : {true, false}) {
        Scan scan = closed;
        const Triangle t = scan.triangles[5];
        const auto tip = static_cast<std::uint32_t>(scan.positions.size());
        scan.positions.push_back(scan.positions[t[0]] + scan.positions[t[1]]);
        const Triangle fin = reversed ? Triangle{t[1], t[0], tip} : Triangle{t[0], t[1], tip};
        scan.triangles.insert(first ? scan.triangles.begin() : scan.triangles.end(), fin);
        const CleanScan out = cleaned(scan,
                                      {{"cut edges of three or more faces", {1, {}}},
                                       {"split non-manifold vertices", {2, {}}}},
                                      {2, 1, 1, 0});
        EXPECT_EQ(out.scan.triangles.size(), closed.triangles.size() + 1);
        EXPECT_EQ(out.scan.positions.size(), closed.positions.size() + 3);
      }
    }
  }
}

TEST(Clean, TwoSolidsThatShareAnEdgeStayTwo) {
  // Octahedra, the second turned half round about the middle of the edge from vertex 0 to vertex 2.
  const Scan one = shapes::octahedron();
  Scan two = one;
  for (Vec3& p : two.positions) p = {1 - p[0], 1 - p[1], p[2]};
  const Scan both = shapes::joined(one, two);
  cleaned(both, {}, {2, 2, 0, 0});
  const CleanScan out = cleaned(shared(both),
                                {{"dropped isolated vertices", {2, {6, 8}}},
                                 {"cut edges of three or more faces", {1, {0}}},
                                 {"split non-manifold vertices", {2, {0, 2}}}},
                                {2, 2, 0, 0});
  EXPECT_EQ(out.scan.triangles.size(), 16u);
  EXPECT_NEAR(shapes::volume(out.scan), 2 * shapes::volume(one), 1e-12);
}

TEST(Clean, CutsAMoebiusStripOnce) {
  for (const std::uint32_t n : {5u, 8u, 40u}) {
    const CleanScan out = cleaned(shapes::moebius(n),
                                  {{"cut one-sided edges", {1, {}}},
                                   {"split non-manifold vertices", {2, {}}},
                                   {"reoriented faces", {kAny, {}}}},
                                  {1, 0, 1, 0});
    EXPECT_EQ(out.scan.triangles.size(), 2 * n);
    EXPECT_EQ(out.scan.positions.size(), 2 * n + 2);
  }
}

TEST(Clean, TurnsAnInsideOutSphere) {
  Scan scan = shapes::sphere(2);
  for (Triangle& t : scan.triangles) std::swap(t[0], t[2]);
  EXPECT_LT(shapes::volume(scan), 0);
  const CleanScan out = cleaned(scan, {{"turned pieces inside out", {1, {0}}}}, {1, 1, 0, 0});
  EXPECT_NEAR(shapes::volume(out.scan), -shapes::volume(scan), 1e-12);
}

TEST(Clean, TurnsEachPieceByItself) {
  const Scan one = shapes::sphere(1);
  Scan inverted = shapes::moved(one, {5, 0, 0});
  for (Triangle& t : inverted.triangles) std::swap(t[0], t[2]);
  Scan scan = shapes::joined(one, inverted);
  scan = shapes::joined(scan, shapes::moved(one, {10, 0, 0}));
  const CleanScan out = cleaned(scan, {{"turned pieces inside out", {1, {32}}}}, {3, 3, 0, 0});
  EXPECT_NEAR(shapes::volume(out.scan), 3 * shapes::volume(one), 1e-12);
}

Scan turned_over(Scan scan) {
  for (Triangle& t : scan.triangles) std::swap(t[0], t[1]);
  return scan;
}

Scan scaled(Scan scan, double by) {
  for (Vec3& p : scan.positions) p *= by;
  return scan;
}

TEST(Clean, AShellInAShellKeepsItsSideAgainstIt) {
  const Scan ball = shapes::sphere(2), core = scaled(shapes::sphere(1), 0.5),
             seed = scaled(shapes::octahedron(), 0.1);
  const double outer = shapes::volume(ball), inner = shapes::volume(core),
               innermost = shapes::volume(seed);
  const auto all = [](const Scan& a, const Scan& b, const Scan& c) {
    return shapes::joined(a, shapes::joined(b, c));
  };
  const Scan beside = shapes::moved(turned_over(core), {9, 0, 0});
  struct Case {
    Scan scan;
    std::size_t turned;
    double volume;
  };
  const std::vector<Case> cases = {
      // A hollow ball stays as it is, also with a seed in its hollow.
      {shapes::joined(ball, turned_over(core)), 0, outer - inner},
      {all(ball, turned_over(core), seed), 0, outer - inner + innermost},
      {all(turned_over(core), turned_over(seed), ball), 0, outer - inner - innermost},
      // Inside out as a whole, it is turned as a whole.
      {shapes::joined(turned_over(ball), core), 2, outer - inner},
      {all(seed, turned_over(ball), turned_over(core)), 3, outer + inner - innermost},
      {shapes::joined(turned_over(ball), turned_over(core)), 2, outer + inner},
      // What is beside it does not count.
      {all(ball, turned_over(core), beside), 1, outer},
  };
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const auto out = clean(cases[i].scan);
    ASSERT_TRUE(out.has_value());
    expect_manifold(*out);
    std::size_t turned = 0;
    for (const CleanAction& action : out->report.actions) {
      EXPECT_EQ(action.kind, "turned pieces inside out");
      turned += action.count;
    }
    EXPECT_EQ(turned, cases[i].turned) << i;
    EXPECT_NEAR(shapes::volume(out->scan), cases[i].volume, 1e-12) << i;
  }
}

TEST(Clean, SolidsWithAWallInCommonStayClosed) {
  // Two boxes whose vertices lie in the same places on the wall between them.
  const Scan one = shapes::split(shapes::plate(0), 1), two = shapes::moved(one, {0, 0, 1});
  const Scan both = shapes::joined(one, two);
  const CleanScan out = cleaned(both, {}, {2, 2, 0, 0});
  EXPECT_EQ(out.scan.triangles.size(), both.triangles.size());
  EXPECT_NEAR(shapes::volume(out.scan), 2 * shapes::volume(one), 1e-12);
}

TEST(Clean, AnInnerWallDoesNotOpenTheHull) {
  // A sphere with a disk across its equator: every edge of the equator has three faces.
  const Scan ball = shapes::sphere(3);
  Scan scan = ball;
  const auto centre = static_cast<std::uint32_t>(scan.positions.size());
  scan.positions.emplace_back(0, 0, 0);
  std::size_t rim = 0;
  for (const Triangle& t : ball.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      if (std::abs(ball.positions[a][2]) > 1e-9 || std::abs(ball.positions[b][2]) > 1e-9 || a > b)
        continue;
      scan.triangles.push_back({a, b, centre});
      ++rim;
    }
  }
  ASSERT_EQ(rim, 32u);
  const CleanScan out = cleaned(scan,
                                {{"cut edges of three or more faces", {rim, {}}},
                                 {"split non-manifold vertices", {rim, {}}},
                                 {"reoriented faces", {kAny, {}}}},
                                {2, 1, 1, 0});
  EXPECT_NEAR(shapes::volume(out.scan), shapes::volume(ball), 1e-9);
}

TEST(Clean, PairsOnOneEdgeAreToldApartByAMiddleVertex) {
  TestRandom random(5);
  for (int round = 0; round < 200; ++round) {
    // Any closed walk of faces on few vertices has such edges.
    Scan soup;
    for (int v = 0; v < 7; ++v) soup.positions.push_back(random.point());
    for (int f = 0; f < 40; ++f)
      soup.triangles.push_back({random.below(7), random.below(7), random.below(7)});
    const auto out = clean(soup);
    ASSERT_TRUE(out.has_value());
    expect_manifold(*out);
    for (const CleanAction& action : out->report.actions)
      if (action.kind == "split doubled edges") return;
  }
  FAIL() << "no such edge was met";
}

Scan randomly_flipped(Scan scan, double share, std::uint64_t seed, std::set<std::size_t>& ids) {
  TestRandom random(seed);
  for (std::size_t f = 0; f < scan.triangles.size(); ++f) {
    if (random.unit() >= share) continue;
    ids.insert(f);
    std::swap(scan.triangles[f][0], scan.triangles[f][1]);
  }
  return scan;
}

TEST(Clean, OrientsRandomlyFlippedFaces) {
  for (const double share : {0.1, 0.5, 0.9}) {
    for (const bool closed : {true, false}) {
      if (!closed && share > 0.4) continue;  // an open piece keeps what most of its faces say
      const Scan right = closed ? shapes::sphere(3) : shapes::hemisphere(3);
      std::set<std::size_t> flipped;
      const Scan scan = randomly_flipped(right, share, 11, flipped);
      const CleanScan out = cleaned(scan, {{"reoriented faces", {flipped.size(), {}}}},
                                    {1, closed ? 1u : 0u, closed ? 0u : 1u, 0});
      for (const std::size_t id : out.report.actions.at(0).first_ids)
        EXPECT_EQ(flipped.count(id), 1u);
      for (const Triangle& t : out.scan.triangles) {
        const auto& p = out.scan.positions;
        EXPECT_GT(p[t[0]].dot(p[t[1]].cross(p[t[2]])), 0) << "facing inward";
      }
    }
  }
}

TEST(Clean, KeepsNeedleTriangles) {
  Scan scan = shapes::torus(24, 6);
  for (Vec3& p : scan.positions) p[2] *= 1e-7;
  cleaned(scan, {}, {1, 1, 0, 1});
  Scan grid = shapes::grid(30, 3);
  for (Vec3& p : grid.positions) p[0] *= 1e-9;
  cleaned(grid, {}, {1, 0, 1, 0});
}

TEST(Clean, KeepsAHoleOneEdgeWide) {
  // The slit a - m - b opened by giving one side of it a vertex of its own, a little aside.
  Scan scan = shapes::grid(4, 4);
  const auto twin = static_cast<std::uint32_t>(scan.positions.size());
  scan.positions.emplace_back(2, 2 + 1e-6, 0);  // twin of vertex 12, from (1, 2) to (3, 2)
  for (Triangle& t : scan.triangles) {
    double y = 0;
    for (const std::uint32_t v : t) y += scan.positions[v][1] / 3;
    for (std::uint32_t& v : t)
      if (v == 12 && y > 2) v = twin;
  }
  cleaned(scan, {}, {1, 0, 2, 0});
  // Closed by welding when both lips are in the same place.
  scan.positions[twin] = scan.positions[12];
  cleaned(scan, {{"welded vertices", {1, {twin}}}}, {1, 0, 1, 0});
  // One triangle missing in a closed surface.
  cleaned(shapes::only(shapes::sphere(2), [](std::size_t f) { return f != 17; }), {}, {1, 0, 1, 0});
}

TEST(Clean, PinchedTubeLosesItsHandle) {
  // One meridian of the torus shrinks to a point: its edges vanish, and its one vertex is two.
  constexpr std::uint32_t n = 12, m = 7;
  Scan scan = shapes::torus(n, m);
  for (std::uint32_t k = 0; k < m; ++k) scan.positions[3 * m + k] = {0, 1, 0};
  const CleanScan out = cleaned(scan,
                                {{"welded vertices", {m - 1, {22, 23, 24, 25, 26, 27}}},
                                 {"dropped degenerate faces", {2 * m, {}}},
                                 {"split non-manifold vertices", {m, {}}}},
                                {1, 1, 0, 0});
  EXPECT_EQ(out.scan.triangles.size(), 2 * n * m - 2 * m);
  EXPECT_EQ(out.scan.positions.size(), n * m - m + 2);
}

TEST(Clean, TubeThatTouchesItselfKeepsItsHandle) {
  Scan scan = shapes::torus(12, 8);
  scan.positions[0] = scan.positions[4];  // two opposite points of one meridian
  cleaned(scan, {}, {1, 1, 0, 1});
  const CleanScan out =
      cleaned(shared(scan),
              {{"dropped isolated vertices", {1, {4}}}, {"split non-manifold vertices", {1, {0}}}},
              {1, 1, 0, 1});
  EXPECT_EQ(out.scan.positions.size(), 96u);
}

TEST(Clean, PoliciesRefuseAndSayWhy) {
  Scan isolated = shapes::tetrahedron();
  isolated.positions.emplace_back(3, 3, 3);
  const Scan soup = shapes::exploded(shapes::tetrahedron());
  for (const Scan& harmless : {isolated, soup}) {
    EXPECT_TRUE(clean(harmless, RepairPolicy::kStrict).has_value());
    EXPECT_EQ(clean(harmless, RepairPolicy::kNone).error().code, ErrorCode::kGeometryRefused);
  }
  EXPECT_NE(clean(soup, RepairPolicy::kNone).error().message.find("welded vertices"),
            std::string::npos);
  EXPECT_NE(clean(isolated, RepairPolicy::kNone).error().message.find("isolated vertices"),
            std::string::npos);
  EXPECT_EQ(clean(isolated, RepairPolicy::kNone).error().where, 4u);

  Scan degenerate = shapes::tetrahedron(), duplicate = degenerate, inverted = degenerate,
       turned = shapes::sphere(1), fin = shapes::grid(2, 2);
  degenerate.triangles.push_back({0, 0, 1});
  duplicate.triangles.push_back({0, 1, 2});
  for (Triangle& t : inverted.triangles) std::swap(t[0], t[1]);
  std::swap(turned.triangles[3][0], turned.triangles[3][1]);
  fin.positions.emplace_back(1, 0.5, 1);
  fin.triangles.push_back({3, 4, 9});
  const Scan bow = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}},
                    {{0, 1, 2}, {0, 3, 4}}};
  const std::vector<std::pair<Scan, std::string>> refused = {
      {degenerate, "degenerate faces"},
      {duplicate, "duplicate faces"},
      {inverted, "inside out"},
      {turned, "reoriented faces"},
      {fin, "three or more faces"},
      {bow, "non-manifold vertices"},
      {shapes::moebius(8), "one-sided edges"},
  };
  for (const auto& [scan, word] : refused) {
    EXPECT_TRUE(clean(scan).has_value()) << word;
    for (const RepairPolicy policy : {RepairPolicy::kStrict, RepairPolicy::kNone}) {
      const auto out = clean(scan, policy);
      ASSERT_FALSE(out.has_value()) << word;
      EXPECT_EQ(out.error().code, ErrorCode::kGeometryRefused);
      EXPECT_NE(out.error().message.find(word), std::string::npos) << out.error().message;
    }
  }
  EXPECT_EQ(clean(degenerate, RepairPolicy::kStrict).error().where, 4u);
  EXPECT_EQ(clean(turned, RepairPolicy::kNone).error().where, 3u);
}

TEST(Clean, RefusesWhatHasNoSurface) {
  const Scan empty, points = {{{0, 0, 0}, {1, 2, 3}}, {}},
                    edges = {{{0, 0, 0}, {1, 0, 0}}, {{0, 1, 0}, {1, 1, 1}}};
  for (const Scan& scan : {empty, points, edges}) {
    const auto out = clean(scan);
    ASSERT_FALSE(out.has_value());
    EXPECT_EQ(out.error().code, ErrorCode::kGeometryRefused);
  }
  Scan broken = shapes::tetrahedron();
  broken.positions[2][1] = std::nan("");
  const auto out = clean(broken);
  ASSERT_FALSE(out.has_value());
  EXPECT_EQ(out.error().code, ErrorCode::kBadInput);
  EXPECT_EQ(out.error().where, 2u);
}

/// A ball and `count` specks near its surface, `height` above it.
Scan dusty_ball(std::size_t count, double size, double height) {
  Scan scan = shapes::sphere(4);
  TestRandom random(17);
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 at = scan.positions[random.below(1000)];
    scan = shapes::joined(scan, shapes::moved(scaled(shapes::tetrahedron(), size), at * height));
  }
  return scan;
}

TEST(Clean, DropsSpecksThatLieOnTheSurface) {
  const std::size_t faces = shapes::sphere(4).triangles.size();
  const Scan specks = dusty_ball(20, 2e-4, 1);
  const CleanScan out = cleaned(specks,
                                {{"dropped small pieces",
                                  {20,
                                   {faces, faces + 4, faces + 8, faces + 12, faces + 16, faces + 20,
                                    faces + 24, faces + 28}}}},
                                {1, 1, 0, 0});
  EXPECT_EQ(out.scan.triangles.size(), faces);
  EXPECT_EQ(out.scan.positions.size(), shapes::sphere(4).positions.size());
  const CleanAction& action = out.report.actions.at(0);
  EXPECT_NEAR(action.area, 20 * std::sqrt(3.0) / 4 * 8 * 4 * 4e-8, 1e-12);
  EXPECT_NEAR(action.extent, std::sqrt(12.0) * 2e-4, 1e-12);
  // Not asked for, or the policy keeps them: strict does not refuse because of them.
  EXPECT_EQ(clean(specks, RepairPolicy::kSafe, 0)->report.pieces, 21u);
  for (const RepairPolicy policy : {RepairPolicy::kStrict, RepairPolicy::kNone})
    EXPECT_EQ(clean(specks, policy)->report.pieces, 21u);
  EXPECT_EQ(clean(specks, RepairPolicy::kSafe, -1).error().code, ErrorCode::kBadInput);
  EXPECT_EQ(clean(specks, RepairPolicy::kSafe, std::nan("")).error().code, ErrorCode::kBadInput);
}

TEST(Clean, KeepsPiecesWhoseLossWouldShow) {
  cleaned(dusty_ball(5, 2e-4, 1.01), {}, {6, 6, 0, 0});  // off the surface
  cleaned(dusty_ball(5, 0.02, 1), {}, {6, 6, 0, 0});     // too large
  Scan alike;                                            // all small, none larger than another
  for (int i = 0; i < 50; ++i)
    alike = shapes::joined(
        alike, shapes::moved(scaled(shapes::tetrahedron(), 0.01), {0.1 * i, 0.03 * i * i, 0}));
  cleaned(alike, {}, {50, 50, 0, 0});
  // Shreds that are a quarter of the surface: a plate, and triangles of another one above it.
  Scan shreds = shapes::moved(shapes::grid(100, 100), {0.3, 0.3, 1e-3});
  shreds = shapes::exploded(shapes::only(shreds, [](std::size_t f) { return f % 3 == 0; }));
  const Scan plate = shapes::grid(200, 100);
  const auto out = clean(shapes::joined(plate, shreds), RepairPolicy::kSafe, 0.01);
  EXPECT_GT(out->report.pieces, 1000u);
  const Scan few = shapes::only(shreds, [](std::size_t f) { return f < 60; });
  cleaned(shapes::joined(plate, few), {{"dropped small pieces", {60, {}}}}, {1, 0, 1, 0});
}

/// A second cleaning finds nothing to do.
void expect_idempotent(const Scan& scan) {
  const auto first = clean(scan);
  ASSERT_TRUE(first.has_value());
  const auto second = clean(first->scan, RepairPolicy::kNone);
  ASSERT_TRUE(second.has_value()) << second.error().message;
  EXPECT_TRUE(second->report.actions.empty());
  EXPECT_EQ(second->scan.triangles, first->scan.triangles);
  EXPECT_EQ(second->scan.positions, first->scan.positions);
  EXPECT_EQ(second->piece, first->piece);
  EXPECT_EQ(second->report.boundary_loops, first->report.boundary_loops);
  EXPECT_EQ(second->report.genus, first->report.genus);
}

/// Random triangles over few vertices, some of which lie in the same place.
Scan random_soup(TestRandom& random, std::size_t most_vertices, std::size_t most_faces) {
  Scan scan;
  const std::size_t vertices = 3 + random.below(most_vertices - 2);
  const std::size_t faces = 1 + random.below(most_faces);
  const bool flat = random.below(8) == 0, welded = random.below(3) == 0;
  for (std::size_t v = 0; v < vertices; ++v) {
    Vec3 p = random.point();
    if (flat) p[2] = 0;
    if (welded && v > 0 && random.below(3) == 0) p = scan.positions[random.below(v)];
    scan.positions.push_back(p);
  }
  for (std::size_t f = 0; f < faces; ++f)
    scan.triangles.push_back(
        {random.below(vertices), random.below(vertices), random.below(vertices)});
  return scan;
}

TEST(Clean, MakesAManifoldOfAnySoup) {
  TestRandom random(2024);
  std::size_t kept = 0;
  for (int i = 0; i < 3000 && !HasFailure(); ++i) {
    const std::size_t most_vertices = i % 3 == 0 ? 6 : (i % 3 == 1 ? 20 : 80);
    const Scan scan = random_soup(random, most_vertices, i % 2 == 0 ? 12 : 300);
    const auto out = clean(scan);
    if (!out) {
      EXPECT_EQ(out.error().code, ErrorCode::kGeometryRefused);
      continue;
    }
    ++kept;
    expect_manifold(*out);
    expect_idempotent(scan);
    if (HasFailure()) ADD_FAILURE() << "soup number " << i;
  }
  EXPECT_GT(kept, 2500u);
}

TEST(Clean, FinsDoNotOpenAClosedSurface) {
  TestRandom random(7);
  int closed = 0;
  for (int i = 0; i < 100; ++i) {
    Scan scan = shapes::torus(10, 8);
    const std::size_t faces = scan.triangles.size();
    for (int k = 0; k < 5; ++k) {
      const Triangle t = scan.triangles[random.below(faces)];
      scan.positions.push_back(2 * random.point());
      scan.triangles.push_back({t[0], t[1], static_cast<std::uint32_t>(scan.positions.size() - 1)});
    }
    const auto out = clean(scan);
    ASSERT_TRUE(out.has_value());
    expect_manifold(*out);
    EXPECT_GE(out->report.triangles, faces - 5);
    closed += out->report.closed_pieces == 1 && out->report.genus == 1;
  }
  EXPECT_EQ(closed, 100);
}

TEST(Clean, IsIdempotent) {
  std::set<std::size_t> ids;
  Scan inverted = shapes::sphere(1);
  for (Triangle& t : inverted.triangles) std::swap(t[0], t[1]);
  Scan fin = shapes::grid(2, 2);
  fin.positions.emplace_back(1, 0.5, 1);
  fin.triangles.push_back({3, 4, 9});
  const Scan sphere = shapes::sphere(2);
  for (const Scan& scan :
       {shapes::exploded(shapes::torus(8, 6)), randomly_flipped(sphere, 0.5, 3, ids), inverted,
        shapes::joined(sphere, sphere), shapes::joined(sphere, shapes::moved(sphere, {2, 0, 0})),
        fin, shapes::moebius(9), dusty_ball(20, 2e-4, 1), dusty_ball(20, 2e-3, 1)})
    expect_idempotent(scan);
}

}  // namespace
}  // namespace nacre::remesh
