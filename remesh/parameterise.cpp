// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/parameterise.h"

#include <CGAL/Eigen_solver_traits.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_parameterization/Mean_value_coordinates_parameterizer_3.h>

#include <Eigen/SparseLU>
#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>

#include "base/parallel.h"
#include "remesh/adjacency.h"
#include "remesh/chart.h"
#include "remesh/indices_where.h"

namespace nacre::remesh {
namespace {

namespace smp = CGAL::Surface_mesh_parameterization;
using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
using VertexId = Mesh::Vertex_index;
using Places = Mesh::Property_map<VertexId, Kernel::Point_2>;
using Vec2 = Eigen::Vector2d;

/// CGAL solves for u, then for v, with the same matrix: one factorisation does for both.
class FactorOnce {
 public:
  using NT = double;
  using Matrix = CGAL::Eigen_sparse_matrix<double>;
  using Vector = CGAL::Eigen_vector<double>;

  bool linear_solver(const Matrix& a, const Vector& b, Vector& x, double& divisor) {
    divisor = 1;
    if (!factored_) lu_->compute(a.eigen_object());
    factored_ = true;
    if (lu_->info() != Eigen::Success) return false;
    x = lu_->solve(b.eigen_object());
    return lu_->info() == Eigen::Success;
  }

 private:
  using Lu = Eigen::SparseLU<Matrix::EigenType>;
  std::shared_ptr<Lu> lu_ = std::make_shared<Lu>();  // CGAL copies its solver
  bool factored_ = false;
};

/// The border stays where the places already are.
class GivenBorder {
 public:
  template <class VertexIndexMap, class DoneMap>
  smp::Error_code parameterize(const Mesh& mesh, Mesh::Halfedge_index border, Places,
                               VertexIndexMap, DoneMap done) const {
    for (const VertexId v : CGAL::vertices_around_face(border, mesh)) put(done, v, true);
    return smp::OK;
  }
  static bool is_border_convex() { return false; }
};

/// Mean-value weights, kept within bounds at slivers as in relaxation.
using MeanValue = smp::Mean_value_coordinates_parameterizer_3<Mesh, GivenBorder, FactorOnce>;
class BoundedMeanValue : public MeanValue {
 protected:
  double compute_w_ij(const Mesh& mesh, VertexId v,
                      CGAL::Vertex_around_target_circulator<Mesh> neighbor) const override {
    const double length = std::sqrt(CGAL::squared_distance(mesh.point(v), mesh.point(*neighbor)));
    const double tangents = MeanValue::compute_w_ij(mesh, v, neighbor) * length;
    const double bounded = tangents > 1e-3 ? std::min(tangents, 1e3) : 1e-3;  // NaN to the least
    return bounded / std::max(length, 1e-300);
  }
};

enum class Outcome : std::uint8_t { kSolved, kNotDisk, kRefused, kEmpty };

/// A connected part of the scan with its own vertex numbers.
struct Part {
  std::vector<std::uint32_t> vertices;  // of the scan, ascending
  std::vector<Triangle> triangles;      // local ids
  std::vector<char> on_border;
  bool is_disk = false;
};

double doubled_area(const Triangle& t, std::span<const Vec2> at) {
  const Vec2 u = at[t[1]] - at[t[0]], v = at[t[2]] - at[t[0]];
  return u[0] * v[1] - u[1] * v[0];
}

/// Moves the corners of triangles that the new places turn over back to where they were, until no
/// triangle is turned over that was not so before. It ends: each round moves a corner for good.
///
/// Mean-value coordinates are only sure to turn nothing over in a convex border, and the border of
/// a patch is as jagged as the scan's triangles.
void restore_turned(const Part& part, std::span<const Vec2> before, std::span<Vec2> at) {
  for (bool changed = true; changed;) {
    changed = false;
    for (const Triangle& t : part.triangles) {
      if (doubled_area(t, at) > 0 || !(doubled_area(t, before) > 0)) continue;
      for (const std::uint32_t v : t) at[v] = before[v];
      changed = true;
    }
  }
}

class Patcher {
 public:
  Patcher(const Scan& scan, Parameterisation& map)
      : scan_(scan),
        point_(map.point),
        atlas_(map.base),
        neighbors_(
            side_neighbors(scan.triangles, static_cast<std::uint32_t>(scan.positions.size()))),
        patch_(scan.triangles.size(), kNone),
        part_(scan.triangles.size(), kNone),
        members_(map.base.triangles.size()) {
    for (std::uint32_t f = 0; f < scan.triangles.size(); ++f) {
      const Triangle& t = scan.triangles[f];
      const std::uint32_t face = point_[t[0]].face;
      if (point_[t[1]].face != face || point_[t[2]].face != face) continue;
      patch_[f] = face;
      members_[face].push_back(f);
    }
  }

  [[nodiscard]] std::size_t patch_count() const { return members_.size(); }

  /// Different patches may be solved side by side: each has its own triangles and inner vertices,
  /// and none moves a border.
  Outcome solve(std::uint32_t patch) {
    const Part part = largest_part(members_[patch]);
    if (part.triangles.empty()) return Outcome::kEmpty;
    if (!part.is_disk) return Outcome::kNotDisk;
    if (std::count(part.on_border.begin(), part.on_border.end(), 0) == 0) return Outcome::kEmpty;
    const Atlas::Chart chart = atlas_.triangle_chart(patch);
    std::vector<Vec2> before;
    for (const std::uint32_t v : part.vertices) before.push_back(*chart.map(point_[v]));
    std::vector<Vec2> at = before;
    if (!mean_value_places(part, at)) return Outcome::kRefused;
    for (std::size_t i = 0; i < at.size(); ++i)  // as they will be seen, if outside the triangle
      if (!part.on_border[i]) at[i] = *chart.map(chart.unmap(at[i]));
    restore_turned(part, before, at);
    for (std::size_t i = 0; i < at.size(); ++i)
      if (at[i] != before[i]) point_[part.vertices[i]] = chart.unmap(at[i]);
    return Outcome::kSolved;
  }

