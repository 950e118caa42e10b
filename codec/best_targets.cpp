// SPDX-License-Identifier: GPL-3.0-or-later
//
// Read me first: the butterfly interpolates, so details taken from the mesh as it is make every
// level pass through points of the finest one. Where finer details will be zero, a level that
// passes *between* these points is nearer. Which details to keep is a sparse approximation:
// least |surface error|² + Σ cost · |detail|, over the details of all levels at once.
#include "codec/best_targets.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "wavelet/butterfly_mask.h"

namespace nacre::codec {
namespace {

/// What error along the surface counts, beside error across it: it keeps the vertices apart.
constexpr double kTangentialWeight = 0.15;
/// What a detail costs, as a share of the squared step, before its logarithm.
constexpr double kCost = 0.3;
/// Share of the level's own optimum that a round goes; levels overlap, so less than 1.
constexpr double kFirstRate = 0.12;

std::span<const Vec3> prefix(const Prepared& prepared, int level) {
  return std::span(prepared.positions).first(prepared.topology.level(level).vertex_count);
}

/// One third of the area of a level's triangles at each vertex.
std::vector<double> vertex_areas(const LevelTopology& level, std::span<const Vec3> p) {
  std::vector<double> areas(level.vertex_count, 0.0);
  for (const Triangle& t : level.triangles) {
    const double area = norm(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]])) / 6;
    for (const std::uint32_t v : t) areas[v] += area;
  }
  return areas;
}

void scale_to_mean_one(std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  if (!(sum > 0)) {
    std::fill(values.begin(), values.end(), 1.0);
    return;
  }
  const double scale = static_cast<double>(values.size()) / sum;
  for (double& v : values) v = std::max(v * scale, 0.01);
}

/// To the triangle's plane where its foot lies inside, else to its sides.
double squared_distance(const Vec3& p, const Triangle& t, std::span<const Vec3> points) {
  const Vec3 normal = cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]);
  const double square = dot(normal, normal);
  bool is_inside = square > 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 &a = points[t[k]], side = points[t[(k + 1) % 3]] - a, from = p - a;
    if (dot(cross(side, from), normal) < 0) is_inside = false;
    const double length = dot(side, side);
    const double along = length > 0 ? std::clamp(dot(from, side) / length, 0.0, 1.0) : 0.0;
    const Vec3 rest = from - along * side;
    least = std::min(least, dot(rest, rest));
  }
  if (!is_inside) return least;
  const double height = dot(p - points[t[0]], normal);
  return height * height / square;
}

/// The transpose of one level's prediction, with regular masks everywhere: vectors at the vertices
/// of level + 1 → at those of level, which are a prefix.
void transpose_predict(const LevelTopology& level, std::span<Vec3> g) {
  const std::uint32_t kept = level.vertex_count;
  for (std::uint32_t e = 0; e < level.edges.size(); ++e) {
    const Vec3 half = 0.5 * g[kept + e];
    g[level.edges[e].vertex[0]] += half;
    g[level.edges[e].vertex[1]] += half;
  }
  for (std::uint32_t f = 0; f < level.triangles.size(); ++f) {
    const Triangle& t = level.triangles[f];
    const Triangle& sides = level.triangle_edges[f];
    std::array<Vec3, 3> from;
    for (std::uint32_t k = 0; k < 3; ++k) {
      from[k] = level.edges[sides[k]].is_boundary() ? Vec3(Vec3::Zero()) : g[kept + sides[k]];
      g[t[(k + 2) % 3]] += 0.125 * from[k];
    }
    for (std::uint32_t k = 0; k < 3; ++k) {
      // The wing across side k serves the two other sides.
      const Vec3 v = -0.0625 * (from[(k + 1) % 3] + from[(k + 2) % 3]);
      const Edge& edge = level.edges[sides[k]];
      const auto [a, b] = edge.vertex;
      const std::uint32_t beyond = edge.face[0] == f ? edge.face[1] : edge.face[0];
      if (beyond == kNone) {
        g[a] += v;
        g[b] += v;
        g[t[(k + 2) % 3]] -= v;
      } else {
        const Triangle& o = level.triangles[beyond];
        g[o[0] ^ o[1] ^ o[2] ^ a ^ b] += v;
      }
    }
  }
}

}  // namespace

