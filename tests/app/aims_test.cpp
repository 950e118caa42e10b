// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/aims.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "app/files.h"
#include "base/topology.h"
#include "codec/codec.h"
#include "support/shapes.h"

namespace nacre::app::test {
namespace {

/// A ball's mesh with all vertices on it, or half of one.
SemiRegularMesh mesh_on_ball(int levels, bool half = false) {
  const Scan base = shapes::sphere(1);
  SemiRegularMesh mesh;
  for (const Triangle& t : base.triangles)
    if (!half || base.positions[t[0]][2] + base.positions[t[1]][2] + base.positions[t[2]][2] > 0)
      mesh.base_triangles.push_back(t);
  mesh.base_vertex_count = static_cast<std::uint32_t>(base.positions.size());
  if (half) {
    std::vector<std::uint32_t> number(base.positions.size(), kNone);
    std::uint32_t count = 0;
    for (Triangle& t : mesh.base_triangles) {
      for (std::uint32_t& v : t) {
        if (number[v] == kNone) {
          number[v] = count++;
          mesh.positions.push_back(base.positions[v]);
        }
        v = number[v];
      }
    }
    mesh.base_vertex_count = count;
  } else {
    mesh.positions = base.positions;
  }
  mesh.level_count = levels;
  const auto topology =
      Topology::build(mesh.base_triangles, mesh.base_vertex_count, levels).value();
  for (int j = 0; j < levels; ++j)
    for (const Edge& e : topology.level(j).edges)
      mesh.positions.push_back(
          (mesh.positions[e.vertex[0]] + mesh.positions[e.vertex[1]]).normalized());
  return mesh;
}

struct Ball {
  Scan scan = shapes::sphere(6);
  metric::Surface surface = metric::Surface::build(scan).value();
  [[nodiscard]] Reference reference() const { return {scan, surface}; }
  [[nodiscard]] double psnr(const SemiRegularMesh& mesh, const std::vector<Vec3>& positions) const {
    SemiRegularMesh moved = mesh;
    moved.positions = positions;
    const Scan triangles = to_triangles(moved).value();
    return metric::compare(scan, surface, triangles, {.samples = 50'000}).value().psnr_db;
  }
};

TEST(Aims, TrianglesGoThroughTheScanNotBelowIt) {
  const Ball ball;
  const SemiRegularMesh mesh = mesh_on_ball(2);
  const std::vector<Vec3> aims = aims_between(mesh, ball.reference());
  ASSERT_EQ(aims.size(), mesh.positions.size());
  for (const Vec3& p : aims) EXPECT_GT(p.norm(), 1);
  // The square of a bulge's mean is 15/16 of its mean square: a quarter of the distance is left.
  EXPECT_GT(ball.psnr(mesh, aims), ball.psnr(mesh, mesh.positions) + 10);
}

TEST(Aims, StayWhereTheScanIsFlatAndOnBoundaries) {
  const Ball ball;
  const SemiRegularMesh mesh = mesh_on_ball(2, true);
  const auto topology =
      Topology::build(mesh.base_triangles, mesh.base_vertex_count, mesh.level_count).value();
  const std::vector<Vec3> aims = aims_between(mesh, ball.reference());
  std::size_t moved = 0, on_boundary = 0;
  std::vector<char> is_boundary(aims.size(), 0);
  for (int j = 0; j < 2; ++j) {
    const LevelTopology& level = topology.level(j);
    for (std::size_t e = 0; e < level.edges.size(); ++e) {
      if (!level.edges[e].is_boundary()) continue;
      is_boundary[level.vertex_count + e] = 1;
      for (const std::uint32_t v : level.edges[e].vertex) is_boundary[v] = 1;
    }
  }
  for (std::size_t v = 0; v < aims.size(); ++v) {
    if (is_boundary[v] != 0) {
      ++on_boundary;
      EXPECT_EQ(aims[v], mesh.positions[v]);
    } else {
      moved += aims[v] != mesh.positions[v] ? 1 : 0;
    }
  }
  EXPECT_GT(on_boundary, 0u);
  EXPECT_EQ(moved, aims.size() - on_boundary);

  // The mesh against its own triangles: nothing is cut off.
  const Scan own = to_triangles(mesh).value();
  const metric::Surface surface = metric::Surface::build(own).value();
  const std::vector<Vec3> same = aims_between(mesh, {own, surface});
  for (std::size_t v = 0; v < same.size(); ++v)
    EXPECT_LT((same[v] - mesh.positions[v]).norm(), 1e-12);
}

TEST(Aims, AreTheSameAtAnyThreadCount) {
  const Ball ball;
  const SemiRegularMesh mesh = mesh_on_ball(3);
  std::vector<Vec3> one, three;
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    one = aims_between(mesh, ball.reference());
  }
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 3);
    three = aims_between(mesh, ball.reference());
  }
  EXPECT_EQ(one, three);
}

TEST(Aims, AMeshWithoutLevelsHasNone) {
  const Ball ball;
  EXPECT_TRUE(aims_between(mesh_on_ball(0), ball.reference()).empty());
}

TEST(Aims, MakeAFileOfTheSameSizeBetter) {
  const Ball ball;
  const SemiRegularMesh mesh = mesh_on_ball(2);
  codec::EncodeOptions options;
  options.profile = codec::Profile::kBest;
  options.target_bytes = 500;  // the mesh is what limits it
  const std::vector<Vec3> aims = aims_between(mesh, ball.reference());
  const auto psnr_of = [&] {
    const auto encoded = codec::encode(mesh, options).value();
    const SemiRegularMesh decoded = codec::decode(encoded.bytes).value();
    return ball.psnr(decoded, decoded.positions);
  };
  const double without = psnr_of();
  options.aims = aims;
  EXPECT_GT(psnr_of(), without + 5);
  options.aims = std::span(aims).first(10);
  const auto refused = codec::encode(mesh, options);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kBadInput);
}

}  // namespace
}  // namespace nacre::app::test
