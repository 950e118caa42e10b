// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/remesh.h"

#include <gtest/gtest.h>

#include <atomic>

#include "remesh_checks.h"
#include "support/random.h"
#include "support/transforms.h"
#include "wavelet/wavelet.h"

namespace nacre::remesh {
namespace {

using testing::expect_healthy;
using testing::final_error;
using testing::options_of;

/// Closed of genus 0 and 1, and open. One remesh takes seconds, so the tests share scans.
Scan three_pieces() {
  return shapes::joined(shapes::bumpy_sphere(4),
                        shapes::joined(shapes::moved(shapes::torus(40, 20), {4, 0, 0}),
                                       shapes::moved(shapes::hemisphere(4), {0, 4, 0})));
}
constexpr int kBase = 120, kLevels = 3;

/// three_pieces() remeshed with two threads.
const Remesh& plain_remesh() {
  static const Remesh out =
      testing::with_threads(2, [] { return *remesh(three_pieces(), options_of(kBase, kLevels)); });
  return out;
}

TEST(Remesh, ClosedOpenAndSeveralPieces) {
  const Scan scan = three_pieces();
  const Remesh& out = plain_remesh();
  expect_healthy(out);
  EXPECT_EQ(out.mesh.level_count, kLevels);
  EXPECT_TRUE(out.clean.actions.empty());
  EXPECT_EQ(out.clean.pieces, 3u);
  EXPECT_EQ(out.clean.genus, 1);
  EXPECT_EQ(out.clean.boundary_loops, 1u);
  EXPECT_LT(final_error(scan, out), 0.005);
  std::size_t folds = 0, normal = 0, all = 0;
  for (const BandReport& band : out.bands) {
    folds += band.folded_triangles;
    normal += band.normal_only;
    all += band.vertices;
  }
  EXPECT_EQ(folds, 0u);
  EXPECT_GE(normal, all * 95 / 100);  // the rest is on the boundary
  EXPECT_FALSE(out.costs.empty());
}

TEST(Remesh, WhatCannotBeSimplifiedByHalfIsItsOwnBase) {
  Scan scan = shapes::octahedron();
  for (int i = 1; i < 12; ++i)
    scan = shapes::joined(
        scan, shapes::moved(i % 2 ? shapes::tetrahedron() : shapes::octahedron(), {3.0 * i, 0, 0}));
  const auto out = remesh(scan, options_of(0, 0));
  ASSERT_TRUE(out.has_value());
  EXPECT_EQ(out->mesh.base_triangles.size(), scan.triangles.size());
  EXPECT_EQ(out->mesh.level_count, 1);
  EXPECT_LT(final_error(scan, *out), 1e-12);
  ASSERT_EQ(out->pieces.size(), 12u);
  for (const PieceReport& piece : out->pieces) {
    EXPECT_NE(piece.fallback, "");
    EXPECT_EQ(piece.base_triangles, piece.triangles);
  }
  // Asked for fewer, it gets what is possible by simplification.
  const auto fewer = remesh(scan, options_of(50, 2));
  ASSERT_TRUE(fewer.has_value());
  for (const PieceReport& piece : fewer->pieces) EXPECT_EQ(piece.fallback, "");
}

TEST(Remesh, RefusesByKind) {
  const Scan sphere = shapes::sphere(2);
  for (const int levels : {-1, 13, 1000}) {
    const auto out = remesh(sphere, options_of(20, levels));
    ASSERT_FALSE(out.has_value()) << levels;
    EXPECT_EQ(out.error().code, ErrorCode::kBadInput);
  }
  EXPECT_EQ(remesh(sphere, options_of(-3, 2)).error().code, ErrorCode::kBadInput);
  EXPECT_EQ(remesh(sphere, {}).error().code, ErrorCode::kBadInput);  // no prediction
  Scan broken = sphere;
  broken.positions[7][0] = std::nan("");
  EXPECT_EQ(remesh(broken, options_of(20, 2)).error().code, ErrorCode::kBadInput);
  EXPECT_EQ(remesh({}, options_of(20, 2)).error().code, ErrorCode::kGeometryRefused);
  Options strict = options_of(20, 2);
  strict.repair = RepairPolicy::kStrict;
  EXPECT_EQ(remesh(shapes::moebius(9), strict).error().code, ErrorCode::kGeometryRefused);
}

TEST(Remesh, RefusesSurfacesWithoutArea) {
  Scan line = shapes::grid(4, 4), point = shapes::sphere(1);
  for (Vec3& p : line.positions) p[1] = 0;
  for (Vec3& p : point.positions) p = p * 1e-200;
  const Scan thin = {{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}};
  for (const Scan& scan : {line, point, thin}) {
    const auto out = remesh(scan, options_of(10, 2));
    ASSERT_FALSE(out.has_value());
    EXPECT_EQ(out.error().code, ErrorCode::kGeometryRefused);
  }
}

TEST(Remesh, IsTheSameBytesAtAnyThreadCount) {
  const auto one =
      testing::with_threads(1, [] { return remesh(three_pieces(), options_of(kBase, kLevels)); });
  ASSERT_TRUE(one.has_value());
  EXPECT_EQ(one->mesh.base_triangles, plain_remesh().mesh.base_triangles);
  EXPECT_EQ(one->mesh.positions, plain_remesh().mesh.positions);
}

TEST(Remesh, CanBeCancelledAtAnyTime) {
  const Scan scan = shapes::bumpy_sphere(5);
  for (const int after : {0, 1, 7}) {
    std::atomic<bool> stop{after == 0};
    std::atomic<int> told{0};
    RunContext context;
    context.cancel = &stop;
    context.progress = [&](std::string_view, double share) {
      EXPECT_GE(share, 0);
      EXPECT_LE(share, 1 + 1e-9);
      if (++told >= after) stop = true;
    };
    const auto out = remesh(scan, options_of(60, 4), context);
    ASSERT_FALSE(out.has_value()) << after;
    EXPECT_EQ(out.error().code, ErrorCode::kCancelled);
  }
}

TEST(Remesh, ChangesOnlyByNoiseUnderMotionsScaleAndNumbering) {
  const Scan scan = three_pieces();
  const double error = final_error(scan, plain_remesh());
  Scan other = transforms::renumbered(transforms::rotated(scan, 3), 77);
  TestRandom random(1);
  for (Triangle& t : other.triangles)
    if (random.below(2) == 0) std::swap(t[0], t[1]);
  for (Vec3& p : other.positions) p = 1000 * p + Vec3(1e6, -1e6, 1e6);
  const auto out = remesh(other, options_of(kBase, kLevels));
  ASSERT_TRUE(out.has_value());
  expect_healthy(*out);
  EXPECT_EQ(out->clean.pieces, 3u);
  EXPECT_EQ(out->clean.genus, 1);
  EXPECT_EQ(out->clean.boundary_loops, 1u);
  const double ratio = final_error(other, *out) / 1000 / error;
  EXPECT_LT(std::abs(20 * std::log10(ratio)), 3) << "ratio " << ratio;
}

/// Each broken in its own way, side by side.
Scan broken_pieces() {
  const Scan sphere = shapes::sphere(3);
  Scan fin = sphere, inverted = sphere;
  const Triangle t = fin.triangles[9];
  fin.positions.push_back(1.5 * fin.positions[t[0]]);
  fin.triangles.push_back({t[0], t[1], static_cast<std::uint32_t>(fin.positions.size() - 1)});
  for (Triangle& f : inverted.triangles) std::swap(f[0], f[1]);
  Scan needles = shapes::torus(24, 6), pinched = shapes::torus(24, 12);
  for (Vec3& p : needles.positions) p[2] *= 1e-4;
  const double r = std::sqrt(0.5);
  for (std::uint32_t k = 0; k < 12; ++k) pinched.positions[3 * 12 + k] = {r, r, 0};
  const Scan triangle = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  const std::vector<Scan> all = {
      shapes::joined(sphere, shapes::moved(sphere, {2, 0, 0})),  // bow tie
      fin,                                                       // three-face edge
      shapes::moebius(30),
      inverted,
      shapes::joined(sphere, sphere),  // duplicated shell
      needles,
      shapes::only(sphere, [](std::size_t f) { return f != 17; }),  // small hole
      pinched,
      shapes::exploded(sphere),  // soup
      triangle,
      shapes::tetrahedron(),
      shapes::torus(3, 3)};
  Scan scan;
  for (std::size_t i = 0; i < all.size(); ++i)
    scan = shapes::joined(scan, shapes::moved(all[i], {5.0 * static_cast<double>(i % 4),
                                                       5.0 * static_cast<double>(i / 4), 0}));
  return scan;
}

TEST(Remesh, BrokenPiecesSideBySideComeOutHealthy) {
  const Scan scan = broken_pieces();
  const auto out = remesh(scan, options_of(200, 2));
  ASSERT_TRUE(out.has_value()) << out.error().message;
  expect_healthy(*out);
  EXPECT_EQ(out->clean.pieces, 14u);  // one more each for the bow tie and the fin
  EXPECT_EQ(out->clean.closed_pieces, 10u);
  EXPECT_EQ(out->clean.genus, 2);  // needles and smallest torus; the pinched one has none left
  EXPECT_LT(final_error(scan, *out), 0.05);
}

}  // namespace
}  // namespace nacre::remesh
