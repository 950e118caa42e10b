// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/remesh_measure.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "app/files.h"
#include "app/folds.h"
#include "app/report.h"

namespace nacre::bench {
namespace {

double seconds(const timeval& t) {
  return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

std::uint32_t root_of(std::vector<std::uint32_t>& parent, std::uint32_t v) {
  while (parent[v] != v) v = parent[v] = parent[parent[v]];
  return v;
}

std::size_t piece_count(const LevelTopology& level) {
  std::vector<std::uint32_t> parent(level.vertex_count);
  std::iota(parent.begin(), parent.end(), 0U);
  std::size_t pieces = level.vertex_count;
  for (const Edge& edge : level.edges) {
    const std::uint32_t a = root_of(parent, edge.vertex[0]), b = root_of(parent, edge.vertex[1]);
    if (a == b) continue;
    parent[a] = b;
    --pieces;
  }
  return pieces;
}

Result<void> count_folds(const Scan& scan, const SemiRegularMesh& mesh, Health& health) {
  const auto cleaned = remesh::clean(scan);  // the scan itself may be inside out
  if (!cleaned) return cleaned.error();
  const auto check = app::FoldCheck::build(cleaned->scan);
  if (!check) return check.error();
  for (int level = 1; level <= mesh.level_count; ++level) {
    const auto triangles = app::to_triangles(mesh, level);
    if (!triangles) return triangles.error();
    const app::FoldCheck::Outcome outcome = check->check(*triangles);
    health.folds.push_back(outcome.folds);
    health.opposed.push_back(outcome.opposed);
  }
  return {};
}

}  // namespace

double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::string TopologyFacts::text() const {
  return fmt::format("{} pieces, {} loops, genus {}", pieces, boundary_loops, genus());
}

TopologyFacts facts_of(const remesh::CleanReport& clean) {
  TopologyFacts facts{clean.pieces, clean.boundary_loops, 0};
  facts.euler = 2 * static_cast<long long>(clean.pieces) - 2LL * clean.genus -
                static_cast<long long>(clean.boundary_loops);
  return facts;
}

TopologyFacts facts_of_base(const SemiRegularMesh& mesh) {
  const auto topology = Topology::build(mesh.base_triangles, mesh.base_vertex_count, 1);
  if (!topology) return {};
  const LevelTopology& base = topology->level(0);
  TopologyFacts facts;
  facts.pieces = piece_count(base);
  facts.euler = static_cast<long long>(base.vertex_count) -
                static_cast<long long>(base.edges.size()) +
                static_cast<long long>(base.triangles.size());
  // A manifold's boundary vertex has one boundary edge that leaves it.
  std::vector<std::uint32_t> next(base.vertex_count, kNone);
  for (const Edge& edge : base.edges)
    if (edge.is_boundary()) next[edge.vertex[0]] = edge.vertex[1];
  for (std::uint32_t v = 0; v < base.vertex_count; ++v) {
    if (next[v] == kNone) continue;
    ++facts.boundary_loops;
    for (std::uint32_t w = v; w != kNone;) w = std::exchange(next[w], kNone);
  }
  return facts;
}

double Health::max_percent() const {
  return 100 * app::max_error(distance) / distance.bbox_diagonal;
}

std::size_t Health::all_folds() const {
  std::size_t sum = 0;
  for (std::size_t i = 0; i < folds.size(); ++i) sum += std::max(folds[i], reported_folds[i]);
  return sum;
}

Result<Health> measure_health(const Scan& scan, const remesh::Remesh& remesh, std::size_t samples) {
  Health health;
  double normal = 0, all = 0;
  health.worst_level = 1;
  for (const remesh::BandReport& band : remesh.bands) {
    const auto vertices = static_cast<double>(band.vertices);
    const auto normal_only = static_cast<double>(band.normal_only);
    normal += normal_only;
    all += vertices;
    health.worst_level = std::min(health.worst_level, normal_only / std::max(vertices, 1.0));
    health.reported_folds.push_back(band.folded_triangles);
  }
  health.normal_only = normal / std::max(all, 1.0);
  health.topology_in = facts_of(remesh.clean);
  health.topology_out = facts_of_base(remesh.mesh);
  const auto triangles = app::to_triangles(remesh.mesh);
  if (!triangles) return triangles.error();
  const auto distance = metric::compare(scan, *triangles, {.samples = samples});
  if (!distance) return distance.error();
  health.distance = *distance;
  if (Result<void> ok = count_folds(scan, remesh.mesh, health); !ok) return ok.error();
  return health;
}

}  // namespace nacre::bench
