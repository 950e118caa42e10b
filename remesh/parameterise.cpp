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

namespace nacre::remesh {
namespace {

namespace smp = CGAL::Surface_mesh_parameterization;
using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
using VertexId = Mesh::Vertex_index;
using Places = Mesh::Property_map<VertexId, Kernel::Point_2>;
using Vec2 = Eigen::Vector2d;

constexpr double kLeastStretch = 1e-3;

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

/// Mean-value weights times a factor of the neighbour.
using MeanValue = smp::Mean_value_coordinates_parameterizer_3<Mesh, GivenBorder, FactorOnce>;
class WeightedMeanValue : public MeanValue {
 public:
  explicit WeightedMeanValue(std::span<const double> factor) : factor_(factor) {}

 protected:
  double compute_w_ij(const Mesh& mesh, VertexId v,
                      CGAL::Vertex_around_target_circulator<Mesh> neighbor) const override {
    const double weight = MeanValue::compute_w_ij(mesh, v, neighbor);
    const double length = std::sqrt(CGAL::squared_distance(mesh.point(v), mesh.point(*neighbor)));
    // Slivers: as in relaxation.
    const double tangents = weight * length;
    const double bounded = tangents > 1e-3 ? std::min(tangents, 1e3) : 1e-3;
    return bounded / std::max(length, 1e-300) * factor_[(*neighbor).idx()];
  }

 private:
  std::span<const double> factor_;
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
  Patcher(const Scan& scan, Parameterisation& map, bool stretch)
      : scan_(scan),
        point_(map.point),
        base_(map.base),
        atlas_(map.base),
        neighbors_(
            side_neighbors(scan.triangles, static_cast<std::uint32_t>(scan.positions.size()))),
        patch_(scan.triangles.size()),
        part_(scan.triangles.size()),
        stretch_(stretch) {}

  void solve_triangles(ParameteriseReport& report) {
    std::vector<std::uint32_t> patch_of_face(base_.triangles.size());
    std::vector<Atlas::Chart> charts;
    for (std::uint32_t f = 0; f < base_.triangles.size(); ++f) {
      patch_of_face[f] = f;
      charts.push_back(atlas_.triangle_chart(f));
    }
    solve_all(patch_of_face, charts, report);
  }

  /// Stars without a common triangle side by side, then the next lot.
  void solve_stars(ParameteriseReport& report) {
    const std::vector<std::uint32_t> lot = lots();
    const std::uint32_t lot_count = *std::max_element(lot.begin(), lot.end()) + 1;
    for (std::uint32_t i = 0; i < lot_count; ++i) {
      std::vector<std::uint32_t> patch_of_face(base_.triangles.size(), kNone);
      std::vector<std::uint32_t> patch_of_vertex(lot.size(), kNone);
      std::vector<Atlas::Chart> charts;
      for (std::uint32_t v = 0; v < lot.size(); ++v) {
        if (lot[v] != i) continue;
        patch_of_vertex[v] = static_cast<std::uint32_t>(charts.size());
        charts.push_back(atlas_.star_chart(v));
      }
      for (std::uint32_t f = 0; f < base_.triangles.size(); ++f)
        for (const std::uint32_t v : base_.triangles[f])
          if (lot[v] == i) patch_of_face[f] = patch_of_vertex[v];
      solve_all(patch_of_face, charts, report);
    }
  }

 private:
  /// A lot number for every base vertex, different at the two ends of a base edge.
  [[nodiscard]] std::vector<std::uint32_t> lots() const {
    std::vector<std::vector<std::uint32_t>> near(base_.scan_vertex.size());
    for (const Triangle& t : base_.triangles)
      for (std::size_t k = 0; k < 3; ++k) {
        near[t[k]].push_back(t[(k + 1) % 3]);
        near[t[k]].push_back(t[(k + 2) % 3]);
      }
    std::vector<std::uint32_t> lot(near.size(), kNone);
    for (std::uint32_t v = 0; v < near.size(); ++v) {
      std::uint32_t mine = 0;
      const auto taken = [&](std::uint32_t w) { return lot[w] == mine; };
      while (std::any_of(near[v].begin(), near[v].end(), taken)) ++mine;
      lot[v] = mine;
    }
    return lot;
  }

