// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <set>

#include "remesh/remesh.h"
#include "support/manifold.h"
#include "support/random.h"
#include "support/shapes.h"

namespace nacre::remesh {
namespace {

constexpr RepairPolicy kAggressive = RepairPolicy::kAggressive;

const CleanAction* find(const CleanReport& report, const std::string& kind) {
  for (const CleanAction& action : report.actions)
    if (action.kind == kind) return &action;
  return nullptr;
}

std::size_t count_of(const CleanReport& report, const std::string& kind) {
  const CleanAction* action = find(report, kind);
  return action == nullptr ? 0 : action->count;
}

CleanScan repaired(const Scan& scan, RepairPolicy policy = kAggressive) {
  const auto out = clean(scan, policy);
  EXPECT_TRUE(out.has_value());
  if (!out) return {};
  const ManifoldFacts facts = manifold_facts(out->scan.triangles, out->scan.positions.size());
  EXPECT_EQ(facts.defect, "");
  EXPECT_EQ(out->report.pieces, facts.pieces);
  EXPECT_EQ(out->report.closed_pieces, facts.closed_pieces);
  EXPECT_EQ(out->report.boundary_loops, facts.boundary_loops);
  EXPECT_EQ(out->report.genus, facts.genus);
  EXPECT_EQ(out->piece.size(), out->scan.triangles.size());
  return *out;
}

/// Without the triangles of which `vertices` are corners.
Scan without_stars(const Scan& scan, const std::set<std::uint32_t>& vertices) {
  return shapes::only(scan, [&](std::size_t f) {
    for (const std::uint32_t v : scan.triangles[f])
      if (vertices.count(v) > 0) return false;
    return true;
  });
}

TEST(AggressiveRepair, FillsPinHoles) {
  const Scan ball = shapes::sphere(4);
  const Scan one = shapes::only(ball, [](std::size_t f) { return f != 17; });
  const Scan stars = without_stars(ball, {100, 500});
  struct Case {
    Scan scan;
    std::size_t holes;
  };
  for (const auto& [scan, holes] : {Case{one, 1}, Case{stars, 2}}) {
    EXPECT_EQ(repaired(scan, RepairPolicy::kSafe).report.boundary_loops, holes);
    const CleanScan out = repaired(scan);
    EXPECT_EQ(count_of(out.report, "filled pin holes"), holes);
    EXPECT_EQ(out.report.actions.size(), 1u);
    EXPECT_EQ(out.report.boundary_loops, 0u);
    EXPECT_NEAR(shapes::volume(out.scan), shapes::volume(ball), 0.002 * shapes::volume(ball));
    EXPECT_GT(find(out.report, "filled pin holes")->extent, 0);
    EXPECT_LT(find(out.report, "filled pin holes")->extent, 0.3);
    for (const std::size_t id : find(out.report, "filled pin holes")->first_ids)
      EXPECT_LT(id, scan.triangles.size());
    EXPECT_TRUE(repaired(out.scan).report.actions.empty());
  }
}

TEST(AggressiveRepair, FillsRaggedHolesWithoutCrowdedEdges) {
  TestRandom random(3);
  std::size_t filled = 0;
  for (int round = 0; round < 100; ++round) {
    // Few triangles in all, so that vertices around a hole are also neighbours elsewhere.
    const Scan whole = round % 2 == 0 ? shapes::torus(12, 9) : shapes::sphere(2);
    std::set<std::size_t> gone;
    for (int i = 0; i < 6; ++i) gone.insert(random.below(whole.triangles.size()));
    const Scan scan = shapes::only(whole, [&](std::size_t f) { return gone.count(f) == 0; });
    const CleanScan out = repaired(scan);
    filled += count_of(out.report, "filled pin holes");
    EXPECT_TRUE(repaired(out.scan).report.actions.empty()) << round;
  }
  EXPECT_GT(filled, 100u);
}

TEST(AggressiveRepair, LeavesOutlinesAndLargeHoles) {
  const Scan triangle = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  for (const Scan& scan :
       {triangle, shapes::grid(1, 1), shapes::grid(9, 9), shapes::hemisphere(3),
        shapes::holed_grid(20, 5, 15), shapes::moebius(40), shapes::torus(20, 12)}) {
    const CleanScan safe = repaired(scan, RepairPolicy::kSafe), out = repaired(scan);
    EXPECT_EQ(out.scan.triangles, safe.scan.triangles);
    EXPECT_EQ(out.report.actions.size(), safe.report.actions.size());
  }
}

TEST(AggressiveRepair, DropsSpecksWhereverTheyLie) {
  Scan scan = shapes::sphere(4), speck = shapes::tetrahedron();
  for (Vec3& p : speck.positions) p = p * 1e-3 + Vec3(3, 0, 0);
  scan = shapes::joined(scan, speck);
  EXPECT_EQ(repaired(scan, RepairPolicy::kSafe).report.pieces, 2u);
  const CleanScan out = repaired(scan);
  EXPECT_EQ(out.report.pieces, 1u);
  EXPECT_EQ(count_of(out.report, "dropped small pieces"), 1u);
}

/// Takes out triangles a and b and joins their rims by a tube.
void add_handle(Scan& scan, std::size_t a, std::size_t b) {
  const Triangle s = scan.triangles[a], t = scan.triangles[b];
  const auto p = [&](std::uint32_t v) { return scan.positions[v]; };
  // Corners of t in the other direction, starting where the tube is twisted least.
  std::size_t turn = 0;
  double least = 1e300;
  for (std::size_t k = 0; k < 3; ++k) {
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) sum += (p(s[i]) - p(t[(k + 3 - i) % 3])).norm();
    if (sum < least) least = sum, turn = k;
  }
  std::array<std::uint32_t, 3> r{};
  for (std::size_t i = 0; i < 3; ++i) r[i] = t[(turn + 3 - i) % 3];
  scan.triangles[a] = {s[0], s[1], r[1]};
  scan.triangles[b] = {s[0], r[1], r[0]};
  for (const std::size_t i : {1u, 2u}) {
    const std::size_t next = (i + 1) % 3;
    scan.triangles.push_back({s[i], s[next], r[next]});
    scan.triangles.push_back({s[i], r[next], r[i]});
  }
}

/// Drawn together towards a point: ten times finer there.
Scan drawn_to(Scan scan, const Vec3& centre, double radius) {
  for (Vec3& p : scan.positions) {
    const double share = (p - centre).norm() / radius;
    if (share < 1) p = centre + (p - centre) * (0.1 + 0.9 * share);
  }
  return scan;
}

/// Handles between pairs of triangles that are close, with no edge between their corners.
Scan with_handles(Scan scan, const Vec3& near_to, std::size_t count, std::uint64_t seed) {
  TestRandom random(seed);
  std::set<std::uint32_t> used;
  const std::size_t faces = scan.triangles.size();
  const auto middle = [&](std::size_t f) {
    const Triangle& t = scan.triangles[f];
    return Vec3((scan.positions[t[0]] + scan.positions[t[1]] + scan.positions[t[2]]) / 3);
  };
  const auto free = [&](std::size_t f) {
    for (const std::uint32_t v : scan.triangles[f])
      if (used.count(v) > 0) return false;
    return true;
  };
  for (std::size_t made = 0, tried = 0; made < count && tried < 1'000'000; ++tried) {
    const std::size_t a = random.below(faces);
    if (!free(a) || (middle(a) - near_to).norm() > 0.05) continue;
    std::set<std::uint32_t> ring(scan.triangles[a].begin(), scan.triangles[a].end());
    const auto touches = [&](std::size_t f) {
      const Triangle& t = scan.triangles[f];
      return std::any_of(t.begin(), t.end(), [&](std::uint32_t v) { return ring.count(v) > 0; });
    };
    std::set<std::uint32_t> wider = ring;
    for (std::size_t f = 0; f < scan.triangles.size(); ++f)
      if (touches(f)) wider.insert(scan.triangles[f].begin(), scan.triangles[f].end());
    ring = wider;
    std::vector<std::pair<double, std::size_t>> near;
    for (std::size_t b = 0; b < faces; ++b)
      if (free(b) && !touches(b)) near.emplace_back((middle(a) - middle(b)).norm(), b);
    const std::size_t b = std::min_element(near.begin(), near.end())->second;
    for (const std::size_t f : {a, b})
      used.insert(scan.triangles[f].begin(), scan.triangles[f].end());
    add_handle(scan, a, b);
    ++made;
  }
  return scan;
}

TEST(AggressiveRepair, CutsTinyHandlesAndNoOthers) {
  struct Body {
    Scan scan;
    Vec3 fine_at;
  };
  for (const auto& [plain, fine_at] :
       {Body{shapes::sphere(6), {0, 0, 1}}, Body{shapes::torus(200, 120), {1.4, 0, 0}},
        Body{shapes::hemisphere(6), {0, 0, 1}}}) {
    const Scan body = drawn_to(plain, fine_at, 0.6);
    const CleanReport before = clean(body)->report;
    for (const std::size_t count : {1u, 2u, 7u}) {
      const Scan scan = with_handles(body, fine_at, count, 5 + count);
      EXPECT_EQ(repaired(scan, RepairPolicy::kSafe).report.genus,
                before.genus + static_cast<int>(count));
      const CleanScan out = repaired(scan);
      EXPECT_EQ(count_of(out.report, "cut tiny handles"), count);
      EXPECT_EQ(out.report.actions.size(), 1u);
      EXPECT_EQ(out.report.genus, before.genus);
      EXPECT_EQ(out.report.pieces, 1u);
      EXPECT_EQ(out.report.boundary_loops, before.boundary_loops);
      EXPECT_NEAR(shapes::volume(out.scan), shapes::volume(body), 0.001 * shapes::volume(body));
      EXPECT_TRUE(repaired(out.scan).report.actions.empty());
    }
  }
}

}  // namespace
}  // namespace nacre::remesh
