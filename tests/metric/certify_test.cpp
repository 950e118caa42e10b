// SPDX-License-Identifier: GPL-3.0-or-later
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/distance.h>
#include <CGAL/Surface_mesh.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <atomic>
#include <cmath>
#include <limits>

#include "metric/metric.h"
#include "support/shapes.h"

namespace nacre::metric {
namespace {

using CgalMesh = CGAL::Surface_mesh<CGAL::Exact_predicates_inexact_constructions_kernel::Point_3>;

CgalMesh cgal_mesh(const Scan& scan) {
  CgalMesh mesh;
  for (const Vec3& p : scan.positions) mesh.add_vertex({p[0], p[1], p[2]});
  using Id = CgalMesh::Vertex_index;
  for (const Triangle& t : scan.triangles) mesh.add_face(Id(t[0]), Id(t[1]), Id(t[2]));
  return mesh;
}

double cgal_distance(const Scan& a, const Scan& b, double error) {
  return CGAL::Polygon_mesh_processing::bounded_error_Hausdorff_distance<CGAL::Sequential_tag>(
      cgal_mesh(a), cgal_mesh(b), error);
}

void expect_same(const CertifiedOneSided& x, const CertifiedOneSided& y) {
  EXPECT_EQ(x.lower, y.lower);
  EXPECT_EQ(x.upper, y.upper);
  EXPECT_EQ(x.lower_at, y.lower_at);
  EXPECT_EQ(x.pieces, y.pieces);
}

TEST(Certify, ParallelPlanesAreTheirDistanceApart) {
  const Scan a = shapes::grid(5, 7), b = shapes::moved(a, {0, 0, 0.25});
  const Certified c = *certified_distance(a, b);
  for (const CertifiedOneSided& side : {c.a_to_b, c.b_to_a}) {
    EXPECT_NEAR(side.lower, 0.25, 1e-12);
    EXPECT_NEAR(side.upper, 0.25, 1e-12);
    EXPECT_TRUE(side.within_tolerance);
  }
}

// The farthest point lies inside a face, on the ridge midway between two walls, where no vertex is
// and no sample need be: a floor of two triangles under a roof of two walls at x = 0 and x = 4.
TEST(Certify, FindsAMaximumInsideAFace) {
  Scan floor, walls;
  floor.positions = {{0.5, 0, 0}, {3.5, 0, 0}, {3.5, 4, 0}, {0.5, 4, 0}};
  floor.triangles = {{0, 1, 2}, {0, 2, 3}};
  for (const double x : {0.0, 4.0}) {
    const auto first = static_cast<std::uint32_t>(walls.positions.size());
    for (const auto& [y, z] : {std::pair(-9, -9), {9, -9}, {9, 9}, {-9, 9}})
      walls.positions.emplace_back(x, y, z);
    walls.triangles.push_back({first, first + 1, first + 2});
    walls.triangles.push_back({first, first + 2, first + 3});
  }
  CertifyOptions options;
  options.relative_tolerance = 1e-4;
  const Certified c = *certified_distance(floor, walls, options);
  EXPECT_LE(c.a_to_b.lower, 2.0);
  EXPECT_GE(c.a_to_b.upper, 2.0);
  EXPECT_LE(c.a_to_b.upper, c.a_to_b.lower * 1.0001 + 1e-12);
  EXPECT_NEAR(c.a_to_b.lower_at[0], 2.0, 1e-3);
  EXPECT_TRUE(c.within_tolerance());
}

// Anything a sampler meets lies below the upper bound, and the bounds are as near as asked for.
TEST(Certify, HoldsWhatDenseSamplingFinds) {
  const Scan a = shapes::bumpy_sphere(4), b = shapes::sphere(3);
  const Certified c = *certified_distance(a, b);
  Options dense;
  dense.samples = 300'000;
  const Comparison sampled = *compare(a, b, dense);
  EXPECT_GE(c.a_to_b.upper, sampled.a_to_b.maximum);
  EXPECT_GE(c.b_to_a.upper, sampled.b_to_a.maximum);
  EXPECT_LE(c.a_to_b.upper, sampled.a_to_b.maximum * 1.02);
  EXPECT_LE(c.b_to_a.upper, sampled.b_to_a.maximum * 1.02);
  EXPECT_LE(c.a_to_b.lower, c.a_to_b.upper);
  EXPECT_EQ(c.upper(), std::max(c.a_to_b.upper, c.b_to_a.upper));
  EXPECT_TRUE(c.within_tolerance());
}

TEST(Certify, AgreesWithCgal) {
  const Scan shapes_of[][2] = {
      {shapes::bumpy_sphere(3), shapes::sphere(3)},
      {shapes::torus(24, 16), shapes::torus(31, 12, 1.02, 0.38)},
      {shapes::sphere(3), shapes::icosahedron()},
  };
  CertifyOptions options;
  options.relative_tolerance = 1e-3;
  for (const auto& [a, b] : shapes_of) {
    const Certified c = *certified_distance(a, b, options);
    const double error = 1e-3;
    // CGAL's answer is within `error` of the distance.
    EXPECT_NEAR(cgal_distance(a, b, error), c.a_to_b.lower, error + 1e-3 * c.a_to_b.upper);
    EXPECT_NEAR(cgal_distance(b, a, error), c.b_to_a.lower, error + 1e-3 * c.b_to_a.upper);
  }
}

TEST(Certify, AgreesWithItselfOnOverlaidFaces) {
  const Scan a = shapes::bumpy_sphere(3), b = shapes::icosahedron();
  CertifyOptions options;
  options.relative_tolerance = 1e-3;
  const Certified whole = *certified_distance(a, b, options);
  Scan fine = a;  // each face's middle quarter lies over it once more: the same surface
  for (const Triangle& t : a.triangles) {
    const auto first = static_cast<std::uint32_t>(fine.positions.size());
    for (std::size_t k = 0; k < 3; ++k)
      fine.positions.push_back(0.5 * (a.positions[t[k]] + a.positions[t[(k + 1) % 3]]));
    fine.triangles.push_back({first, first + 1, first + 2});
  }
  const Certified split = *certified_distance(fine, b, options);
  EXPECT_LE(whole.a_to_b.lower, split.a_to_b.upper);
  EXPECT_LE(split.a_to_b.lower, whole.a_to_b.upper);
}

TEST(Certify, EqualSurfacesAreNothingApart) {
  const Scan a = shapes::torus(40, 24);
  const Certified c = *certified_distance(a, a);
  EXPECT_EQ(c.lower(), 0);
  EXPECT_LT(c.upper(), 1e-12);
}

// The same plane in other triangles: bounds close by halving alone.
TEST(Certify, ThePlaneInOtherTrianglesIsWithinTheTolerance) {
  Scan coarse;
  coarse.positions = {{0, 0, 0}, {6, 0, 0}, {6, 6, 0}, {0, 6, 0}};
  coarse.triangles = {{0, 1, 2}, {0, 2, 3}};
  CertifyOptions options;
  options.diagonal_tolerance = 1e-3;
  const Certified c = *certified_distance(coarse, shapes::grid(6, 6), options);
  EXPECT_EQ(c.lower(), 0);
  EXPECT_LE(c.upper(), 1.001e-3 * c.bbox_diagonal);
  EXPECT_TRUE(c.within_tolerance());
}

TEST(Certify, ABudgetLeavesTrueButLooseBounds) {
  CertifyOptions options;
  options.diagonal_tolerance = 1e-9;
  options.max_pieces = 0;
  const Certified c = *certified_distance(shapes::bumpy_sphere(3), shapes::sphere(2), options);
  const Certified exact = *certified_distance(shapes::bumpy_sphere(3), shapes::sphere(2));
  EXPECT_GE(c.upper(), exact.lower());
  EXPECT_LE(c.lower(), exact.upper());
  EXPECT_FALSE(c.within_tolerance());
}

TEST(Certify, GivesUpAboveALimitWithTrueBounds) {
  const Scan a = shapes::bumpy_sphere(4), b = shapes::sphere(4);
  const Certified full = *certified_distance(a, b);
  CertifyOptions options;
  options.give_up_above = full.lower() / 2;
  const Certified early = *certified_distance(a, b, options);
  EXPECT_GT(early.lower(), options.give_up_above);
  EXPECT_GE(early.upper(), full.lower());
  EXPECT_LE(early.a_to_b.pieces, full.a_to_b.pieces);
}

TEST(Certify, RotatedAndFarAwaySurfacesKeepTheirDistance) {
  const Scan a = shapes::bumpy_sphere(3), b = shapes::sphere(3);
  const Certified here = *certified_distance(a, b);
  Scan far_a = a, far_b = shapes::moved(b, {-1000, 0, 250});
  far_a.origin = {500'000, 4'000'000, 100};
  far_b.origin = {501'000, 4'000'000, -150};
  const Certified there = *certified_distance(far_a, far_b);
  EXPECT_NEAR(there.upper(), here.upper(), 1e-9 * here.bbox_diagonal);
  EXPECT_NEAR(there.lower(), here.lower(), 1e-9 * here.bbox_diagonal);

  const auto turned = [](Scan scan) {
    const double c = std::cos(0.7), s = std::sin(0.7);
    for (Vec3& p : scan.positions) {
      p = Vec3(c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]);
      p = Vec3(p[0], c * p[1] - s * p[2], s * p[1] + c * p[2]);
    }
    return scan;
  };
  const Certified elsewhere = *certified_distance(turned(a), turned(b));
  EXPECT_TRUE(elsewhere.within_tolerance());
  EXPECT_LE(elsewhere.lower(), here.upper());  // bounds of one value overlap
  EXPECT_LE(here.lower(), elsewhere.upper());
}

TEST(Certify, NonManifoldAndDegenerateFacesAreMeasuredAsTheyAre) {
  Scan a = shapes::sphere(2);
  a.positions.emplace_back(0, 0, 3);  // a fin over an edge that has two faces already
  a.triangles.push_back(
      {a.triangles[0][0], a.triangles[0][1], static_cast<std::uint32_t>(a.positions.size() - 1)});
  a.triangles.push_back({0, 0, 1});  // no area
  const Certified c = *certified_distance(a, shapes::sphere(2));
  EXPECT_NEAR(c.a_to_b.lower, 2.0, 0.01);  // the tip over the pole
  EXPECT_GE(c.a_to_b.upper, c.a_to_b.lower);
  EXPECT_LT(c.b_to_a.upper, 1e-12);
}

TEST(Certify, SameBoundsAtAnyThreadCount) {
  const Scan a = shapes::bumpy_sphere(4), b = shapes::torus(50, 30, 0.8, 0.35);
  Certified by_threads[2];
  for (const std::size_t threads : {1u, 2u}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    by_threads[threads - 1] = *certified_distance(a, b);
  }
  expect_same(by_threads[0].a_to_b, by_threads[1].a_to_b);
  expect_same(by_threads[0].b_to_a, by_threads[1].b_to_a);
}

TEST(Certify, RefusesSenselessTolerancesAndSurfaces) {
  const Scan a = shapes::tetrahedron();
  for (const double bad : {-0.1, 1.5, std::numeric_limits<double>::quiet_NaN()}) {
    CertifyOptions options;
    options.relative_tolerance = bad;
    EXPECT_EQ(certified_distance(a, a, options).error().code, ErrorCode::kBadInput);
    options = {};
    options.diagonal_tolerance = bad;
    EXPECT_EQ(certified_distance(a, a, options).error().code, ErrorCode::kBadInput);
  }
  EXPECT_EQ(certified_distance(a, Scan{}).error().code, ErrorCode::kBadInput);
  EXPECT_EQ(certified_distance(Scan{}, a).error().code, ErrorCode::kBadInput);
}

TEST(Certify, CanBeCancelled) {
  const std::atomic<bool> cancel = true;
  RunContext context;
  context.cancel = &cancel;
  const Scan a = shapes::sphere(3);
  EXPECT_EQ(certified_distance(a, shapes::torus(9, 9), {}, context).error().code,
            ErrorCode::kCancelled);
}

}  // namespace
}  // namespace nacre::metric
