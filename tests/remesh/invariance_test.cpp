// SPDX-License-Identifier: GPL-3.0-or-later
//
// The same surface in another guise comes out as good as before: on two shapes here, on real scans
// in bench/remesh_invariance.
#include <gtest/gtest.h>

#include "remesh_checks.h"
#include "support/transforms.h"

namespace nacre::remesh {
namespace {

constexpr double kMostLossDb = 2;

struct Outcome {
  ManifoldFacts facts;
  double psnr_db = 0;
};

Outcome outcome_of(const Scan& scan) {
  const auto out = remesh(scan, testing::options_of(60, 4));
  EXPECT_TRUE(out.has_value()) << out.error().message;
  if (!out) return {};
  testing::expect_healthy(*out);
  Outcome outcome;
  outcome.facts = manifold_facts(out->mesh.base_triangles, out->mesh.base_vertex_count);
  outcome.psnr_db = metric::psnr_db(metric::Surface::build(scan)->bbox_diagonal(),
                                    testing::final_error(scan, *out));
  return outcome;
}

/// Closed of genus 1 with dents; and open, a bumpy sheet with a hole.
Scan dented_torus() {
  Scan scan = shapes::torus(60, 30);
  for (Vec3& p : scan.positions) p *= 1 + 0.06 * std::sin(4 * p[0] + 1) * std::cos(5 * p[1]);
  return scan;
}

Scan bumpy_sheet() {
  Scan scan = shapes::holed_grid(36, 12, 20);
  for (Vec3& p : scan.positions) p[2] = 2 * std::sin(0.25 * p[0]) * std::cos(0.2 * p[1] + 0.5);
  return scan;
}

using Guises = std::vector<std::string>;

/// Each entry is one scan, in all the guises that it names, one over the other.
void expect_as_good(const Scan& scan, const Outcome& plain, const std::vector<Guises>& cases) {
  for (const Guises& guises : cases) {
    Scan changed = scan;
    std::string name;
    for (const std::string& guise : guises) {
      changed = transforms::named(changed, guise, 7);
      name += guise + " ";
    }
    SCOPED_TRACE(name);
    const Outcome outcome = outcome_of(changed);
    EXPECT_GE(outcome.psnr_db, plain.psnr_db - kMostLossDb) << "it was " << plain.psnr_db;
    EXPECT_EQ(outcome.facts.genus, plain.facts.genus);
    EXPECT_EQ(outcome.facts.boundary_loops, plain.facts.boundary_loops);
    EXPECT_EQ(outcome.facts.pieces, plain.facts.pieces);
  }
}

TEST(Invariance, ClosedScanInOtherGuises) {
  const Outcome plain = outcome_of(dented_torus());
  EXPECT_EQ(plain.facts.genus, 1);
  EXPECT_GT(plain.psnr_db, 60);
  expect_as_good(dented_torus(), plain,
                 {{"rotated", "scaled"}, {"renumbered", "half flipped"}, {"noise"}});
}

TEST(Invariance, OpenScanInOtherGuises) {
  const Outcome plain = outcome_of(bumpy_sheet());
  EXPECT_EQ(plain.facts.boundary_loops, 2u);
  EXPECT_GT(plain.psnr_db, 60);
  expect_as_good(bumpy_sheet(), plain, {{"rotated", "moved"}, {"renumbered", "half flipped"}});
}

}  // namespace
}  // namespace nacre::remesh
