// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/remesh.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <span>

#include "remesh/collapse_edges.h"
#include "remesh/fit_surface.h"
#include "remesh/kept_pieces.h"
#include "remesh/map_pieces.h"
#include "remesh/pierce.h"
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

Result<void> check(const Options& options) {
  if (options.levels < 0 || options.levels > 12)
    return Error{ErrorCode::kBadInput, "levels must be 0 .. 12", 0};
  if (options.base_vertices < 0)
    return Error{ErrorCode::kBadInput, "base vertices must not be negative", 0};
  if (!options.predict) return Error{ErrorCode::kBadInput, "a prediction is required", 0};
  return {};
}

/// What comes from elsewhere must at least have its indices in range.
Result<void> check(const MappedScan& mapped) {
  const auto bad = [](const char* what, std::size_t where) {
    return Error{ErrorCode::kBadInput, what, where};
  };
  if (!mapped.scan || mapped.map.base.triangles.empty()) return bad("the map is empty", 0);
  if (mapped.levels < (mapped.is_kept ? 0 : 1) || mapped.levels > 12)
    return bad("levels must be 1 .. 12", 0);
  const BaseMesh& base = mapped.map.base;
  const std::size_t vertices = mapped.scan->positions.size();
  if (mapped.map.point.size() != vertices) return bad("the map needs a point per vertex", 0);
  for (std::size_t f = 0; f < mapped.scan->triangles.size(); ++f)
    for (const std::uint32_t v : mapped.scan->triangles[f])
      if (v >= vertices) return bad("a triangle of the scan names a missing vertex", f);
  for (std::size_t v = 0; v < base.scan_vertex.size(); ++v)
    if (base.scan_vertex[v] >= vertices) return bad("a base vertex is at no vertex of the scan", v);
  if (base.neighbors.size() != base.triangles.size())
    return bad("a base triangle has no neighbours", 0);
  for (std::size_t v = 0; v < vertices; ++v)
    if (mapped.map.point[v].face >= base.triangles.size())
      return bad("a vertex of the scan lies on no base triangle", v);
  return {};
}

/// Scans of fewer triangles may end as their own base mesh,
constexpr std::size_t kFewTriangles = 20'000;
/// if they cannot be simplified to less than this share of their vertices.
constexpr double kLeastGain = 0.5;

/// The mapped part of a scan and the pieces that are their own base, each pierced its own way.
Result<Pierced> pierce_apart(const MappedScan& mapped, std::size_t kept,
                             const LevelPredictor& predict, const RunContext& context) {
  const auto apart = part_kept(*mapped.scan, mapped.map, kept);
  if (!apart) return apart.error();
  auto own = kept_as_it_is(apart->kept, mapped.levels);
  if (!own || apart->map.base.triangles.empty()) return own;
  PierceOptions options;
  options.levels = mapped.levels;
  const auto pierced = pierce(SurfaceMap(apart->scan, apart->map), apart->map,
                              LineTree(apart->scan), predict, options, context);
  if (!pierced) return pierced.error();
  return joined(*pierced, *own);
}

/// Vertices that are at no place go to the middle of their edge.
void mend_broken(SemiRegularMesh& mesh) {
  bool any = false;
  for (const Vec3& p : mesh.positions) any |= !p.allFinite();
  if (!any) return;
  const auto topology =
      Topology::build(mesh.base_triangles, mesh.base_vertex_count, mesh.level_count);
  if (!topology) return;
  for (int level = 0; level < mesh.level_count; ++level) {
    std::size_t v = topology->level(level).vertex_count;
    for (const Edge& e : topology->level(level).edges) {
      if (!mesh.positions[v].allFinite())
        mesh.positions[v] = (mesh.positions[e.vertex[0]] + mesh.positions[e.vertex[1]]) / 2;
      ++v;
    }
  }
}

}  // namespace

Result<MappedScan> map_onto_base(CleanScan cleaned, const Options& options,
                                 const RunContext& context) {
  if (const auto ok = check(options); !ok) return ok.error();
  const auto told = [&](MappedScan mapped) {
    if (options.observer.base) options.observer.base(*mapped.scan, mapped.map);
    return mapped;
  };
  if (options.keep_triangles) {
    if (options.base_vertices == 0) return told(keep(std::move(cleaned), options.levels, ""));
    if (options.few_trials) {
      auto fewer = collapse_edges_quickly(std::move(cleaned), options.base_vertices, context);
      if (!fewer) return fewer.error();
      return told(keep(std::move(*fewer), options.levels, ""));
    }
    const Scan scan = cleaned.scan;
    auto fewer = collapse_edges(std::move(cleaned), options.base_vertices, context);
    if (!fewer) return fewer.error();
    if (fewer->scan.positions.size() < scan.positions.size())
      fit_surface(scan, fewer->scan, context);
    if (context.cancelled()) return Error{ErrorCode::kCancelled, "interrupted", 0};
    return told(keep(std::move(*fewer), options.levels, ""));
  }
  int useful = 0;
  if (options.base_vertices == 0 && cleaned.scan.triangles.size() < kFewTriangles)
    useful = std::max(
        1, static_cast<int>(kLeastGain * static_cast<double>(cleaned.scan.positions.size())));
  auto mapped = map_pieces(cleaned, options, useful, context);
  if (!mapped && useful > 0 && mapped.error().code == ErrorCode::kNoConvergence) {
    return told(keep(
        std::move(cleaned), std::max(options.levels, 1),
        "its own triangles are the base: the scan cannot be simplified to half of its vertices"));
  }
  if (!mapped) return mapped.error();
  return told(std::move(*mapped));
}

Result<Remesh> pierce_map(const MappedScan& mapped, const Options& options,
                          const RunContext& context) {
  if (const auto ok = check(options); !ok) return ok.error();
  if (const auto ok = check(mapped); !ok) return ok.error();
  const Scan& scan = *mapped.scan;
  std::size_t kept = 0;
  for (const PieceReport& piece : mapped.pieces) kept += piece.is_own_base * piece.base_triangles;
  PierceOptions pierce_options;
  pierce_options.levels = mapped.levels;
  auto pierced = mapped.is_kept ? kept_as_it_is(scan, mapped.levels)
                 : kept > 0     ? pierce_apart(mapped, kept, options.predict, context)
                                : pierce(SurfaceMap(scan, mapped.map), mapped.map,
                                     mapped.tree ? *mapped.tree : LineTree(scan), options.predict,
                                         pierce_options, context);
  if (!pierced) return pierced.error();
  Remesh out;
  out.mesh = std::move(pierced->mesh);
  mend_broken(out.mesh);
  out.pieces = mapped.pieces;
  out.bands = std::move(pierced->bands);
  if (options.observer.normal_mesh) options.observer.normal_mesh(out.mesh, pierced->kind);
  return out;
}

Result<Remesh> remesh(const Scan& scan, const Options& options, const RunContext& context) {
  if (const auto ok = check(options); !ok) return ok.error();
  std::vector<StageCost> costs;
  Stopwatch watch(costs);
  auto cleaned = clean(scan, options.repair, options.small_extent);
  if (!cleaned) return cleaned.error();
  const CleanReport report = cleaned->report;
  if (options.observer.cleaned) options.observer.cleaned(*cleaned);
  watch.lap("clean");
  const auto mapped = map_onto_base(std::move(*cleaned), options, context);
  if (!mapped) return mapped.error();
  watch.lap("base mesh");
  auto out = pierce_map(*mapped, options, context);
  if (!out) return out.error();
  watch.lap("piercing");
  out->clean = report;
  out->costs = std::move(costs);
  return out;
}

}  // namespace nacre::remesh
