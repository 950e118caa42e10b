// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include "map_checks.h"
#include "wavelet/wavelet.h"

/// What the tests of whole remeshings share.
namespace nacre::remesh::testing {

inline Options options_of(int base_vertices, int levels) {
  Options options;
  options.base_vertices = base_vertices;
  options.levels = levels;
  options.predict = wavelet::predict_at_need;
  return options;
}

/// Every level is a manifold of the scan's kind, and every position is a number.
inline void expect_healthy(const Remesh& out) {
  const SemiRegularMesh& mesh = out.mesh;
  const auto topology =
      Topology::build(mesh.base_triangles, mesh.base_vertex_count, mesh.level_count);
  ASSERT_TRUE(topology.has_value());
  ASSERT_EQ(mesh.positions.size(), topology->vertex_count());
  std::size_t broken = 0;
  for (const Vec3& p : mesh.positions) broken += !p.allFinite();
  EXPECT_EQ(broken, 0u);
  const ManifoldFacts facts = manifold_facts(mesh.base_triangles, mesh.base_vertex_count);
  ASSERT_EQ(facts.defect, "");
  EXPECT_EQ(facts.pieces, out.clean.pieces);
  EXPECT_EQ(facts.closed_pieces, out.clean.closed_pieces);
  EXPECT_EQ(facts.boundary_loops, out.clean.boundary_loops);
  EXPECT_EQ(facts.genus, out.clean.genus);
  ASSERT_EQ(out.bands.size(), static_cast<std::size_t>(mesh.level_count));
  std::size_t vertices = mesh.base_vertex_count;
  for (const BandReport& band : out.bands) {
    vertices += band.vertices;
    EXPECT_LE(band.normal_only, band.vertices);
  }
  EXPECT_EQ(vertices, mesh.positions.size());
  ASSERT_EQ(out.pieces.size(), out.clean.pieces);
  std::size_t base_triangles = 0, loops = 0;
  int genus = 0;
  for (const PieceReport& piece : out.pieces) {
    EXPECT_GE(piece.base_triangles, 1u);
    base_triangles += piece.base_triangles;
    loops += piece.boundary_loops;
    genus += piece.genus;
  }
  EXPECT_EQ(base_triangles, mesh.base_triangles.size());
  EXPECT_EQ(loops, out.clean.boundary_loops);
  EXPECT_EQ(genus, out.clean.genus);
}

inline double final_error(const Scan& scan, const Remesh& out) {
  return rms_error(scan, level_of(out.mesh, out.mesh.level_count));
}

}  // namespace nacre::remesh::testing
