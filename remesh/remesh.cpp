// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/remesh.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>

#include "remesh/choose_base.h"
#include "remesh/pierce.h"
#include "remesh/split_edges.h"
#include "remesh/surface_map.h"

namespace nacre::remesh {
namespace {

/// Notes what each step took.
class Stopwatch {
 public:
  explicit Stopwatch(std::vector<StageCost>& costs) : costs_(costs) {}
  void lap(const char* stage) {
    const auto now = std::chrono::steady_clock::now();
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    costs_.push_back({stage, std::chrono::duration<double>(now - last_).count(),
                      static_cast<std::size_t>(usage.ru_maxrss) * 1024});
    last_ = now;
  }

 private:
  std::vector<StageCost>& costs_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// No triangle is larger than it would be if this many equal ones covered the scan.
constexpr double kLeastTriangles = 20'000;

/// Enough splits for the semi-regular mesh to have about four triangles for each one of the scan:
/// from there on the remeshing error is below what any rate of interest leaves.
int default_levels(std::size_t scan_triangles, std::size_t base_triangles) {
  int levels = 1;
  while (levels < 10 && (base_triangles << (2 * levels)) < 3 * scan_triangles) ++levels;
  return levels;
}

void count_base_triangles(const CleanScan& cleaned, const BaseMesh& base,
                          std::vector<PieceReport>& pieces) {
  std::vector<std::uint32_t> piece_of_vertex(cleaned.scan.positions.size(), 0);
  for (std::size_t f = 0; f < cleaned.piece.size(); ++f)
    for (const std::uint32_t v : cleaned.scan.triangles[f]) piece_of_vertex[v] = cleaned.piece[f];
  for (const Triangle& t : base.triangles)
    ++pieces[piece_of_vertex[base.scan_vertex[t[0]]]].base_triangles;
}

}  // namespace

Result<Remesh> remesh(const Scan& scan, const Options& options, const RunContext& context) {
  if (options.levels < 0 || options.levels > 12)
    return Error{ErrorCode::kBadInput, "levels must be 0 .. 12", 0};
  if (options.base_vertices < 0)
    return Error{ErrorCode::kBadInput, "base vertices must not be negative", 0};
  if (!options.predict) return Error{ErrorCode::kBadInput, "a prediction is required", 0};
  Remesh out;
  Stopwatch watch(out.costs);
  auto cleaned = clean(scan, options.repair, options.small_extent);
  if (!cleaned) return cleaned.error();
  out.clean = cleaned->report;
  if (options.observer.cleaned) options.observer.cleaned(*cleaned);
  const std::size_t scan_triangles = cleaned->scan.triangles.size();
  const double side = side_for_count(cleaned->scan, kLeastTriangles);
  if (side == 0) return Error{ErrorCode::kGeometryRefused, "no triangle has an area", 0};
  split_long_edges(*cleaned, side, 4 * static_cast<std::size_t>(kLeastTriangles) + scan_triangles);
  split_chords(*cleaned);
  watch.lap("clean");

  const LineTree tree(cleaned->scan);
  const auto map = choose_base(cleaned->scan, tree, options.base_vertices, options.levels,
                               options.predict, context);
  if (!map) return map.error();
  if (options.observer.base) options.observer.base(cleaned->scan, *map);
  watch.lap("base mesh");

  const SurfaceMap surface_map(cleaned->scan, *map);
  PierceOptions pierce_options;
  pierce_options.levels = options.levels > 0
                              ? options.levels
                              : default_levels(scan_triangles, map->base.triangles.size());
  auto pierced = pierce(surface_map, *map, tree, options.predict, pierce_options, context);
  if (!pierced) return pierced.error();
  out.mesh = std::move(pierced->mesh);
  out.pieces = std::move(cleaned->pieces);
  count_base_triangles(*cleaned, map->base, out.pieces);
  out.bands = std::move(pierced->bands);
  if (options.observer.normal_mesh) options.observer.normal_mesh(out.mesh, pierced->kind);
  watch.lap("piercing");
  return out;
}

}  // namespace nacre::remesh
