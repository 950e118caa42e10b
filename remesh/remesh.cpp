// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/remesh.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <span>

#include "remesh/adjacency.h"
#include "remesh/choose_base.h"
#include "remesh/collapse_edges.h"
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

/// Nor has the finest mesh fewer than this: creases come out a level later than curved parts. Twice
/// as many where no file's size says how fine is fine enough.
constexpr std::size_t kLeastFineTriangles = 160'000;

/// Nor is it asked for more than this many for each triangle of the scan.
constexpr std::size_t kMostPerScanTriangle = 16;

/// Enough splits for the semi-regular mesh to have about four triangles for each one of the scan:
/// from there on the remeshing error is below what any rate of interest leaves.
int default_levels(std::size_t scan_triangles, std::size_t base_triangles, std::size_t asked) {
  const std::size_t least_fine = asked > 0 ? kLeastFineTriangles : 2 * kLeastFineTriangles;
  const std::size_t usual = std::max(scan_triangles * 5 / 2, least_fine);
  const std::size_t most = std::max(scan_triangles * kMostPerScanTriangle, usual);
  const std::size_t least = std::clamp(asked, usual, most);
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

void count_base_triangles(const Scan& scan, std::span<const std::uint32_t> piece,
                          const BaseMesh& base, std::vector<PieceReport>& pieces) {
  std::vector<std::uint32_t> piece_of_vertex(scan.positions.size(), 0);
  for (std::size_t f = 0; f < piece.size(); ++f)
    for (const std::uint32_t v : scan.triangles[f]) piece_of_vertex[v] = piece[f];
  for (const Triangle& t : base.triangles)
    ++pieces[piece_of_vertex[base.scan_vertex[t[0]]]].base_triangles;
}

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

/// Base vertices that pieces, boundary loops and handles need before any are there for the shape.
std::size_t vertices_for_topology(const std::vector<PieceReport>& pieces) {
  std::size_t count = 0;
  for (const PieceReport& piece : pieces)
    count += 4 + 3 * piece.boundary_loops + 4 * static_cast<std::size_t>(std::max(piece.genus, 0));
  return count;
}

/// Pieces, holes and handles come out well where the base has so many times the vertices that they
/// need, if that is not more than a share of the scan's.
constexpr std::size_t kPerTopology = 20, kScanPerBase = 25;
/// And shapes of any kind come out well with so many, where nobody says that fewer shall do.
constexpr std::size_t kWell = 480;

BaseSize base_size(const Options& options, const std::vector<PieceReport>& pieces,
                   std::size_t scan_vertices) {
  BaseSize size = {options.base_vertices, options.least_base_vertices, options.most_base_vertices};
  const std::size_t needed = vertices_for_topology(pieces);
  // As few as that would be bad everywhere.
  if (2 * needed > static_cast<std::size_t>(size.most)) size.most = 0;
  const bool is_free = options.least_base_vertices == 0 && options.most_base_vertices == 0;
  std::size_t well = std::max(kPerTopology * needed, is_free ? kWell : 0);
  well = std::min(well, scan_vertices / kScanPerBase);
  if (size.most > 0) well = std::min(well, static_cast<std::size_t>(size.most));
  size.least = std::max(size.least, static_cast<int>(well));
  return size;
}

/// The scan mapped onto itself.
MappedScan keep(CleanScan cleaned, int levels, const char* why) {
  MappedScan out;
  auto scan = std::make_shared<Scan>(std::move(cleaned.scan));
  out.levels = levels;
  out.is_kept = true;
  out.map = identity(*scan);
  for (PieceReport& piece : cleaned.pieces) piece.fallback = why;
  count_base_triangles(*scan, cleaned.piece, out.map.base, cleaned.pieces);
  out.pieces = std::move(cleaned.pieces);
  out.scan = std::move(scan);
  return out;
}

/// `useful`: see BaseSize.
Result<MappedScan> simplify_and_map(CleanScan cleaned, const Options& options, int useful,
                                    const RunContext& context) {
  const std::size_t scan_triangles = cleaned.scan.triangles.size();
  const double side = side_for_count(cleaned.scan, kLeastTriangles);
  if (side == 0) return Error{ErrorCode::kGeometryRefused, "no triangle has an area", 0};
  split_long_edges(cleaned, side, 4 * static_cast<std::size_t>(kLeastTriangles) + scan_triangles);
  split_chords(cleaned);
  MappedScan out;
  const auto scan = std::make_shared<Scan>(std::move(cleaned.scan));
  out.tree = std::make_shared<const LineTree>(*scan);
  BaseSize size = base_size(options, cleaned.pieces, scan->positions.size());
  size.useful = useful;
  size.few_trials = options.few_trials;
  auto map = choose_base(*scan, *out.tree, size, options.levels, options.predict, context);
  if (!map) return map.error();
  out.map = std::move(*map);
  out.levels = options.levels > 0 ? options.levels
                                  : default_levels(scan_triangles, out.map.base.triangles.size(),
                                                   options.least_triangles);
  count_base_triangles(*scan, cleaned.piece, out.map.base, cleaned.pieces);
  out.pieces = std::move(cleaned.pieces);
  out.scan = scan;
  return out;
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
    auto fewer = collapse_edges(std::move(cleaned), options.base_vertices, context);
    if (!fewer) return fewer.error();
    return told(keep(std::move(*fewer), options.levels, ""));
  }
  CleanScan whole;
  int useful = 0;
  if (options.base_vertices == 0 &&
      cleaned.scan.triangles.size() < static_cast<std::size_t>(kLeastTriangles)) {
    whole = cleaned;
    useful = std::max(
        1, static_cast<int>(kLeastGain * static_cast<double>(whole.scan.positions.size())));
  }
  auto mapped = simplify_and_map(std::move(cleaned), options, useful, context);
  if (!mapped && useful > 0 && mapped.error().code == ErrorCode::kNoConvergence) {
    return told(keep(
        std::move(whole), std::max(options.levels, 1),
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
  PierceOptions pierce_options;
  pierce_options.levels = mapped.levels;
  auto pierced = mapped.is_kept ? kept_as_it_is(scan, mapped.levels)
                                : pierce(SurfaceMap(scan, mapped.map), mapped.map,
                                         mapped.tree ? *mapped.tree : LineTree(scan),
                                         options.predict, pierce_options, context);
  if (!pierced) return pierced.error();
  Remesh out;
  out.mesh = std::move(pierced->mesh);
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
