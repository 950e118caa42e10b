// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/relax.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/parallel.h"
#include "remesh/adjacency.h"
#include "remesh/chart.h"
#include "remesh/tips.h"
#include "remesh/untangle.h"

namespace nacre::remesh {
namespace {

using Vec2 = Eigen::Vector2d;

/// Neighbours of every scan vertex with their weights, in compressed rows.
struct Graph {
  std::vector<std::uint32_t> start, neighbor;
  std::vector<double> weight;
  std::vector<char> fixed;
};

double half_tangent(const Vec3& a, const Vec3& b) {
  // tan(angle / 2) = |a × b| / (|a||b| + a · b)
  const double below = a.norm() * b.norm() + a.dot(b);
  return below > 0 ? a.cross(b).norm() / below : 1e6;
}

/// Mean-value weights [Floater2003]: (tan(α/2) + tan(β/2)) / length.
Graph mean_value_graph(const Scan& scan, std::span<const Triangle> neighbors,
                       std::vector<char> fixed) {
  const auto n = static_cast<std::uint32_t>(scan.positions.size());
  const std::vector<std::uint32_t> first = face_of_vertex(scan.triangles, n);
  Graph graph;
  graph.fixed = std::move(fixed);
  graph.start.assign(n + 1, 0);
  Star star;
  for (std::uint32_t v = 0; v < n; ++v) {
    collect_star(scan.triangles, neighbors, v, first[v], star);
    if (star.boundary) graph.fixed[v] = 1;
    const std::size_t k = star.faces.size();
    for (std::size_t m = 0; m < star.ring.size(); ++m) {
      const Vec3 edge = scan.positions[star.ring[m]] - scan.positions[v];
      const auto to = [&](std::size_t i) -> Vec3 {
        return scan.positions[star.ring_at(i)] - scan.positions[v];
      };
      const double length = std::max(edge.norm(), 1e-300);
      const double sum =
          star.boundary ? 1.0
                        : half_tangent(edge, to(m + 1)) + half_tangent(edge, to((m + k - 1) % k));
      graph.neighbor.push_back(star.ring[m]);
      graph.weight.push_back(std::clamp(sum, 1e-3, 1e3) / length);
    }
    graph.start[v + 1] = static_cast<std::uint32_t>(graph.neighbor.size());
  }
  return graph;
}

/// Vertices in classes without edges inside, so that a class can be relaxed in parallel.
std::vector<std::vector<std::uint32_t>> color(const Graph& graph) {
  const std::size_t n = graph.fixed.size();
  std::vector<std::uint8_t> mine(n, 255);
  std::vector<std::vector<std::uint32_t>> classes;
  std::vector<char> taken;
  for (std::uint32_t v = 0; v < n; ++v) {
    if (graph.fixed[v]) continue;
    taken.assign(classes.size() + 1, 0);
    for (std::uint32_t i = graph.start[v]; i < graph.start[v + 1]; ++i)
      if (mine[graph.neighbor[i]] < taken.size()) taken[mine[graph.neighbor[i]]] = 1;
    const auto c =
        static_cast<std::size_t>(std::find(taken.begin(), taken.end(), 0) - taken.begin());
    if (c == classes.size()) classes.emplace_back();
    mine[v] = static_cast<std::uint8_t>(std::min<std::size_t>(c, 254));
    classes[c].push_back(v);
  }
  return classes;
}

class Relaxer {
 public:
  Relaxer(const Scan& scan, Parameterisation& p)
      : scan_(scan),
        point_(p.point),
        atlas_(p.base),
        neighbors_(
            side_neighbors(scan.triangles, static_cast<std::uint32_t>(scan.positions.size()))),
        graph_(mean_value_graph(scan, neighbors_, held_vertices(scan, p))),
        base_weight_(graph_.weight),
        classes_(color(graph_)) {}

  void sweep() {
    for (const auto& members : classes_)
      parallel_for_each_index(members.size(), [&](std::size_t i) { move(members[i]); });
  }

