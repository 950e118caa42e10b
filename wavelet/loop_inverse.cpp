// SPDX-License-Identifier: GPL-3.0-or-later
#include "wavelet/loop_inverse.h"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <string>

#include "wavelet/loop.h"

// READ ME FIRST. The even rule's matrix M is not symmetric, but falls apart into symmetric positive
// definite ones. A boundary vertex looks along the boundary only, so the boundary is solved first
// (diagonal 3/4, neighbours 1/8: dominant). For the interior, row v divided by its share β_v leaves
// M' = diag((1 - K β) / β) + A with A the adjacency of interior vertices. Every edge of A is in two
// triangles, and x y + y z + z x >= -(x² + y² + z²) / 2 on each, so A >= -diag(K) / 2 and M' is
// positive definite while K β < 2/3; Loop's largest K β is 39/64, at K = 2. With its diagonal as
// preconditioner the condition number is below 10 on every mesh.

namespace nacre::wavelet {
namespace {

constexpr double kRelativeResidual = 1e-12;  // of each pass; the second pass works on the residual
constexpr int kPasses = 2;
constexpr int kMaxIterations = 500;  // condition number 10 needs about 50

using Matrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;
using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3>;

/// The vertices of one of the two systems, and each vertex's row in it (kNone: in the other one).
struct Unknowns {
  std::vector<std::uint32_t> vertex;
  std::vector<std::uint32_t> row;
};

Unknowns select(const LoopNeighbours& neighbours, bool boundary) {
  Unknowns unknowns;
  const auto count = static_cast<std::uint32_t>(neighbours.count.size());
  unknowns.row.assign(count, kNone);
  for (std::uint32_t v = 0; v < count; ++v) {
    if (neighbours.boundary[v] != boundary || neighbours.count[v] == 0) continue;
    unknowns.row[v] = static_cast<std::uint32_t>(unknowns.vertex.size());
    unknowns.vertex.push_back(v);
  }
  return unknowns;
}

/// M' of the comment above, for one kind of vertex.
Matrix even_rule(const LevelTopology& level, const LoopNeighbours& neighbours,
                 const Unknowns& unknowns, bool boundary) {
  std::vector<Eigen::Triplet<double>> entries;
  for (std::uint32_t row = 0; row < unknowns.vertex.size(); ++row) {
    const double share = loop_share(neighbours, unknowns.vertex[row]);
    entries.emplace_back(row, row, 1.0 / share - neighbours.count[unknowns.vertex[row]]);
  }
  for (const Edge& edge : level.edges) {
    if (edge.is_boundary() != boundary) continue;
    const std::uint32_t a = unknowns.row[edge.vertex[0]], b = unknowns.row[edge.vertex[1]];
    if (a == kNone || b == kNone) continue;
    entries.emplace_back(a, b, 1.0);
    entries.emplace_back(b, a, 1.0);
  }
  const auto n = static_cast<Eigen::Index>(unknowns.vertex.size());
  Matrix matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

Result<void> solve_kind(const LevelTopology& level, const LoopNeighbours& neighbours,
                        std::span<const Vec3> moved, bool boundary, std::vector<Vec3>& positions) {
  const Unknowns unknowns = select(neighbours, boundary);
  const auto n = static_cast<Eigen::Index>(unknowns.vertex.size());
  if (n == 0) return {};
  const Matrix matrix = even_rule(level, neighbours, unknowns, boundary);
  Eigen::ConjugateGradient<Matrix, Eigen::Lower | Eigen::Upper> solver;
  solver.setTolerance(kRelativeResidual);
  solver.setMaxIterations(kMaxIterations);
  solver.compute(matrix);

  for (int pass = 0; pass < kPasses; ++pass) {
    // What the even rule still misses, vertex by vertex, in the same arithmetic as the decoder's.
    const std::vector<Vec3> image = loop_subdivide(level, positions);
    Columns residual(n, 3);
    for (Eigen::Index row = 0; row < n; ++row) {
      const std::uint32_t v = unknowns.vertex[static_cast<std::size_t>(row)];
      residual.row(row) = (moved[v] - image[v]).transpose() / loop_share(neighbours, v);
    }
    const Columns correction = solver.solve(residual);
    if (solver.info() != Eigen::Success) {
      return Error{
          ErrorCode::kNoConvergence,
          "Loop's even rule was not inverted in " + std::to_string(kMaxIterations) + " iterations",
          unknowns.vertex[0]};
    }
    for (Eigen::Index row = 0; row < n; ++row)
      positions[unknowns.vertex[static_cast<std::size_t>(row)]] += correction.row(row).transpose();
  }
  return {};
}

}  // namespace

Result<std::vector<Vec3>> invert_loop_even_rule(const LevelTopology& level,
                                                std::span<const Vec3> moved) {
  const LoopNeighbours neighbours = loop_neighbours(level);
  std::vector<Vec3> positions(moved.begin(), moved.end());
  for (const bool boundary : {true, false}) {
    if (const auto ok = solve_kind(level, neighbours, moved, boundary, positions); !ok)
      return ok.error();
  }
  return positions;
}

}  // namespace nacre::wavelet
