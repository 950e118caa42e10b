// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/pierce.h"

#include <gtest/gtest.h>

#include <atomic>

#include "map_checks.h"
#include "remesh/relax.h"
#include "wavelet/wavelet.h"

namespace nacre::remesh {
namespace {

Pierced pierced(const Scan& scan, int base_vertices, int levels, double near_boundary = 0) {
  SimplifyOptions options;
  options.base_vertices = base_vertices;
  Parameterisation map = *simplify(scan, options);
  relax(scan, map, {});
  PierceOptions pierce_options;
  pierce_options.levels = levels;
  pierce_options.near_boundary = near_boundary;
  auto out =
      pierce(SurfaceMap(scan, map), map, LineTree(scan), wavelet::predict_level, pierce_options);
  EXPECT_TRUE(out.has_value());
  return std::move(*out);
}

double farthest_from(const Scan& scan, const std::vector<Vec3>& points) {
  const LineTree tree(scan);
  double most = 0;
  for (const Vec3& p : points)
    most =
        std::max(most, (position_of(tree.nearest(p), scan.triangles, scan.positions) - p).norm());
  return most;
}

/// The kinds and counts agree with each other and with the details as the coder sees them.
void expect_consistent(const Pierced& out, int levels, double near_boundary = 0) {
  const SemiRegularMesh& mesh = out.mesh;
  const Topology topology = *Topology::build(mesh.base_triangles, mesh.base_vertex_count, levels);
  ASSERT_EQ(mesh.level_count, levels);
  ASSERT_EQ(mesh.positions.size(), topology.vertex_count());
  ASSERT_EQ(out.kind.size(), mesh.positions.size());
  ASSERT_EQ(out.bands.size(), static_cast<std::size_t>(levels));
  const auto pyramid = wavelet::analyze(topology, mesh.positions);
  ASSERT_TRUE(pyramid.has_value());
  for (int j = 0; j < levels; ++j) {
    const auto& band = pyramid->bands[static_cast<std::size_t>(j)];
    const BandReport& report = out.bands[static_cast<std::size_t>(j)];
    const std::uint32_t first = topology.level(j).vertex_count;
    EXPECT_EQ(report.vertices, band.size());
    std::size_t normal = 0;
    for (std::uint32_t i = 0; i < band.size(); ++i) {
      const bool tangential = std::abs(band[i][1]) + std::abs(band[i][2]) > 1e-9;
      normal += out.kind[first + i] == 0;
      if (out.kind[first + i] == 0) {
        EXPECT_FALSE(tangential) << "vertex " << first + i;
      }
      const bool on_boundary = topology.level(j).edges[i].is_boundary();
      if (near_boundary == 0) {
        EXPECT_EQ(out.kind[first + i] == 1, on_boundary);
      } else {
        EXPECT_FALSE(out.kind[first + i] == 1 && !on_boundary);
      }
    }
    EXPECT_EQ(report.normal_only, normal);
  }
}

TEST(Pierce, SphereIsNormalOnlyWithoutFolds) {
  const Scan scan = shapes::sphere(5);
  for (const int size : {12, 40, 120}) {
    const Pierced out = pierced(scan, size, 4);
    expect_consistent(out, 4);
    for (const BandReport& band : out.bands) {
      EXPECT_EQ(band.normal_only, band.vertices);
      EXPECT_EQ(band.folded_triangles, 0u);
    }
    EXPECT_LT(farthest_from(scan, out.mesh.positions), 1e-9);
  }
}

TEST(Pierce, AllKindsOfScansLieOnTheScanAndConverge) {
  for (const auto& [name, scan] : testing::scans_of_all_kinds()) {
    SCOPED_TRACE(name);
    const Pierced out = pierced(scan, 60, 4);
    expect_consistent(out, 4);
    EXPECT_LT(farthest_from(scan, out.mesh.positions), 1e-9);
    std::vector<double> error;
    for (int j = 0; j <= 4; ++j)
      error.push_back(testing::rms_error(scan, testing::level_of(out.mesh, j)));
    if (name == "grid with a hole") {
      EXPECT_LT(error[4], 0.1);  // flat: only the corners of its boundary are ever missed
      continue;
    }
    for (std::size_t j = 0; j < 4; ++j) EXPECT_LT(error[j + 1], error[j]) << "level " << j + 1;
    EXPECT_LT(error[4], error[0] / (name == "double torus" ? 4 : 8));  // sharp edges: slower
  }
}

/// The farthest that a boundary vertex of the mesh is from the scan's boundary.
double farthest_from_boundary(const Scan& scan, const Scan& mesh) {
  const auto on_boundary = testing::boundary_vertices(mesh);
  const auto scan_boundary = testing::boundary_vertices(scan);
  double most = 0;
  std::size_t count = 0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    if (!on_boundary[v]) continue;
    ++count;
    const Vec3& p = mesh.positions[v];
    double nearest = 1e300;
    for (const Triangle& t : scan.triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 &a = scan.positions[t[k]], &b = scan.positions[t[(k + 1) % 3]];
        if (!scan_boundary[t[k]] || !scan_boundary[t[(k + 1) % 3]]) continue;
        const double s = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
        nearest = std::min(nearest, (a + s * (b - a) - p).norm());
      }
    }
    most = std::max(most, nearest);
  }
  EXPECT_GE(count, 48u);
  return most;
}

