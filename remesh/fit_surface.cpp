// SPDX-License-Identifier: GPL-3.0-or-later
//
// Read me first: in rounds, samples of each surface find their nearest points on the other one;
// what each finds is a plane through it, square to the way there, and the vertices go to where the
// sum of the squared distances from these planes is least.
#include "remesh/fit_surface.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/parallel.h"
#include "remesh/pierce.h"

namespace nacre::remesh {
namespace {

constexpr int kRounds = 6;
/// Samples of each surface for a triangle of the mesh, and most of them.
constexpr std::size_t kSamplesPerTriangle = 20;
constexpr std::size_t kMostSamples = 200'000;
/// What staying counts against the samples of a triangle, in the mean and at least: it holds what
/// nothing else holds.
constexpr double kStay = 1e-3, kLeastStay = 1e-9;
/// Nearer than this share of the largest coordinate a surface has been reached.
constexpr double kReached = 1e-13;
/// Least cosine between a triangle's normal before and after a round.
constexpr double kLeastCosine = 0.7;

Eigen::Index first_row(std::uint32_t vertex) { return 3 * static_cast<Eigen::Index>(vertex); }

Vec3 normal_of(std::span<const Vec3> p, const Triangle& t) {
  return (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]);
}

bool has_area(const Scan& scan) {
  return std::any_of(scan.triangles.begin(), scan.triangles.end(),
                     [&](const Triangle& t) { return normal_of(scan.positions, t).norm() > 0; });
}

struct Sample {
  SurfacePoint at;
  Vec3 place;
};

/// `count` points spread evenly by area, in the order of the triangles.
std::vector<Sample> samples_of(const Scan& scan, std::size_t count) {
  std::vector<double> until;
  double area = 0;
  for (const Triangle& t : scan.triangles)
    until.push_back(area += normal_of(scan.positions, t).norm());
  std::vector<Sample> out;
  std::size_t f = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double at = area * (static_cast<double>(i) + 0.5) / static_cast<double>(count);
    while (f + 1 < until.size() && until[f] < at) ++f;
    // Kronecker's sequence of the plastic number fills the triangle, folded at its diagonal.
    double u = std::fmod(0.5 + 0.7548776662466927 * static_cast<double>(i), 1.0);
    double v = std::fmod(0.5 + 0.5698402909980532 * static_cast<double>(i), 1.0);
    if (u + v > 1) {
      u = 1 - u;
      v = 1 - v;
    }
    const SurfacePoint p{static_cast<std::uint32_t>(f), {1 - u - v, u, v}};
    out.push_back({p, position_of(p, scan.triangles, scan.positions)});
  }
  return out;
}

class Fitter {
 public:
  Fitter(const Scan& scan, Scan& mesh) : scan_(scan), tree_(scan), mesh_(mesh) {
    samples_ =
        samples_of(scan, std::min(kMostSamples, kSamplesPerTriangle * mesh.triangles.size()));
  }
  void run(const RunContext& context);

 private:
  /// A sample's residual along `direction`, of the mesh's point from what it should be at.
  struct Pull {
    SurfacePoint at;
    Vec3 direction = Vec3::Zero();
    double off = 0;
  };
  /// Makes the pulls. The larger of the sums of squares of the two ways.
  double look();
  /// Of the least squares, lower triangle only; adds to the right side.
  [[nodiscard]] std::vector<Eigen::Triplet<double>> equations(Eigen::VectorXd& right) const;
  /// False if the equations cannot be solved.
  bool move();

  const Scan& scan_;
  double least_ = 0;  // distance that says where to
  LineTree tree_;
  Scan& mesh_;
  std::vector<Sample> samples_;                // of the scan
  std::array<double, 2> shares_ = {0.5, 0.5};  // that the two count with
  std::vector<Pull> pulls_;                    // of the scan's samples, then of the mesh's
};

Vec3 direction_of(const Vec3& way, const Vec3& normal, double least) {
  const double length = way.norm();
  if (length > least) return way / length;
  const double n = normal.norm();
  return n > 0 ? Vec3(normal / n) : Vec3(Vec3::Zero());
}