SurfaceWeights surface_weights(const Prepared& prepared) {
  const Topology& topology = prepared.topology;
  const int finest = topology.level_count();
  SurfaceWeights weights;
  weights.normals.assign(prepared.positions.size(), Vec3::Zero());
  const auto& p = prepared.positions;
  for (const Triangle& t : topology.level(finest).triangles) {
    const Vec3 normal = cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
    for (const std::uint32_t v : t) weights.normals[v] += normal;
  }
  for (Vec3& n : weights.normals) {
    const double length = norm(n);
    n = length > 0 ? Vec3(n / length) : Vec3(0, 0, 1);
  }
  weights.fan_begin.assign(p.size() + 1, 0);
  const auto& triangles = topology.level(finest).triangles;
  for (const Triangle& triangle : triangles)
    for (const std::uint32_t v : triangle) ++weights.fan_begin[v + 1];
  for (std::size_t v = 0; v < p.size(); ++v) weights.fan_begin[v + 1] += weights.fan_begin[v];
  weights.fans.resize(3 * triangles.size());
  std::vector<std::uint32_t> next(weights.fan_begin.begin(), weights.fan_begin.end() - 1);
  for (std::uint32_t f = 0; f < triangles.size(); ++f)
    for (const std::uint32_t v : triangles[f]) weights.fans[next[v]++] = f;
  for (int j = 0; j <= finest; ++j) {
    std::vector<double> areas = vertex_areas(topology.level(j), prefix(prepared, j));
    scale_to_mean_one(areas);
    const std::size_t kept = j == 0 ? 0 : topology.level(j - 1).vertex_count;
    weights.level_areas.emplace_back(areas.begin() + static_cast<std::ptrdiff_t>(kept),
                                     areas.end());
    if (j == finest) weights.areas = std::move(areas);
  }
  return weights;
}

double surface_error(const Prepared& prepared, const SurfaceWeights& weights,
                     std::span<const Vec3> positions) {
  const auto& triangles = prepared.topology.level(prepared.topology.level_count()).triangles;
  const double sum = deterministic_sum<double>(positions.size(), [&](std::size_t v) {
    const auto squared_to = [&](std::uint32_t other) {
      const Vec3 offset = positions[v] - prepared.positions[other];
      return dot(offset, offset);
    };
    // Vertices drift along the surface, so the nearest original vertex comes first, by descent.
    auto nearest = static_cast<std::uint32_t>(v);
    double least = squared_to(nearest);
    for (std::uint32_t from = kNone; from != nearest;) {
      from = nearest;
      for (std::uint32_t i = weights.fan_begin[from]; i < weights.fan_begin[from + 1]; ++i) {
        for (const std::uint32_t other : triangles[weights.fans[i]]) {
          const double square = squared_to(other);
          if (!(square < least)) continue;
          least = square;
          nearest = other;
        }
      }
    }
    for (std::uint32_t i = weights.fan_begin[nearest]; i < weights.fan_begin[nearest + 1]; ++i)
      least = std::min(
          least, squared_distance(positions[v], triangles[weights.fans[i]], prepared.positions));
    return weights.areas[v] * least;
  });
  return sum / static_cast<double>(positions.size());
}

Targets interpolating_targets(const Prepared& prepared) {
  Targets targets;
  std::size_t begin = 0;
  for (int j = 0; j <= prepared.topology.level_count(); ++j) {
    const std::size_t end = prepared.topology.level(j).vertex_count;
    targets.emplace_back(prepared.positions.begin() + static_cast<std::ptrdiff_t>(begin),
                         prepared.positions.begin() + static_cast<std::ptrdiff_t>(end));
    begin = end;
  }
  return targets;
}

namespace {

/// Iterated shrinkage with momentum [Beck2009], a step for every level by its gain.
class SparseSolver {
 public:
  SparseSolver(const Prepared& prepared, const SurfaceWeights& weights, double step,
               const std::vector<double>& gains);

  void run(int rounds);
  [[nodiscard]] Targets targets();

 private:
  /// The finest mesh of some details, into mesh_.
  void build(const std::vector<Vec3>& details);
  /// mesh_'s surface error, and its gradient by every detail, halved and turned, in gradient_.
  double differentiate();
  [[nodiscard]] double cost_of(const std::vector<Vec3>& details) const;
  /// last_ from ahead_ by one shrunk step along gradient_.
  void shrink(double rate);
  [[nodiscard]] std::uint32_t begin_of(int level) const {
    return level == 0 ? 0 : prepared_.topology.level(level - 1).vertex_count;
  }
  [[nodiscard]] double own_step(int level) const {
    return step_ / std::sqrt(gains_[static_cast<std::size_t>(level)]);
  }