TEST(Pierce, BoundaryVerticesLieOnTheScansBoundary) {
  for (const Scan& scan : {shapes::hemisphere(5), shapes::grid(20, 20)}) {
    const Scan fine = testing::level_of(pierced(scan, 30, 4).mesh, 4);
    EXPECT_LT(farthest_from_boundary(scan, fine), 1e-9);
    EXPECT_EQ(testing::facts_of(fine).boundary_loops, 1u);
  }
}

TEST(Pierce, BoundaryVerticesAreOnTheirLinesWhereTheBoundaryIsNear) {
  const Scan scan = shapes::hemisphere(5);  // extent: the diagonal of 2 x 2 x 1
  const double near = 1e-3;
  const Pierced exact = pierced(scan, 30, 4), out = pierced(scan, 30, 4, near);
  expect_consistent(out, 4, near);
  EXPECT_LE(farthest_from_boundary(scan, testing::level_of(out.mesh, 4)), 3 * near * (1 + 1e-9));
  std::size_t more = 0;
  for (std::size_t j = 0; j < 4; ++j) {
    EXPECT_GE(out.bands[j].normal_only, exact.bands[j].normal_only);
    more += out.bands[j].normal_only - exact.bands[j].normal_only;
  }
  EXPECT_GT(more, 40u);
}

TEST(Pierce, IsTheSameAtAnyThreadCount) {
  const Scan scan = shapes::bumpy_sphere(4);
  const Pierced one = testing::with_threads(1, [&] { return pierced(scan, 60, 4); });
  const Pierced two = testing::with_threads(2, [&] { return pierced(scan, 60, 4); });
  EXPECT_EQ(one.mesh.positions, two.mesh.positions);
  EXPECT_EQ(one.kind, two.kind);
}

TEST(Pierce, SurvivesTheSmallest) {
  const Scan triangle = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  for (const Scan& scan : {triangle, shapes::tetrahedron(), shapes::grid(1, 1)}) {
    const Pierced out = pierced(scan, 3, 3);
    for (const Vec3& p : out.mesh.positions) EXPECT_TRUE(p.allFinite());
    if (scan.triangles.size() < 4) {  // flat: all of it is found again
      EXPECT_LT(testing::rms_error(scan, testing::level_of(out.mesh, 3)), 1e-9);
    }
  }
}

TEST(Pierce, CanBeCancelled) {
  const Scan scan = shapes::sphere(3);
  SimplifyOptions options;
  options.base_vertices = 20;
  const Parameterisation map = *simplify(scan, options);
  const std::atomic<bool> stop{true};
  RunContext context;
  context.cancel = &stop;
  const auto out =
      pierce(SurfaceMap(scan, map), map, LineTree(scan), wavelet::predict_level, {}, context);
  ASSERT_FALSE(out.has_value());
  EXPECT_EQ(out.error().code, ErrorCode::kCancelled);
}

}  // namespace
}  // namespace nacre::remesh