 private:
  [[nodiscard]] Part largest_part(std::span<const std::uint32_t> members) {
    std::vector<std::uint32_t> best, faces;
    for (const std::uint32_t seed : members) {
      if (part_[seed] != kNone) continue;
      faces.assign(1, seed);
      part_[seed] = seed;
      for (std::size_t i = 0; i < faces.size(); ++i) {
        for (const std::uint32_t next : neighbors_[faces[i]]) {
          if (next == kNone || patch_[next] != patch_[seed] || part_[next] != kNone) continue;
          part_[next] = seed;
          faces.push_back(next);
        }
      }
      if (faces.size() > best.size()) best = faces;
    }
    return part_of(best);
  }

  [[nodiscard]] Part part_of(std::span<const std::uint32_t> faces) const {
    Part part;
    for (const std::uint32_t f : faces)
      part.vertices.insert(part.vertices.end(), scan_.triangles[f].begin(),
                           scan_.triangles[f].end());
    make_unique(part.vertices);
    const std::size_t n = part.vertices.size();
    std::vector<std::uint32_t> next(n, kNone);
    part.on_border.assign(n, 0);
    std::size_t sides = 0;
    bool pinched = false;
    for (const std::uint32_t f : faces) {
      Triangle t{};
      for (std::size_t k = 0; k < 3; ++k)
        t[k] = static_cast<std::uint32_t>(
            std::lower_bound(part.vertices.begin(), part.vertices.end(), scan_.triangles[f][k]) -
            part.vertices.begin());
      part.triangles.push_back(t);
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t across = neighbors_[f][k];
        if (across != kNone && part_[across] == part_[f]) continue;
        pinched |= next[t[k]] != kNone;
        next[t[k]] = t[(k + 1) % 3];
        part.on_border[t[k]] = 1;
        ++sides;
      }
    }
    if (pinched || sides == 0) return part;
    // Connected, one fan at every vertex, one border, and by Euler's formula no handle: a disk.
    const auto start = static_cast<std::uint32_t>(
        std::find(part.on_border.begin(), part.on_border.end(), 1) - part.on_border.begin());
    std::size_t length = 1;
    for (std::uint32_t v = next[start]; v != start; v = next[v]) ++length;
    part.is_disk = length == sides && 2 * n + 2 * faces.size() == 3 * faces.size() + sides + 2;
    return part;
  }

  /// Moves the places of the inner vertices; false if there is no solution.
  [[nodiscard]] bool mean_value_places(const Part& part, std::vector<Vec2>& at) const {
    Mesh mesh;
    for (const std::uint32_t v : part.vertices) {
      const Vec3& p = scan_.positions[v];
      mesh.add_vertex({p[0], p[1], p[2]});
    }
    for (const Triangle& t : part.triangles)
      if (mesh.add_face(VertexId(t[0]), VertexId(t[1]), VertexId(t[2])) == Mesh::null_face())
        return false;
    Places places = mesh.add_property_map<VertexId, Kernel::Point_2>("v:place").first;
    auto done = mesh.add_property_map<VertexId, bool>("v:done", false).first;
    Mesh::Halfedge_index border;
    for (std::uint32_t i = 0; i < at.size(); ++i) {
      places[VertexId(i)] = {at[i][0], at[i][1]};
      if (part.on_border[i] && !border.is_valid()) border = mesh.halfedge(VertexId(i));
    }
    // A border vertex of Surface_mesh keeps a border halfedge that ends in it.
    if (!border.is_valid() || !mesh.is_border(border)) return false;
    try {
      BoundedMeanValue parameterizer;
      const auto index = get(boost::vertex_index, mesh);
      if (parameterizer.parameterize(mesh, border, places, index, done) != smp::OK) return false;
    } catch (const std::exception&) {  // CGAL's checks, in builds that have them
      return false;
    }
    for (std::uint32_t i = 0; i < at.size(); ++i) {
      if (part.on_border[i]) continue;
      at[i] = {places[VertexId(i)].x(), places[VertexId(i)].y()};
      if (!at[i].allFinite()) return false;
    }
    return true;
  }

  const Scan& scan_;
  std::vector<DomainPoint>& point_;
  Atlas atlas_;
  std::vector<Triangle> neighbors_;
  std::vector<std::uint32_t> patch_;  // per scan triangle: the base triangle it lies in, or kNone
  std::vector<std::uint32_t> part_;   // per scan triangle: the first triangle of its connected part
  std::vector<std::vector<std::uint32_t>> members_;  // per base triangle
};

}  // namespace

ParameteriseReport parameterise(const Scan& scan, Parameterisation& parameterisation,
                                const RunContext& context) {
  Patcher patcher(scan, parameterisation);
  std::vector<Outcome> outcomes(patcher.patch_count());
  parallel_for_each_index(
      outcomes.size(),
      [&](std::size_t i) {
        outcomes[i] =
            context.cancelled() ? Outcome::kRefused : patcher.solve(static_cast<std::uint32_t>(i));
      },
      1);
  ParameteriseReport report;
  for (const Outcome outcome : outcomes) {
    report.solved += outcome == Outcome::kSolved;
    report.not_disks += outcome == Outcome::kNotDisk;
    report.refused += outcome == Outcome::kRefused;
    report.empty += outcome == Outcome::kEmpty;
  }
  return report;
}

}  // namespace nacre::remesh
