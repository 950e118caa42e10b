// SPDX-License-Identifier: GPL-3.0-or-later
//
// Read me first: the butterfly interpolates, so details taken from the mesh as it is make every
// level pass through points of the finest one. Where finer details will be zero, a level that
// passes *between* these points is nearer. Which details to keep is a sparse approximation:
// least |surface error|² + Σ cost · |detail|, over the details of all levels at once.
#include "codec/best_targets.h"

#include <algorithm>
#include <cmath>

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

std::vector<Vec3> target_normals(const Topology& topology, const Targets& targets) {
  std::vector<Vec3> surface;
  for (const auto& level : targets) surface.insert(surface.end(), level.begin(), level.end());
  return surface_normals(topology, surface);
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
  for (int j = 1; j <= levels_; ++j) {
    const auto level = static_cast<std::size_t>(j);
    const std::uint32_t begin = begin_of(j);
    const double unit = own_step(j);
    parallel_for_each_index(weights_.level_areas[level].size(), [&](std::size_t i) {
      const std::size_t v = begin + i;
      const double stride = rate / (gains_[level] * weights_.level_areas[level][i]);
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
