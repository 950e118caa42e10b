// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "metric/metric.h"
#include "remesh/chart.h"
#include "remesh/remesh.h"
#include "remesh/simplify.h"
#include "support/manifold.h"
#include "support/shapes.h"

/// What the tests of the remesher's stages ask of a parameterisation.
namespace nacre::remesh::testing {

/// Scans of each kind: closed of genus 0, 1, 2, open with one and two loops, several pieces.
inline std::vector<std::pair<std::string, Scan>> scans_of_all_kinds() {
  const Scan sphere = shapes::sphere(4);
  const Scan pieces = shapes::joined(
      shapes::joined(shapes::sphere(3), shapes::moved(shapes::torus(24, 12), {4, 0, 0})),
      shapes::moved(shapes::hemisphere(3), {0, 4, 0}));
  return {{"sphere", sphere},
          {"torus", shapes::torus(40, 20)},
          {"double torus", shapes::split(shapes::plate(2), 2)},
          {"hemisphere", shapes::hemisphere(4)},
          {"grid with a hole", shapes::holed_grid(20, 7, 12)},
          {"bumpy sphere", shapes::bumpy_sphere(4)},
          {"three pieces", pieces}};
}

inline ManifoldFacts facts_of(const Scan& scan) {
  return manifold_facts(scan.triangles, scan.positions.size());
}
inline ManifoldFacts facts_of(const BaseMesh& base) {
  return manifold_facts(base.triangles, base.scan_vertex.size());
}

/// Weights all >= 0 that sum to 1, in a face that exists.
template <class Point>
bool is_valid(const Point& p, std::size_t face_count) {
  const auto& w = p.weight;
  return p.face < face_count && w[0] >= 0 && w[1] >= 0 && w[2] >= 0 &&
         std::abs(w[0] + w[1] + w[2] - 1) < 1e-9;
}

/// How the scan's triangles lie in the domain.
struct Orientation {
  std::size_t known = 0;        ///< triangles whose corners share a chart
  std::size_t turned = 0;       ///< of those, turned over
  std::size_t same_face = 0;    ///< triangles with all corners in one base triangle
  std::size_t same_turned = 0;  ///< of those, turned over
  [[nodiscard]] double share() const {
    return static_cast<double>(turned) / static_cast<double>(known);
  }
};

inline Orientation orientation_of(const Scan& scan, const Parameterisation& map) {
  const Atlas atlas(map.base);
  Orientation out;
  for (const Triangle& t : scan.triangles) {
    const std::array<std::uint32_t, 3> faces = {map.point[t[0]].face, map.point[t[1]].face,
                                                map.point[t[2]].face};
    const auto chart = atlas.common_chart(faces);
    if (!chart) continue;
    const Eigen::Vector2d a = *chart->map(map.point[t[0]]), b = *chart->map(map.point[t[1]]),
                          c = *chart->map(map.point[t[2]]);
    const Eigen::Vector2d e = b - a, g = c - a;
    // A triangle that is flat to rounding is not turned: base corners may lie on one line.
    const bool turned = e[0] * g[1] - e[1] * g[0] < -1e-12;
    const bool same = faces[0] == faces[1] && faces[1] == faces[2];
    ++out.known;
    out.turned += turned;
    out.same_face += same;
    out.same_turned += same && turned;
  }
  return out;
}

/// Scan vertices on the boundary, by the definition.
inline std::vector<char> boundary_vertices(const Scan& scan) {
  manifold_detail::DirectedSides sides;
  for (std::size_t f = 0; f < scan.triangles.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k)
      sides[{scan.triangles[f][k], scan.triangles[f][(k + 1) % 3]}] = f;
  std::vector<char> out(scan.positions.size(), 0);
  for (const auto& [side, face] : sides)
    if (sides.count({side.second, side.first}) == 0) out[side.first] = out[side.second] = 1;
  return out;
}

/// Whether a domain point lies exactly on a side of the base that is boundary.
inline bool on_base_boundary(const BaseMesh& base, const DomainPoint& p) {
  for (std::size_t k = 0; k < 3; ++k)
    if (base.neighbors[p.face][k] == kNone && p.weight[(k + 2) % 3] == 0) return true;
  // A corner may be seen from a triangle that has no boundary side itself.
  for (std::size_t c = 0; c < 3; ++c) {
    if (p.weight[c] != 1) continue;
    for (std::size_t f = 0; f < base.triangles.size(); ++f)
      for (std::size_t k = 0; k < 3; ++k)
        if (base.neighbors[f][k] == kNone &&
            (base.triangles[f][k] == base.triangles[p.face][c] ||
             base.triangles[f][(k + 1) % 3] == base.triangles[p.face][c]))
          return true;
  }
  return false;
}

/// Runs body with at most that many threads.
template <class Body>
auto with_threads(int threads, const Body& body) {
  tbb::task_arena arena(threads);
  return arena.execute(body);
}

/// Worse of the two one-sided root mean square distances.
inline double rms_error(const Scan& a, const Scan& b) {
  metric::Options options;
  options.samples = 20'000;
  const auto comparison = metric::compare(a, b, options);
  return comparison ? std::max(comparison->a_to_b.rms, comparison->b_to_a.rms) : 1e300;
}

/// Level `level` of a semi-regular mesh.
inline Scan level_of(const SemiRegularMesh& mesh, int level) {
  const Topology topology =
      *Topology::build(mesh.base_triangles, mesh.base_vertex_count, mesh.level_count);
  const LevelTopology& at = topology.level(level);
  return {{mesh.positions.begin(), mesh.positions.begin() + at.vertex_count},
          at.triangles,
          mesh.origin};
}

}  // namespace nacre::remesh::testing
