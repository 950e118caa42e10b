// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/collapse_edges.h"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include <exception>
#include <string>

#include "remesh/cgal_mesh.h"
#include "remesh/simplify.h"

namespace nacre::remesh {
namespace {

using Point = CGAL::Simple_cartesian<double>::Point_3;
using Mesh = CGAL::Surface_mesh<Point>;
using PieceOf = Mesh::Property_map<Mesh::Vertex_index, std::uint32_t>;

/// Stops at a number of vertices, or when the run is to stop.
class StopAtVertices {
 public:
  StopAtVertices(const Mesh& mesh, int vertices, const RunContext& context)
      : mesh_(mesh), vertices_(static_cast<std::size_t>(vertices)), context_(context) {}
  template <class Profile>
  bool operator()(double, const Profile&, std::size_t, std::size_t) const {
    return mesh_.number_of_vertices() <= vertices_ || context_.cancelled();
  }

 private:
  const Mesh& mesh_;
  std::size_t vertices_;
  const RunContext& context_;
};

/// No mesh if two triangles have the same directed side, which no clean scan has.
Result<Mesh> to_cgal(const CleanScan& cleaned) {
  Mesh mesh;
  mesh.reserve(static_cast<Mesh::size_type>(cleaned.scan.positions.size()),
               static_cast<Mesh::size_type>(cleaned.scan.triangles.size() * 3 / 2),
               static_cast<Mesh::size_type>(cleaned.scan.triangles.size()));
  for (const Vec3& p : cleaned.scan.positions) mesh.add_vertex(Point(p[0], p[1], p[2]));
  const PieceOf piece = mesh.add_property_map<Mesh::Vertex_index, std::uint32_t>("v:piece").first;
  for (std::size_t f = 0; f < cleaned.scan.triangles.size(); ++f) {
    const auto& [a, b, c] = cleaned.scan.triangles[f];
    if (mesh.add_face(Mesh::Vertex_index(a), Mesh::Vertex_index(b), Mesh::Vertex_index(c)) ==
        Mesh::null_face())
      return Error{ErrorCode::kNoConvergence, "CGAL takes no such mesh", f};
    for (const std::uint32_t v : cleaned.scan.triangles[f])
      piece[Mesh::Vertex_index(v)] = cleaned.piece[f];
  }
  return mesh;
}

/// Replaces scan and piece.
void from_cgal(const Mesh& mesh, CleanScan& cleaned) {
  const Vec3 origin = cleaned.scan.origin;
  cleaned.scan = scan_of(mesh);
  cleaned.scan.origin = origin;
  const PieceOf piece = mesh.property_map<Mesh::Vertex_index, std::uint32_t>("v:piece").first;
  cleaned.piece.clear();
  for (const auto f : mesh.faces())
    cleaned.piece.push_back(piece[*mesh.vertices_around_face(mesh.halfedge(f)).begin()]);
}

/// Replaces scan and piece by a base mesh of the scan.
void keep_vertices(const BaseMesh& base, CleanScan& cleaned) {
  std::vector<std::uint32_t> piece_of(cleaned.scan.positions.size());
  for (std::size_t f = 0; f < cleaned.piece.size(); ++f)
    for (const std::uint32_t v : cleaned.scan.triangles[f]) piece_of[v] = cleaned.piece[f];
  std::vector<Vec3> positions;
  for (const std::uint32_t v : base.scan_vertex) positions.push_back(cleaned.scan.positions[v]);
  cleaned.piece.clear();
  for (const Triangle& t : base.triangles)
    cleaned.piece.push_back(piece_of[base.scan_vertex[t[0]]]);
  cleaned.scan.positions = std::move(positions);
  cleaned.scan.triangles = base.triangles;
}

/// So many times the vertices asked for err little against so few.
constexpr int kRoughShare = 4;

}  // namespace

Result<CleanScan> collapse_edges(CleanScan cleaned, int vertices, const RunContext& context) {
  Result<Mesh> mesh = to_cgal(cleaned);
  if (!mesh) return mesh.error();
  try {
    CGAL::Surface_mesh_simplification::edge_collapse(*mesh,
                                                     StopAtVertices(*mesh, vertices, context));
  } catch (const std::exception& e) {
    return Error{ErrorCode::kNoConvergence, std::string("collapsing edges failed: ") + e.what(), 0};
  }
  if (context.cancelled()) return Error{ErrorCode::kCancelled, "interrupted", 0};
  from_cgal(*mesh, cleaned);
  return cleaned;
}

Result<CleanScan> collapse_edges_quickly(CleanScan cleaned, int vertices,
                                         const RunContext& context) {
  if (cleaned.scan.positions.size() > 2 * kRoughShare * static_cast<std::size_t>(vertices)) {
    SimplifyOptions options;
    options.base_vertices = kRoughShare * vertices;
    options.chords = false;
    const auto map = simplify(cleaned.scan, options, {}, context);
    if (!map) return map.error();
    keep_vertices(map->base, cleaned);
  }
  return collapse_edges(std::move(cleaned), vertices, context);
}

}  // namespace nacre::remesh
