// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <map>

#include "remesh_checks.h"
#include "support/broken_shapes.h"

namespace nacre::remesh {
namespace {

using testing::expect_healthy;
using testing::final_error;
using testing::options_of;

/// A broken scan, what cleaning says that it did to it, and what is to come out.
struct Broken {
  const char* name;
  Scan scan;
  std::vector<std::string> actions;
  std::size_t pieces, closed, loops;
  int genus;
};

std::vector<Broken> broken_scans() {
  const Scan body = shapes::bumpy_sphere(4);
  return {
      {"BowTie", shapes::bow_tie(4), {"split non-manifold vertices"}, 2, 0, 2, 0},
      {"ThreeFaceEdges",
       shapes::brimmed_ball(4),
       {"cut edges of three or more faces", "split non-manifold vertices", "reoriented faces"},
       2,
       1,
       1,
       0},
      {"Moebius",
       shapes::wide_moebius(80, 8),
       {"cut one-sided edges", "split non-manifold vertices", "reoriented faces"},
       1,
       0,
       1,
       0},
      {"InsideOut", shapes::inside_out(body), {"turned pieces inside out"}, 1, 1, 0, 0},
      {"DuplicatedShell",
       shapes::joined(body, body),
       {"welded vertices", "dropped duplicate faces"},
       1,
       1,
       0,
       0},
      {"Needles", shapes::with_needles(body, 3, 1e-6), {}, 1, 1, 0, 0},
      {"HoleOneEdgeWide", shapes::slit_ball(4, 1e-3), {}, 1, 0, 1, 0},
      {"CommonVertex",
       shapes::balls_with_a_common_vertex(4),
       {"split non-manifold vertices"},
       2,
       2,
       0,
       0},
      {"CommonEdge",
       shapes::balls_with_a_common_edge(4),
       {"cut edges of three or more faces", "split non-manifold vertices"},
       2,
       2,
       0,
       0},
      {"PinchedTube",
       shapes::pinched_torus(40, 16, 0),
       {"welded vertices", "dropped degenerate faces", "split non-manifold vertices"},
       1,
       1,
       0,
       0},
      {"Soup", shapes::exploded(body), {"welded vertices"}, 1, 1, 0, 0},
  };
}

class BrokenInput : public ::testing::TestWithParam<Broken> {};

TEST_P(BrokenInput, IsCleanedAsDocumented) {
  const Broken& broken = GetParam();
  EXPECT_GE(broken.scan.triangles.size(), 500u);
  const auto out = clean(broken.scan);
  ASSERT_TRUE(out.has_value()) << out.error().message;
  const ManifoldFacts facts = manifold_facts(out->scan.triangles, out->scan.positions.size());
  EXPECT_EQ(facts.defect, "");
  EXPECT_EQ(facts.pieces, broken.pieces);
  EXPECT_EQ(facts.closed_pieces, broken.closed);
  EXPECT_EQ(facts.boundary_loops, broken.loops);
  EXPECT_EQ(facts.genus, broken.genus);
  std::vector<std::string> actions;
  for (const CleanAction& action : out->report.actions) actions.push_back(action.kind);
  EXPECT_EQ(actions, broken.actions);
}

TEST_P(BrokenInput, ComesOutHealthy) {
  const Broken& broken = GetParam();
  const auto out = remesh(broken.scan, options_of(36, 2));
  ASSERT_TRUE(out.has_value()) << out.error().message;  // none of these needs to be refused
  expect_healthy(*out);
  EXPECT_EQ(out->clean.pieces, broken.pieces);
  EXPECT_EQ(out->clean.closed_pieces, broken.closed);
  EXPECT_EQ(out->clean.boundary_loops, broken.loops);
  EXPECT_EQ(out->clean.genus, broken.genus);
  EXPECT_LT(final_error(broken.scan, *out), 0.01);
  std::size_t folds = 0;
  for (const BandReport& band : out->bands) folds += band.folded_triangles;
  EXPECT_LE(folds, 1u);
}

/// A tube that is narrow but not closed keeps its handle, unless that is tiny and cutting is asked.
TEST(BrokenInputs, ANarrowTubeIsCutOnlyWhenAsked) {
  for (const double radius : {0.1, 0.008}) {
    const Scan scan = shapes::pinched_torus(60, 24, radius);
    EXPECT_EQ(clean(scan, RepairPolicy::kNone)->report.genus, 1);
    const auto out = clean(scan, RepairPolicy::kAggressive);
    ASSERT_TRUE(out.has_value());
    EXPECT_EQ(out->report.genus, radius < 0.01 ? 0 : 1);
    EXPECT_EQ(out->report.closed_pieces, 1u);
    EXPECT_EQ(out->report.pieces, 1u);
  }
}

/// What the shells of one body come to must be that body.
TEST(BrokenInputs, NothingOfTheSurfaceIsLost) {
  const Scan body = shapes::bumpy_sphere(4);
  const auto plain = clean(body);
  const std::vector<Scan> shells = {
      shapes::inside_out(body), shapes::joined(body, body), shapes::exploded(body),
      shapes::joined(shapes::inside_out(body), shapes::exploded(body))};
  for (const Scan& scan : shells) {
    const auto out = clean(scan);
    ASSERT_TRUE(out.has_value());
    EXPECT_EQ(out->report.triangles, body.triangles.size());
    EXPECT_EQ(out->report.vertices, body.positions.size());
    EXPECT_NEAR(testing::rms_error(out->scan, plain->scan), 0, 1e-12);
  }
}

INSTANTIATE_TEST_SUITE_P(Each, BrokenInput, ::testing::ValuesIn(broken_scans()),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace nacre::remesh