  const Prepared& prepared_;
  const SurfaceWeights& weights_;
  double step_;
  const std::vector<double>& gains_;
  int levels_;
  wavelet::ButterflyMask mask_;
  // Details as vectors, in the order of the vertices; the base's are its positions.
  std::vector<Vec3> details_, ahead_, last_, directions_, mesh_, gradient_;
};

SparseSolver::SparseSolver(const Prepared& prepared, const SurfaceWeights& weights, double step,
                           const std::vector<double>& gains)
    : prepared_(prepared),
      weights_(weights),
      step_(step),
      gains_(gains),
      levels_(prepared.topology.level_count()),
      mask_(prepared.topology),
      mesh_(prepared.positions),
      gradient_(prepared.positions.size()) {
  details_ = prepared.pyramid.base_positions;
  directions_.resize(details_.size(), Vec3::Zero());
  for (int j = 0; j < levels_; ++j) {
    const auto& vectors = prepared.vectors[static_cast<std::size_t>(j)];
    details_.insert(details_.end(), vectors.begin(), vectors.end());
    for (const Frame& f : wavelet::predict(prepared.topology, j, prefix(prepared, j)).frames)
      directions_.push_back(f.normal);
  }
}

void SparseSolver::build(const std::vector<Vec3>& details) {
  std::copy_n(details.begin(), prepared_.topology.level(0).vertex_count, mesh_.begin());
  for (int j = 0; j < levels_; ++j) {
    const std::uint32_t kept = begin_of(j + 1);
    const std::uint32_t all = prepared_.topology.level(j + 1).vertex_count;
    mask_.predict(j, std::span<const Vec3>(mesh_).first(kept),
                  std::span(mesh_).subspan(kept, all - kept));
    for (std::uint32_t v = kept; v < all; ++v) mesh_[v] += details[v];
  }
}

double SparseSolver::differentiate() {
  parallel_for_each_index(mesh_.size(), [&](std::size_t i) {
    const Vec3 e = prepared_.positions[i] - mesh_[i];
    const Vec3& n = weights_.normals[i];
    gradient_[i] = weights_.areas[i] * (dot(n, e) * n + kTangentialWeight * e);
  });
  const double error = deterministic_sum<double>(mesh_.size(), [&](std::size_t i) {
    return dot(gradient_[i], prepared_.positions[i] - mesh_[i]);
  });
  for (int j = levels_ - 1; j >= 0; --j) {
    const LevelTopology& level = prepared_.topology.level(j);
    transpose_predict(level, std::span(gradient_).first(begin_of(j + 2)));
  }
  return error;
}

double SparseSolver::cost_of(const std::vector<Vec3>& details) const {
  double cost = 0;
  for (int j = 1; j <= levels_; ++j) {
    const double unit = own_step(j);
    const std::uint32_t begin = begin_of(j);
    cost += deterministic_sum<double>(begin_of(j + 1) - begin, [&](std::size_t i) {
      const double d = dot(directions_[begin + i], details[begin + i]);
      return d == 0 ? 0.0 : std::log1p(std::abs(d) / unit);
    });
  }
  return 2 * kCost * step_ * step_ * cost;
}

void SparseSolver::shrink(double rate) {
  for (int j = 0; j <= levels_; ++j) {
    const auto level = static_cast<std::size_t>(j);
    const std::uint32_t begin = begin_of(j);
    const double unit = own_step(j);
    parallel_for_each_index(weights_.level_areas[level].size(), [&](std::size_t i) {
      const std::size_t v = begin + i;
      const double stride = rate / (gains_[level] * weights_.level_areas[level][i]);
      if (j == 0) {
        last_[v] = ahead_[v] + gradient_[v] * stride;
        return;
      }
      const double d = dot(directions_[v], ahead_[v]);
      const double moved = d + stride * dot(directions_[v], gradient_[v]);
      // One more step costs the less, the larger the detail is already.
      const double threshold = stride * kCost * step_ * step_ / (unit + std::abs(moved));
      const double kept = std::max(std::abs(moved) - threshold, 0.0);
      last_[v] = ahead_[v] + directions_[v] * ((moved < 0 ? -kept : kept) - d);
    });
  }
}

void SparseSolver::run(int rounds) {
  ahead_ = last_ = details_;
  std::vector<Vec3> best = details_;
  double momentum = 1, rate = kFirstRate, before = 0, least = 0, first = 0;
  for (int round = 0; round < rounds; ++round) {
    build(ahead_);
    const double objective = differentiate() + cost_of(ahead_);
    if (round == 0) first = least = before = objective;
    if (!(objective <= 1.1 * first)) {  // too long a step for this mesh
      rate /= 2;
      momentum = 1;
      details_ = ahead_ = best;
      before = least;
      continue;
    }
    if (objective > before) momentum = 1;
    before = objective;
    if (objective < least) {
      least = objective;
      best = ahead_;
    }
    shrink(rate);
    const double next = (1 + std::sqrt(1 + 4 * momentum * momentum)) / 2;
    const double share = (momentum - 1) / next;
    momentum = next;
    parallel_for_each_index(details_.size(), [&](std::size_t i) {
      ahead_[i] = last_[i] + share * (last_[i] - details_[i]);
      details_[i] = last_[i];
    });
  }
  details_ = std::move(best);
}

Targets SparseSolver::targets() {
  build(details_);
  Targets targets = interpolating_targets(prepared_);
  for (int j = 0; j < levels_; ++j) {
    auto& level = targets[static_cast<std::size_t>(j)];
    std::copy_n(mesh_.begin() + begin_of(j), level.size(), level.begin());
  }
  return targets;
}

}  // namespace

Targets sparse_targets(const Prepared& prepared, const SurfaceWeights& weights, double step,
                       const std::vector<double>& gains, int rounds) {
  SparseSolver solver(prepared, weights, step, gains);
  solver.run(rounds);
  return solver.targets();
}

}  // namespace nacre::codec
