// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/kept_pieces.h"

#include <numeric>

#include "remesh/adjacency.h"

namespace nacre::remesh {
namespace {

/// Where the edges of one level of a mesh are among those of two meshes joined.
using Places = std::vector<std::uint32_t>;

/// The same one level further; Topology says how edges are numbered. `edges` is of both meshes,
/// `face_offset` the number of triangles before this one's.
Places split(const Places& edge, std::size_t edges, std::size_t face_offset, std::size_t faces) {
  Places out;
  out.reserve(2 * edge.size() + 3 * faces);
  for (const std::uint32_t e : edge) {
    out.push_back(2 * e);
    out.push_back(2 * e + 1);
  }
  for (std::size_t i = 0; i < 3 * faces; ++i)
    out.push_back(static_cast<std::uint32_t>(2 * edges + 3 * face_offset + i));
  return out;
}

Result<Topology> topology_of(const SemiRegularMesh& mesh) {
  return Topology::build(mesh.base_triangles, mesh.base_vertex_count, mesh.level_count);
}

/// Puts what `mesh` has on one level to its places.
void put_level(const Pierced& from, const LevelTopology& level, const Places& edge,
               std::size_t first, Pierced& to) {
  for (std::size_t e = 0; e < edge.size(); ++e) {
    to.mesh.positions[first + edge[e]] = from.mesh.positions[level.vertex_count + e];
    to.kind[first + edge[e]] = from.kind[level.vertex_count + e];
  }
}

/// All but the positions and kinds of what is not in the base.
Pierced joined_base(const Pierced& a, const Pierced& b) {
  Pierced out;
  out.mesh = a.mesh;
  out.kind.assign(a.kind.begin(), a.kind.begin() + a.mesh.base_vertex_count);
  out.kind.insert(out.kind.end(), b.kind.begin(), b.kind.begin() + b.mesh.base_vertex_count);
  out.folds = a.folds;
  out.folds.insert(out.folds.end(), b.folds.begin(), b.folds.end());
  for (const Triangle& t : b.mesh.base_triangles) {
    const std::uint32_t offset = a.mesh.base_vertex_count;
    out.mesh.base_triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  }
  out.mesh.base_vertex_count += b.mesh.base_vertex_count;
  out.mesh.positions.resize(a.mesh.base_vertex_count);
  out.mesh.positions.insert(out.mesh.positions.end(), b.mesh.positions.begin(),
                            b.mesh.positions.begin() + b.mesh.base_vertex_count);
  out.bands = a.bands;
  for (std::size_t i = 0; i < out.bands.size(); ++i) {
    out.bands[i].vertices += b.bands[i].vertices;
    out.bands[i].normal_only += b.bands[i].normal_only;
    out.bands[i].folded_triangles += b.bands[i].folded_triangles;
  }
  return out;
}

}  // namespace

Result<Pierced> kept_as_it_is(const Scan& scan, int levels) {
  const auto vertices = static_cast<std::uint32_t>(scan.positions.size());
  const auto topology = Topology::build(scan.triangles, vertices, levels);
  if (!topology) return topology.error();
  Pierced out;
  out.mesh = {scan.triangles, vertices, levels, scan.positions, scan.origin};
  out.kind.assign(vertices, 0);
  out.folds.assign(scan.triangles.size(), 0);
  auto& positions = out.mesh.positions;
  for (int level = 0; level < levels; ++level) {
    for (const Edge& e : topology->level(level).edges) {
      positions.push_back((positions[e.vertex[0]] + positions[e.vertex[1]]) / 2);
      out.kind.push_back(e.is_boundary() ? 1 : 2);
    }
    out.bands.push_back({topology->level(level).edges.size(), 0, 0});
  }
  return out;
}

Parameterisation identity(const Scan& scan) {
  Parameterisation map;
  const auto vertices = static_cast<std::uint32_t>(scan.positions.size());
  map.base.triangles = scan.triangles;
  map.base.neighbors = side_neighbors(scan.triangles, vertices);
  map.point.resize(vertices);
  for (std::uint32_t v = 0; v < vertices; ++v) map.base.scan_vertex.push_back(v);
  for (std::uint32_t f = 0; f < scan.triangles.size(); ++f) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      DomainPoint corner{f, {}};
      corner.weight[k] = 1;
      map.point[scan.triangles[f][k]] = corner;
    }
  }
  return map;
}