  /// w_ij = mean-value weight / sqrt(stretch_j), stretch = scan area per domain area around j.
  void reweight() {
    const std::size_t n = point_.size();
    std::vector<double> scan_area(n, 0), flat_area(n, 0);
    for (const Triangle& t : scan_.triangles) {
      const std::array<std::uint32_t, 3> faces = {point_[t[0]].face, point_[t[1]].face,
                                                  point_[t[2]].face};
      const auto chart = atlas_.common_chart(faces);
      if (!chart) continue;
      const Vec2 a = *chart->map(point_[t[0]]), b = *chart->map(point_[t[1]]),
                 c = *chart->map(point_[t[2]]);
      const double flat = std::abs((b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0]) / 2;
      const double area = (scan_.positions[t[1]] - scan_.positions[t[0]])
                              .cross(scan_.positions[t[2]] - scan_.positions[t[0]])
                              .norm() /
                          2;
      for (const std::uint32_t v : t) {
        scan_area[v] += area;
        flat_area[v] += flat;
      }
    }
    const double total_scan = std::accumulate(scan_area.begin(), scan_area.end(), 0.0);
    const double total_flat = std::accumulate(flat_area.begin(), flat_area.end(), 0.0);
    const double mean = total_scan / std::max(total_flat, 1e-300);
    parallel_for_each_index(n, [&](std::size_t v) {
      for (std::uint32_t i = graph_.start[v]; i < graph_.start[v + 1]; ++i) {
        const std::uint32_t j = graph_.neighbor[i];
        const double stretch = std::clamp(scan_area[j] / std::max(flat_area[j] * mean, 1e-300),
                                          kLeastStretch, 1 / kLeastStretch);
        graph_.weight[i] = base_weight_[i] / std::sqrt(stretch);
      }
    });
  }

  /// Boundary vertices of each base boundary edge: weight by arc length along the scan boundary.
  void spread_boundary() {
    const BaseMesh& base = atlas_.base();
    std::vector<std::uint32_t> next(point_.size(), kNone);
    for (std::size_t f = 0; f < scan_.triangles.size(); ++f)
      for (std::uint32_t k = 0; k < 3; ++k)
        if (neighbors_[f][k] == kNone)
          next[scan_.triangles[f][k]] = scan_.triangles[f][(k + 1) % 3];
    for (std::uint32_t f = 0; f < base.triangles.size(); ++f) {
      for (std::uint32_t k = 0; k < 3; ++k) {
        if (base.neighbors[f][k] != kNone) continue;
        spread_along(f, k, base.scan_vertex[base.triangles[f][k]],
                     base.scan_vertex[base.triangles[f][(k + 1) % 3]], next);
      }
    }
  }

 private:
  static constexpr double kLeastStretch = 1e-3;

  void spread_along(std::uint32_t face, std::uint32_t side, std::uint32_t from, std::uint32_t to,
                    const std::vector<std::uint32_t>& next) {
    double total = 0;
    for (std::uint32_t v = from; v != to; v = next[v])
      total += (scan_.positions[next[v]] - scan_.positions[v]).norm();
    double done = 0;
    for (std::uint32_t v = from; v != to; v = next[v]) {
      if (v != from) {
        const double t = total > 0 ? done / total : 0.5;
        point_[v] = {face, {}};
        point_[v].weight[side] = 1 - t;
        point_[v].weight[(side + 1) % 3] = t;
      }
      done += (scan_.positions[next[v]] - scan_.positions[v]).norm();
    }
  }

  void move(std::uint32_t v) {
    std::array<std::uint32_t, 64> faces;
    const std::uint32_t first = graph_.start[v], last = graph_.start[v + 1];
    if (last - first + 1 > faces.size()) return;
    std::size_t count = 0;
    faces[count++] = point_[v].face;
    for (std::uint32_t i = first; i < last; ++i) faces[count++] = point_[graph_.neighbor[i]].face;
    const auto chart = atlas_.common_chart({faces.data(), count});
    if (!chart) return;
    Vec2 sum = Vec2::Zero();
    double weight = 0;
    for (std::uint32_t i = first; i < last; ++i) {
      sum += graph_.weight[i] * *chart->map(point_[graph_.neighbor[i]]);
      weight += graph_.weight[i];
    }
    point_[v] = chart->unmap(sum / weight);
  }

  const Scan& scan_;
  std::vector<DomainPoint>& point_;
  Atlas atlas_;
  std::vector<Triangle> neighbors_;
  Graph graph_;
  std::vector<double> base_weight_;
  std::vector<std::vector<std::uint32_t>> classes_;
};

}  // namespace

std::size_t relax(const Scan& scan, Parameterisation& parameterisation, const RelaxOptions& options,
                  const RunContext& context) {
  Relaxer relaxer(scan, parameterisation);
  relaxer.spread_boundary();
  for (int round = 0; round < options.rounds && !context.cancelled(); ++round) {
    if (round > 0) relaxer.reweight();
    for (int i = 0; i < options.sweeps; ++i) relaxer.sweep();
    context.report("parameterisation", (round + 1.0) / options.rounds);
  }
  return untangle(scan, parameterisation);
}

}  // namespace nacre::remesh
