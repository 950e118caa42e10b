// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/fit_surface.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "map_checks.h"
#include "remesh/collapse_edges.h"

namespace nacre::remesh {
namespace {

using namespace shapes;
using testing::facts_of;

double psnr(const Scan& scan, const Scan& mesh) {
  const auto distance = metric::compare(scan, mesh, {.samples = 40'000});
  EXPECT_TRUE(distance.has_value());
  return distance->psnr_db;
}

Scan collapsed(const Scan& scan, int vertices) {
  auto cleaned = clean(scan, RepairPolicy::kSafe, 0);
  EXPECT_TRUE(cleaned.has_value());
  auto fewer = collapse_edges(std::move(*cleaned), vertices, {});
  EXPECT_TRUE(fewer.has_value());
  return std::move(fewer->scan);
}

TEST(FitSurface, NearerThanTheCollapseLeftItAndOfTheSameTriangles) {
  for (const auto& [scan, gain_db] :
       {std::pair{bumpy_sphere(5), 0.5}, std::pair{hemisphere(5), 0.2}}) {
    const Scan before = collapsed(scan, 200);
    Scan after = before;
    fit_surface(scan, after);
    EXPECT_EQ(after.triangles, before.triangles);
    EXPECT_GT(psnr(scan, after), psnr(scan, before) + gain_db);
  }
}

TEST(FitSurface, VerticesPushedOffASphereComeBack) {
  const Scan ball = sphere(4), even = sphere(2);
  Scan mesh = even;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    mesh.positions[v] *= v % 2 == 0 ? 1.03 : 0.98;
  fit_surface(ball, mesh);
  // As near as the even mesh at its best size, which lies half inside and half outside.
  double best = 0;
  for (int i = 0; i <= 40; ++i) {
    Scan scaled = even;
    for (Vec3& p : scaled.positions) p *= 1 + 0.001 * i;
    best = std::max(best, psnr(ball, scaled));
  }
  EXPECT_GT(best, psnr(ball, even) + 3);
  EXPECT_GT(psnr(ball, mesh), best - 0.05);
  for (const Vec3& p : mesh.positions) EXPECT_GT(p.norm(), 1);
}

TEST(FitSurface, WhatIsExactStays) {
  const Scan scan = grid(9, 9);
  Scan mesh = scan;
  fit_surface(scan, mesh);
  ASSERT_EQ(mesh.positions.size(), scan.positions.size());
  for (std::size_t v = 0; v < scan.positions.size(); ++v)
    EXPECT_LT((mesh.positions[v] - scan.positions[v]).norm(), 1e-9);
}

TEST(FitSurface, KeepsEveryKindOfScanWhole) {
  for (const auto& [name, scan] : testing::scans_of_all_kinds()) {
    SCOPED_TRACE(name);
    const Scan before = collapsed(scan, 40);
    Scan after = before;
    fit_surface(scan, after);
    EXPECT_EQ(after.triangles, before.triangles);
    EXPECT_EQ(facts_of(after).defect, "");
    for (const Vec3& p : after.positions) ASSERT_TRUE(p.allFinite());
    EXPECT_GE(psnr(scan, after), psnr(scan, before) - 0.1);
  }
}

TEST(FitSurface, TheSameAtAnyThreadCount) {
  const Scan scan = bumpy_sphere(4);
  const Scan before = collapsed(scan, 100);
  Scan one = before, many = before;
  tbb::task_arena(1).execute([&] { fit_surface(scan, one); });
  tbb::task_arena(4).execute([&] { fit_surface(scan, many); });
  EXPECT_EQ(one.positions, many.positions);
}

TEST(FitSurface, NothingToFit) {
  Scan empty, mesh = sphere(1);
  const auto positions = mesh.positions;
  fit_surface(empty, mesh);
  EXPECT_EQ(mesh.positions, positions);
  fit_surface(sphere(2), empty);
  EXPECT_TRUE(empty.triangles.empty());
  // Triangles without area pull nowhere.
  Scan flat;
  flat.positions = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0)};
  flat.triangles = {{0, 1, 2}};
  const Scan was = flat;
  fit_surface(sphere(2), flat);
  EXPECT_EQ(flat.positions, was.positions);
  fit_surface(was, mesh);
  EXPECT_EQ(mesh.positions, positions);
}

TEST(FitSurface, StopsWhenCancelled) {
  const std::atomic<bool> cancel{true};
  RunContext context;
  context.cancel = &cancel;
  const Scan scan = bumpy_sphere(4);
  Scan mesh = collapsed(scan, 100);
  const auto positions = mesh.positions;
  fit_surface(scan, mesh, context);
  EXPECT_EQ(mesh.positions, positions);
}

}  // namespace
}  // namespace nacre::remesh