double Fitter::look() {
  const LineTree tree(mesh_);
  const std::vector<Sample> own = samples_of(mesh_, samples_.size());
  pulls_.resize(samples_.size() + own.size());
  parallel_for_each_index(samples_.size(), [&](std::size_t i) {
    Pull& pull = pulls_[i];
    pull.at = tree.nearest(samples_[i].place);
    const Vec3 way = position_of(pull.at, mesh_.triangles, mesh_.positions) - samples_[i].place;
    pull.direction =
        direction_of(way, normal_of(mesh_.positions, mesh_.triangles[pull.at.face]), least_);
    pull.off = pull.direction.dot(way);
  });
  parallel_for_each_index(own.size(), [&](std::size_t i) {
    Pull& pull = pulls_[samples_.size() + i];
    pull.at = own[i].at;
    const SurfacePoint there = tree_.nearest(own[i].place);
    const Vec3 way = own[i].place - position_of(there, scan_.triangles, scan_.positions);
    pull.direction =
        direction_of(way, normal_of(scan_.positions, scan_.triangles[there.face]), least_);
    pull.off = pull.direction.dot(way);
  });
  std::array<double, 2> sums{};
  for (std::size_t i = 0; i < pulls_.size(); ++i)
    sums[i < samples_.size() ? 0 : 1] += pulls_[i].off * pulls_[i].off;
  const double both = sums[0] + sums[1];
  for (std::size_t k = 0; k < 2; ++k) shares_[k] = both > 0 ? sums[k] / both : 0.5;
  return std::max(sums[0], sums[1]);
}

std::vector<Eigen::Triplet<double>> Fitter::equations(Eigen::VectorXd& right) const {
  using Block = Eigen::Matrix<double, 9, 9>;
  std::vector<Block> blocks(mesh_.triangles.size(), Block(Block::Zero()));
  for (std::size_t s = 0; s < pulls_.size(); ++s) {
    const Pull& pull = pulls_[s];
    const double share = shares_[s < samples_.size() ? 0 : 1];
    Eigen::Matrix<double, 9, 1> row;
    for (int a = 0; a < 3; ++a)
      row.segment<3>(3 * a) = pull.at.weight[static_cast<std::size_t>(a)] * pull.direction;
    blocks[pull.at.face] += share * row * row.transpose();
    for (int a = 0; a < 3; ++a)
      right.segment<3>(first_row(mesh_.triangles[pull.at.face][static_cast<std::size_t>(a)])) -=
          share * pull.off * row.segment<3>(3 * a);
  }
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(blocks.size() * 45);
  for (std::size_t f = 0; f < blocks.size(); ++f) {
    const Triangle& t = mesh_.triangles[f];
    for (int i = 0; i < 9; ++i) {
      const Eigen::Index row = first_row(t[static_cast<std::size_t>(i / 3)]) + i % 3;
      for (int k = 0; k < 9; ++k) {
        const Eigen::Index column = first_row(t[static_cast<std::size_t>(k / 3)]) + k % 3;
        const double stay = i == k ? kStay * blocks[f].trace() / 9 + kLeastStay : 0;
        if (column <= row) entries.emplace_back(row, column, blocks[f](i, k) + stay);
      }
    }
  }
  return entries;
}

bool Fitter::move() {
  const Eigen::Index n = first_row(static_cast<std::uint32_t>(mesh_.positions.size()));
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
  const std::vector<Eigen::Triplet<double>> entries = equations(right);
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(matrix);
  if (solver.info() != Eigen::Success) return false;
  const Eigen::VectorXd moved = solver.solve(right);
  if (!moved.allFinite()) return false;
  std::vector<Vec3> places = mesh_.positions;
  for (std::uint32_t v = 0; v < places.size(); ++v) places[v] += moved.segment<3>(first_row(v));
  // Vertices whose triangles would turn over stay, and so may others then.
  for (bool any = true; any;) {
    any = false;
    for (const Triangle& t : mesh_.triangles) {
      const Vec3 before = normal_of(mesh_.positions, t), after = normal_of(places, t);
      if (before.dot(after) >= kLeastCosine * before.norm() * after.norm()) continue;
      for (const std::uint32_t v : t) {
        any = any || places[v] != mesh_.positions[v];
        places[v] = mesh_.positions[v];
      }
    }
  }
  mesh_.positions = std::move(places);
  return true;
}

void Fitter::run(const RunContext& context) {
  double least = look();
  std::vector<Vec3> best = mesh_.positions;
  for (int round = 0; round < kRounds && !context.cancelled() && move(); ++round) {
    const double now = look();
    if (now >= least) continue;  // the worse side counts more in the next round
    least = now;
    best = mesh_.positions;
  }
  mesh_.positions = std::move(best);
}

}  // namespace

void fit_surface(const Scan& scan, Scan& mesh, const RunContext& context) {
  if (!has_area(scan) || !has_area(mesh)) return;
  Fitter(scan, mesh).run(context);
}

}  // namespace nacre::remesh
