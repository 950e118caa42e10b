// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "metric/metric.h"
#include "remesh/remesh.h"

/// What the remesher's benchmarks measure of a result: all from the two surfaces, or counted by
/// hand, but where it says that the remesher's report is repeated.
namespace nacre::bench {

/// User and system time of this process so far.
[[nodiscard]] double cpu_seconds();

/// Of a mesh as a surface; of a scan after cleaning.
struct TopologyFacts {
  std::size_t pieces = 0, boundary_loops = 0;
  long long euler = 0;
  bool operator==(const TopologyFacts&) const = default;
  /// Summed over the pieces, boundary loops capped.
  [[nodiscard]] long long genus() const {
    return (2 * static_cast<long long>(pieces) - static_cast<long long>(boundary_loops) - euler) /
           2;
  }
  [[nodiscard]] std::string text() const;
};
[[nodiscard]] TopologyFacts facts_of(const remesh::CleanReport& clean);
[[nodiscard]] TopologyFacts facts_of_base(const SemiRegularMesh& mesh);

struct Health {
  metric::Comparison distance;  ///< raw scan against the finest level
  double normal_only = 0;       ///< share of all details, as the remesher reports
  double worst_level = 0;       ///< the least share of a level, as the remesher reports
  /// Per level 1 .. J: folds as the remesher reports, and as app::FoldCheck finds them; `opposed`
  /// is its looser count.
  std::vector<std::size_t> reported_folds, folds, opposed;
  TopologyFacts topology_in, topology_out;

  [[nodiscard]] double max_percent() const;  ///< two-sided maximum, % of the diagonal
  [[nodiscard]] std::size_t all_folds() const;
};

/// Errors   of cleaning, the topology or the measurement.
[[nodiscard]] Result<Health> measure_health(const Scan& scan, const remesh::Remesh& remesh,
                                            std::size_t samples);

}  // namespace nacre::bench