Result<Pierced> joined(const Pierced& a, const Pierced& b) {
  const auto first = topology_of(a.mesh), second = topology_of(b.mesh);
  if (!first) return first.error();
  if (!second) return second.error();
  Pierced out = joined_base(a, b);
  Places of_a(a.mesh.level_count > 0 ? first->level(0).edges.size() : 0),
      of_b(b.mesh.level_count > 0 ? second->level(0).edges.size() : 0);
  std::iota(of_a.begin(), of_a.end(), 0u);
  std::iota(of_b.begin(), of_b.end(), static_cast<std::uint32_t>(of_a.size()));
  for (int j = 0; j < a.mesh.level_count; ++j) {
    const LevelTopology &la = first->level(j), &lb = second->level(j);
    const std::size_t begin = out.mesh.positions.size(), edges = of_a.size() + of_b.size();
    out.mesh.positions.resize(begin + edges);
    out.kind.resize(begin + edges);
    put_level(a, la, of_a, begin, out);
    put_level(b, lb, of_b, begin, out);
    if (j + 1 == a.mesh.level_count) break;
    of_a = split(of_a, edges, 0, la.triangles.size());
    of_b = split(of_b, edges, la.triangles.size(), lb.triangles.size());
  }
  return out;
}

Result<KeptApart> part_kept(const Scan& scan, const Parameterisation& map, std::size_t triangles) {
  const Error bad{ErrorCode::kBadInput, "the pieces that are their own base are not the last ones",
                  0};
  const std::size_t all = scan.triangles.size(), base_all = map.base.triangles.size();
  if (triangles > all || triangles > base_all) return bad;
  const std::size_t faces = all - triangles, base_faces = base_all - triangles;
  std::uint32_t first = kNone, base_first = kNone;
  for (std::size_t i = 0; i < triangles; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      first = std::min(first, scan.triangles[faces + i][k]);
      base_first = std::min(base_first, map.base.triangles[base_faces + i][k]);
    }
  }
  KeptApart out;
  out.map = map;
  out.scan = out.kept = scan;
  out.kept.triangles.erase(out.kept.triangles.begin(),
                           out.kept.triangles.begin() + static_cast<std::ptrdiff_t>(faces));
  out.scan.triangles.resize(faces);
  for (Triangle& t : out.kept.triangles)
    for (std::uint32_t& v : t) v -= first;
  if (first > scan.positions.size() || base_first > map.base.scan_vertex.size() ||
      scan.positions.size() - first != map.base.scan_vertex.size() - base_first)
    return bad;
  out.kept.positions.erase(out.kept.positions.begin(), out.kept.positions.begin() + first);
  out.scan.positions.resize(first);
  out.map.point.resize(first);
  out.map.base.triangles.resize(base_faces);
  out.map.base.neighbors.resize(base_faces);
  out.map.base.scan_vertex.resize(base_first);
  if (!out.map.base.moved.empty()) out.map.base.moved.resize(base_first);
  for (const Triangle& t : out.scan.triangles)
    for (const std::uint32_t v : t)
      if (v >= first) return bad;
  for (std::size_t f = 0; f < base_faces; ++f)
    for (std::size_t k = 0; k < 3; ++k)
      if (out.map.base.triangles[f][k] >= base_first ||
          (out.map.base.neighbors[f][k] != kNone && out.map.base.neighbors[f][k] >= base_faces))
        return bad;
  for (const std::uint32_t v : out.map.base.scan_vertex)
    if (v >= first) return bad;
  for (const DomainPoint& p : out.map.point)
    if (p.face >= base_faces) return bad;
  return out;
}

}  // namespace nacre::remesh
