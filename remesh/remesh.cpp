// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/remesh.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>

#include "remesh/adjacency.h"
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

/// Nor has the finest mesh fewer than this: creases come out a level later than curved parts.
constexpr std::size_t kLeastFineTriangles = 160'000;

/// Enough splits for the semi-regular mesh to have about four triangles for each one of the scan:
/// from there on the remeshing error is below what any rate of interest leaves.
int default_levels(std::size_t scan_triangles, std::size_t base_triangles) {
  const std::size_t least = std::max(scan_triangles * 5 / 2, kLeastFineTriangles);
  int levels = 1;
  while (levels < 10 && (base_triangles << (2 * levels)) < least) ++levels;
  return levels;
}

/// A scan that cannot be simplified to less than this share of its vertices stays as it is.
constexpr double kLeastGain = 0.5;

/// The scan as its own base mesh: new vertices are the middles of edges, which is exact.
Result<Pierced> kept_as_it_is(const Scan& scan, int levels) {
  const auto vertices = static_cast<std::uint32_t>(scan.positions.size());
  const auto topology = Topology::build(scan.triangles, vertices, levels);
  if (!topology) return topology.error();
  Pierced out;
  out.mesh = {scan.triangles, vertices, levels, scan.positions, scan.origin};
  out.kind.assign(vertices, 0);
  out.folds.assign(scan.triangles.size(), 0);
  auto& positions = out.mesh.positions;
  for (int level = 0; level < levels; ++level) {
    for (const Edge& e : topology->level(level).edges) {
      positions.push_back((positions[e.vertex[0]] + positions[e.vertex[1]]) / 2);
      out.kind.push_back(e.is_boundary() ? 1 : 2);
    }
    out.bands.push_back({topology->level(level).edges.size(), 0, 0});
  }
  return out;
}

/// The identity, for who wants to look at it.
Parameterisation identity(const Scan& scan) {
  Parameterisation map;
  const auto vertices = static_cast<std::uint32_t>(scan.positions.size());
  map.base.triangles = scan.triangles;
  map.base.neighbors = side_neighbors(scan.triangles, vertices);
  map.point.resize(vertices);
  for (std::uint32_t v = 0; v < vertices; ++v) map.base.scan_vertex.push_back(v);
  for (std::uint32_t f = 0; f < scan.triangles.size(); ++f) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      DomainPoint corner{f, {}};
      corner.weight[k] = 1;
      map.point[scan.triangles[f][k]] = corner;
    }
  }
  return map;
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
  CleanScan whole;
  if (scan_triangles < kLeastTriangles) whole = *cleaned;
  const double side = side_for_count(cleaned->scan, kLeastTriangles);
  if (side == 0) return Error{ErrorCode::kGeometryRefused, "no triangle has an area", 0};
  split_long_edges(*cleaned, side, 4 * static_cast<std::size_t>(kLeastTriangles) + scan_triangles);
  split_chords(*cleaned);
  watch.lap("clean");

  const LineTree tree(cleaned->scan);
  auto map = choose_base(cleaned->scan, tree, options.base_vertices, options.levels,
                         options.predict, context);
  if (!map) return map.error();
  PierceOptions pierce_options;
  pierce_options.levels = options.levels > 0
                              ? options.levels
                              : default_levels(scan_triangles, map->base.triangles.size());
  const bool keep = options.base_vertices == 0 && !whole.scan.triangles.empty() &&
                    static_cast<double>(map->base.scan_vertex.size()) >
                        kLeastGain * static_cast<double>(whole.scan.positions.size());
  if (keep) {
    *cleaned = whole;
    map = identity(cleaned->scan);
    for (PieceReport& piece : cleaned->pieces)
      piece.fallback =
          "its own triangles are the base: the scan cannot be simplified to half of its vertices";
  }
  if (options.observer.base) options.observer.base(cleaned->scan, *map);
  watch.lap("base mesh");

  auto pierced = keep ? kept_as_it_is(cleaned->scan, std::max(options.levels, 1))
                      : pierce(SurfaceMap(cleaned->scan, *map), *map, tree, options.predict,
                               pierce_options, context);
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