  void solve_all(std::span<const std::uint32_t> patch_of_face, std::span<const Atlas::Chart> charts,
                 ParameteriseReport& report) {
    std::vector<std::vector<std::uint32_t>> members(charts.size());
    for (std::uint32_t f = 0; f < scan_.triangles.size(); ++f) {
      const Triangle& t = scan_.triangles[f];
      const std::uint32_t patch = patch_of_face[point_[t[0]].face];
      const bool inside =
          patch == patch_of_face[point_[t[1]].face] && patch == patch_of_face[point_[t[2]].face];
      patch_[f] = inside ? patch : kNone;
      part_[f] = kNone;
      if (inside && patch != kNone) members[patch].push_back(f);
    }
    std::vector<Outcome> outcomes(charts.size());
    parallel_for_each_index(
        charts.size(), [&](std::size_t i) { outcomes[i] = solve(members[i], charts[i]); }, 1);
    for (const Outcome outcome : outcomes) {
      report.solved += outcome == Outcome::kSolved;
      report.not_disks += outcome == Outcome::kNotDisk;
      report.refused += outcome == Outcome::kRefused;
      report.empty += outcome == Outcome::kEmpty;
    }
  }

  Outcome solve(std::span<const std::uint32_t> members, const Atlas::Chart& chart) {
    const Part part = largest_part(members);
    if (part.triangles.empty()) return Outcome::kEmpty;
    if (!part.is_disk) return Outcome::kNotDisk;
    if (std::count(part.on_border.begin(), part.on_border.end(), 0) == 0) return Outcome::kEmpty;
    std::vector<Vec2> at;
    for (const std::uint32_t v : part.vertices) at.push_back(*chart.map(point_[v]));
    const std::vector<Vec2> before = at;
    if (!mean_value_places(part, at)) return Outcome::kRefused;
    for (std::size_t i = 0; i < at.size(); ++i)  // as they will be seen, if outside the chart
      if (!part.on_border[i]) at[i] = *chart.map(chart.unmap(at[i]));
    restore_turned(part, before, at);
    for (std::size_t i = 0; i < part.vertices.size(); ++i)
      if (at[i] != before[i]) point_[part.vertices[i]] = chart.unmap(at[i]);
    return Outcome::kSolved;
  }

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
    std::sort(part.vertices.begin(), part.vertices.end());
    part.vertices.erase(std::unique(part.vertices.begin(), part.vertices.end()),
                        part.vertices.end());
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
    const std::vector<double> factor = factors(part, at);
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
      WeightedMeanValue parameterizer(factor);
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

  /// 1 / sqrt(stretch): scan area for chart area around each vertex, against the patch's mean.
  [[nodiscard]] std::vector<double> factors(const Part& part, std::span<const Vec2> at) const {
    std::vector<double> factor(part.vertices.size(), 1.0);
    if (!stretch_) return factor;
    std::vector<double> scan_area(factor.size(), 0), flat_area(factor.size(), 0);
    double all_scan = 0, all_flat = 0;
    for (const Triangle& t : part.triangles) {
      const Vec3& a = scan_.positions[part.vertices[t[0]]];
      const double area = (scan_.positions[part.vertices[t[1]]] - a)
                              .cross(scan_.positions[part.vertices[t[2]]] - a)
                              .norm();
      const double flat = std::abs(doubled_area(t, at));
      all_scan += area;
      all_flat += flat;
      for (const std::uint32_t v : t) {
        scan_area[v] += area;
        flat_area[v] += flat;
      }
    }
    const double mean = all_scan / std::max(all_flat, 1e-300);
    for (std::size_t i = 0; i < factor.size(); ++i)
      factor[i] = 1 / std::sqrt(std::clamp(scan_area[i] / std::max(flat_area[i] * mean, 1e-300),
                                           kLeastStretch, 1 / kLeastStretch));
    return factor;
  }

  const Scan& scan_;
  std::vector<DomainPoint>& point_;
  const BaseMesh& base_;
  Atlas atlas_;
  std::vector<Triangle> neighbors_;
  std::vector<std::uint32_t> patch_;  // per scan triangle, in the lot at work
  std::vector<std::uint32_t> part_;   // per scan triangle: the first triangle of its connected part
  bool stretch_;
};

}  // namespace

ParameteriseReport parameterise(const Scan& scan, Parameterisation& parameterisation,
                                const ParameteriseOptions& options, const RunContext& context) {
  ParameteriseReport report;
  if (scan.triangles.empty() || options.passes <= 0) return report;
  Patcher patcher(scan, parameterisation, options.stretch);
  for (int pass = 0; pass < options.passes && !context.cancelled(); ++pass) {
    if (options.patches == ParameteriseOptions::Patches::kStars)
      patcher.solve_stars(report);
    else
      patcher.solve_triangles(report);
  }
  return report;
}

}  // namespace nacre::remesh
