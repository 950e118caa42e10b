// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <memory>

#include "meshes.h"
#include "wavelet/wavelet.h"

// OpenSubdiv's refiner is the independent witness for base/'s split numbering and for Loop's rules.

namespace nacre::wavelet {
namespace {

namespace Far = OpenSubdiv::Far;
using testing::topology_of;

std::unique_ptr<Far::TopologyRefiner> refiner_of(const Scan& scan, int levels) {
  const std::vector<int> sizes(scan.triangles.size(), 3);
  std::vector<int> corners;
  for (const Triangle& t : scan.triangles)
    for (const std::uint32_t v : t) corners.push_back(static_cast<int>(v));
  Far::TopologyDescriptor descriptor;
  descriptor.numVertices = static_cast<int>(scan.positions.size());
  descriptor.numFaces = static_cast<int>(sizes.size());
  descriptor.numVertsPerFace = sizes.data();
  descriptor.vertIndicesPerFace = corners.data();
  OpenSubdiv::Sdc::Options options;
  options.SetVtxBoundaryInterpolation(OpenSubdiv::Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  std::unique_ptr<Far::TopologyRefiner> refiner(
      Factory::Create(descriptor, Factory::Options(OpenSubdiv::Sdc::SCHEME_LOOP, options)));
  Far::TopologyRefiner::UniformOptions uniform(levels);
  uniform.fullTopologyInLastLevel = true;
  refiner->RefineUniform(uniform);
  return refiner;
}

/// Their vertex of the next level for each of ours, from the same map of this level: kept vertices
/// through their parent vertex, midpoints through the ends of their edge.
std::vector<int> map_next_level(const LevelTopology& ours, const Far::TopologyLevel& theirs,
                                const std::vector<int>& map) {
  std::vector<int> next;
  for (const int v : map) next.push_back(theirs.GetVertexChildVertex(v));
  for (const Edge& e : ours.edges) {
    const int edge = theirs.FindEdge(map[e.vertex[0]], map[e.vertex[1]]);
    EXPECT_GE(edge, 0);
    next.push_back(theirs.GetEdgeChildVertex(edge));
  }
  return next;
}

std::vector<int> identity(std::size_t count) {
  std::vector<int> map(count);
  for (std::size_t i = 0; i < count; ++i) map[i] = static_cast<int>(i);
  return map;
}

std::array<int, 3> from_smallest(std::array<int, 3> t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

void expect_same_faces(const LevelTopology& ours, const Far::TopologyLevel& theirs,
                       const std::vector<int>& map) {
  std::vector<std::array<int, 3>> a, b;
  for (const Triangle& t : ours.triangles)
    a.push_back(from_smallest({map[t[0]], map[t[1]], map[t[2]]}));
  for (int f = 0; f < theirs.GetNumFaces(); ++f) {
    const auto corners = theirs.GetFaceVertices(f);
    b.push_back(from_smallest({corners[0], corners[1], corners[2]}));
  }
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  EXPECT_EQ(a, b);
}

void expect_same_edges(const LevelTopology& ours, const Far::TopologyLevel& theirs,
                       const std::vector<int>& map) {
  ASSERT_EQ(static_cast<int>(ours.edges.size()), theirs.GetNumEdges());
  std::vector<bool> found(ours.edges.size(), false);
  for (std::uint32_t e = 0; e < ours.edges.size(); ++e) {
    const Edge& edge = ours.edges[e];
    const int other = theirs.FindEdge(map[edge.vertex[0]], map[edge.vertex[1]]);
    ASSERT_GE(other, 0);
    ASSERT_FALSE(found[static_cast<std::size_t>(other)]) << "two of our edges are one of theirs";
    found[static_cast<std::size_t>(other)] = true;
    EXPECT_EQ(edge.is_boundary(), theirs.IsEdgeBoundary(other));
    // The faces on it: the same pair, and each holds the edge on the side that we say.
    std::vector<std::array<int, 3>> a, b;
    for (const std::uint32_t f : edge.face) {
      if (f == kNone) continue;
      const Triangle& t = ours.triangles[f];
      a.push_back(from_smallest({map[t[0]], map[t[1]], map[t[2]]}));
      const Triangle& sides = ours.triangle_edges[f];
      const auto side =
          static_cast<std::size_t>(std::find(sides.begin(), sides.end(), e) - sides.begin());
      ASSERT_LT(side, 3u);
      const bool forward = f == edge.face[0];  // directed as in the first face
      EXPECT_EQ(t[side], edge.vertex[forward ? 0 : 1]);
      EXPECT_EQ(t[(side + 1) % 3], edge.vertex[forward ? 1 : 0]);
    }
    for (const int f : theirs.GetEdgeFaces(other)) {
      const auto corners = theirs.GetFaceVertices(f);
      b.push_back(from_smallest({corners[0], corners[1], corners[2]}));
    }
    std::sort(a.begin(), a.end());
    std::sort(b.begin(), b.end());
    EXPECT_EQ(a, b);
  }
}

/// The meshes that OpenSubdiv takes as they are; it splits non-manifold vertices' rules apart.
std::vector<std::pair<std::string, Scan>> manifold_zoo() {
  std::vector<std::pair<std::string, Scan>> meshes;
  for (auto& mesh : testing::zoo()) {
    if (mesh.first == "bow tie" || mesh.first == "two-sided triangle" ||
        mesh.first == "isolated vertices")
      continue;
    meshes.push_back(std::move(mesh));
  }
  return meshes;
}

TEST(OpenSubdiv, AgreesOnTheTopologyOfEveryLevel) {
  constexpr int kLevels = 3;
  for (const auto& [name, scan] : manifold_zoo()) {
    SCOPED_TRACE(name);
    const auto refiner = refiner_of(scan, kLevels);
    const Topology topology = topology_of(scan, kLevels + 1);  // so that level 3 has edges
    std::vector<int> map = identity(scan.positions.size());
    for (int j = 0; j <= kLevels; ++j) {
      const LevelTopology& ours = topology.level(j);
      const Far::TopologyLevel& theirs = refiner->GetLevel(j);
      ASSERT_EQ(static_cast<int>(ours.vertex_count), theirs.GetNumVertices());
      ASSERT_EQ(static_cast<int>(ours.triangles.size()), theirs.GetNumFaces());
      ASSERT_EQ(map.size(), ours.vertex_count);
      expect_same_faces(ours, theirs, map);
      expect_same_edges(ours, theirs, map);
      if (j < kLevels) map = map_next_level(ours, theirs, map);
    }
  }
}

struct RefinedPoint {
  Vec3 p = Vec3::Zero();
  void Clear(void* = nullptr) { p = Vec3::Zero(); }
  void AddWithWeight(const RefinedPoint& other, double weight) { p += other.p * weight; }
};

TEST(OpenSubdiv, AgreesOnLoopSubdivision) {
  constexpr int kLevels = 3;
  for (const auto& [name, scan] : manifold_zoo()) {
    SCOPED_TRACE(name);
    const auto refiner = refiner_of(scan, kLevels);
    const Far::PrimvarRefinerReal<double> primvars(*refiner);
    const Topology topology = topology_of(scan, kLevels);
    Pyramid pyramid;
    pyramid.base_positions = testing::random_points(scan.positions.size(), 17);
    std::vector<RefinedPoint> theirs(scan.positions.size());
    for (std::size_t v = 0; v < theirs.size(); ++v) theirs[v].p = pyramid.base_positions[v];
    std::vector<int> map = identity(scan.positions.size());
    for (int j = 0; j < kLevels; ++j) {
      pyramid.bands.emplace_back(topology.band_size(j), Vec3::Zero());
      const std::vector<Vec3> ours = *synthesize(topology, pyramid, Transform::kLoop);
      std::vector<RefinedPoint> next(ours.size());
      primvars.Interpolate(j + 1, theirs, next);
      theirs = std::move(next);
      map = map_next_level(topology.level(j), refiner->GetLevel(j), map);
      for (std::size_t v = 0; v < ours.size(); ++v)
        ASSERT_LT((ours[v] - theirs[static_cast<std::size_t>(map[v])].p).norm(), 1e-14)
            << "level " << j + 1 << ", vertex " << v;
    }
  }
}

}  // namespace
}  // namespace nacre::wavelet
