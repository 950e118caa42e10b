// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/stage_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/files.h"
#include "app/stage_arrays.h"
#include "base/topology.h"
#include "io/io.h"
#include "remesh/adjacency.h"
#include "remesh/pierce.h"
#include "wavelet/wavelet.h"

namespace nacre::app {
namespace {

constexpr const char* kPositions = "positions.npy";
constexpr const char* kTriangles = "triangles.npy";
constexpr const char* kOrigin = "origin.npy";
constexpr const char* kBaseTriangles = "base-triangles.npy";
constexpr const char* kScanVertex = "scan-vertex.npy";

StageFile origin_file(const Vec3& origin) {
  const std::array<double, 3> xyz = {origin[0], origin[1], origin[2]};
  return array_file(kOrigin, std::span<const double>(xyz));
}

Error misfit(const StageFolder& stage, const std::string& name, const std::string& what) {
  return {ErrorCode::kGeometryRefused, fmt::format("{}: {}", (stage.folder / name).string(), what)};
}

Result<std::vector<Vec3>> finite_points(const StageFolder& stage, const std::string& name) {
  auto points = array_of<Vec3>(stage, name);
  if (!points) return points;
  constexpr double kLargest = 1e30;  // as io::read_scan
  for (std::size_t i = 0; i < points->size(); ++i)
    for (int k = 0; k < 3; ++k)
      if (!(std::abs((*points)[i][k]) <= kLargest))
        return misfit(stage, name, fmt::format("row {} is no usable point", i));
  return points;
}

Result<std::vector<Triangle>> triangles_of(const StageFolder& stage, const std::string& name,
                                           std::size_t vertices) {
  auto triangles = array_of<Triangle>(stage, name);
  if (!triangles) return triangles;
  if (triangles->empty()) return misfit(stage, name, "has no triangle");
  for (std::size_t f = 0; f < triangles->size(); ++f)
    for (const std::uint32_t v : (*triangles)[f])
      if (v >= vertices)
        return misfit(stage, name,
                      fmt::format("triangle {} names vertex {} of {}", f, v, vertices));
  return triangles;
}

Result<Vec3> origin_of(const StageFolder& stage) {
  const auto xyz = array_of<double>(stage, kOrigin);
  if (!xyz) return xyz.error();
  if (xyz->size() != 3 || !std::ranges::all_of(*xyz, [](double x) { return std::isfinite(x); }))
    return misfit(stage, kOrigin, "needs three finite numbers");
  return Vec3((*xyz)[0], (*xyz)[1], (*xyz)[2]);
}

/// Whether the PLY is to be looked at instead of the arrays.
bool takes_ply(const StageFolder& stage, const std::string& name) {
  return stage.is_edited(name) && !stage.is_edited(kPositions) && !stage.is_edited(kTriangles);
}

/// What an unedited PLY would have for a coordinate: see to_ply().
double as_in_ply(double absolute, bool wide) {
  return wide ? absolute : double{static_cast<float>(absolute)};
}

/// Takes over the vertices of an edited PLY that are not where they were written. False if it has
/// other triangles than `scan`, which then stays.
bool merge_positions(const Scan& ply, Scan& scan) {
  if (ply.positions.size() != scan.positions.size() || ply.triangles != scan.triangles)
    return false;
  const bool wide = !scan.origin.isZero(0.0);
  for (std::size_t v = 0; v < scan.positions.size(); ++v) {
    const Vec3 now = ply.positions[v] + ply.origin, was = scan.positions[v] + scan.origin;
    bool moved = false;
    for (int k = 0; k < 3; ++k) moved |= now[k] != as_in_ply(was[k], wide);
    if (moved) scan.positions[v] = now - scan.origin;
  }
  return true;
}

Result<Scan> edited_ply(const StageFolder& stage, const std::string& name) {
  auto read = io::read_scan(stage.folder / name);
  if (!read) return in_file(read.error(), stage.folder / name);
  return std::move(read->scan);
}

Result<Scan> scan_with_ply(const StageFolder& stage, const std::string& ply_name) {
  auto positions = finite_points(stage, kPositions);
  if (!positions) return positions.error();
  auto triangles = triangles_of(stage, kTriangles, positions->size());
  if (!triangles) return triangles.error();
  const auto origin = origin_of(stage);
  if (!origin) return origin.error();
  Scan scan{std::move(*positions), std::move(*triangles), *origin};
  if (!takes_ply(stage, ply_name)) return scan;
  auto ply = edited_ply(stage, ply_name);
  if (!ply) return ply.error();
  if (!merge_positions(*ply, scan)) scan = std::move(*ply);
  return scan;
}

/// The scan's boundary must lead from each base corner on it to the next: piercing walks it.
Result<void> check_boundary(const StageFolder& stage, const Scan& scan,
                            const remesh::BaseMesh& base) {
  const auto count = static_cast<std::uint32_t>(scan.positions.size());
  const auto topology = Topology::build(scan.triangles, count, 0);
  if (!topology) return misfit(stage, kTriangles, topology.error().message);
  std::vector<std::uint32_t> next(count, kNone);
  const auto neighbors = remesh::side_neighbors(scan.triangles, count);
  for (std::size_t f = 0; f < neighbors.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k)
      if (neighbors[f][k] == kNone) next[scan.triangles[f][k]] = scan.triangles[f][(k + 1) % 3];
  std::size_t steps = 0;
  for (std::size_t f = 0; f < base.triangles.size(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (base.neighbors[f][k] != kNone) continue;
      const std::uint32_t end = base.scan_vertex[base.triangles[f][(k + 1) % 3]];
      for (std::uint32_t v = base.scan_vertex[base.triangles[f][k]]; v != end; v = next[v])
        if (next[v] == kNone || ++steps > count)
          return misfit(stage, kScanVertex, "the base's boundary is not the scan's");
    }
  }
  return {};
}

Result<void> check_point(const StageFolder& stage, const remesh::DomainPoint& p, std::size_t at,
                         std::size_t faces) {
  double sum = 0;
  bool fine = p.face < faces;
  for (const double w : p.weight) {
    fine &= w >= -1e-6 && w <= 1 + 1e-6;  // not for a weight that is no number
    sum += w;
  }
  if (fine && std::abs(sum - 1) < 1e-6) return {};
  return misfit(stage, "point-weight.npy",
                fmt::format("row {} is no point of a base triangle", at));
}

Result<remesh::BaseMesh> base_of(const StageFolder& stage, std::size_t scan_vertices) {
  remesh::BaseMesh base;
  auto scan_vertex = array_of<std::uint32_t>(stage, kScanVertex);
  if (!scan_vertex) return scan_vertex.error();
  base.scan_vertex = std::move(*scan_vertex);
  for (const std::uint32_t v : base.scan_vertex)
    if (v >= scan_vertices) return misfit(stage, kScanVertex, "names a vertex that is not there");
  auto triangles = triangles_of(stage, kBaseTriangles, base.scan_vertex.size());
  if (!triangles) return triangles.error();
  base.triangles = std::move(*triangles);
  const auto count = static_cast<std::uint32_t>(base.scan_vertex.size());
  const auto topology = Topology::build(base.triangles, count, 0);
  if (!topology) return misfit(stage, kBaseTriangles, topology.error().message);
  base.neighbors = remesh::side_neighbors(base.triangles, count);
  std::vector<char> used(count, 0);
  for (const Triangle& t : base.triangles)
    for (const std::uint32_t v : t) used[v] = 1;
  if (std::ranges::find(used, 0) != used.end())
    return misfit(stage, kBaseTriangles, "a base vertex has no triangle");
  return base;
}

std::string level_ply(int level) { return fmt::format("level-{}.ply", level); }

/// Vertices that were moved in the PLY of any level; a coarser level's are the first of a finer's.
Result<void> merge_levels(const StageFolder& stage, SemiRegularMesh& mesh) {
  if (stage.is_edited(kPositions)) return {};
  const SemiRegularMesh written = mesh;
  for (int level = 0; level <= mesh.level_count; ++level) {
    if (!stage.is_edited(level_ply(level))) continue;
    auto ply = edited_ply(stage, level_ply(level));
    if (!ply) return ply.error();
    auto was = to_triangles(written, level);
    if (!was) return was.error();
    const std::vector<Vec3> before = was->positions;
    if (!merge_positions(*ply, *was))
      return misfit(stage, level_ply(level),
                    "has other triangles or vertices than were written; in this stage vertices "
                    "can be moved only");
    for (std::size_t v = 0; v < before.size(); ++v)
      if (was->positions[v] != before[v]) mesh.positions[v] = was->positions[v];
  }
  return {};
}

std::string band_name(std::size_t band) { return fmt::format("band-{}.npy", band); }

/// Bands that were edited make the mesh anew from the base on.
Result<void> merge_bands(const StageFolder& stage, wavelet::Transform transform,
                         SemiRegularMesh& mesh) {
  bool edited = false;
  for (int j = 0; j < mesh.level_count; ++j)
    edited |= stage.is_edited(band_name(static_cast<std::size_t>(j)));
  if (!edited) return {};
  const auto topology =
      Topology::build(mesh.base_triangles, mesh.base_vertex_count, mesh.level_count);
  if (!topology) return topology.error();
  auto pyramid = wavelet::analyze(*topology, mesh.positions, transform);
  if (!pyramid) return in_file(pyramid.error(), stage.folder);
  for (int j = 0; j < mesh.level_count; ++j) {
    const auto band = static_cast<std::size_t>(j);
    auto details = finite_points(stage, band_name(band));
    if (!details) return details.error();
    if (details->size() != pyramid->bands[band].size())
      return misfit(stage, band_name(band), "needs one detail per vertex of the band");
    pyramid->bands[band] = std::move(*details);
  }
  auto positions = wavelet::synthesize(*topology, *pyramid, transform);
  if (!positions) return in_file(positions.error(), stage.folder);
  mesh.positions = std::move(*positions);
  return {};
}

}  // namespace

StageFiles files_of(const Scan& scan) {
  return {array_file(kPositions, scan.positions), array_file(kTriangles, scan.triangles),
          origin_file(scan.origin)};
}

StageFiles files_of(const remesh::CleanScan& cleaned) {
  StageFiles files = files_of(cleaned.scan);
  files.push_back(array_file("piece.npy", cleaned.piece));
  return files;
}

StageFiles base_files_of(const Scan& scan, const remesh::BaseMesh& base) {
  Scan corners{{}, base.triangles, scan.origin};
  for (const std::uint32_t v : base.scan_vertex) corners.positions.push_back(scan.positions[v]);
  StageFiles files = files_of(corners);
  files.push_back(array_file(kScanVertex, base.scan_vertex));
  return files;
}

StageFiles files_of(const Scan& scan, const remesh::Parameterisation& map) {
  StageFiles files = files_of(scan);
  files.push_back(array_file(kBaseTriangles, map.base.triangles));
  files.push_back(array_file(kScanVertex, map.base.scan_vertex));
  std::vector<std::uint32_t> face;
  std::vector<std::array<double, 3>> weight;
  for (const remesh::DomainPoint& p : map.point) {
    face.push_back(p.face);
    weight.push_back(p.weight);
  }
  files.push_back(array_file("point-face.npy", face));
  files.push_back(array_file("point-weight.npy", weight));
  return files;
}

StageFiles files_of(const SemiRegularMesh& mesh) {
  return {array_file(kPositions, mesh.positions), array_file(kBaseTriangles, mesh.base_triangles),
          origin_file(mesh.origin)};
}

Result<StageFiles> coefficient_files_of(const SemiRegularMesh& mesh, wavelet::Transform transform) {
  const auto topology =
      Topology::build(mesh.base_triangles, mesh.base_vertex_count, mesh.level_count);
  if (!topology) return topology.error();
  const auto pyramid = wavelet::analyze(*topology, mesh.positions, transform);
  if (!pyramid) return pyramid.error();
  StageFiles files = files_of(mesh);
  for (std::size_t j = 0; j < pyramid->bands.size(); ++j)
    files.push_back(array_file(band_name(j), pyramid->bands[j]));
  return files;
}

Result<Scan> scan_from(const StageFolder& stage) { return scan_with_ply(stage, "scan.ply"); }

Result<remesh::CleanScan> clean_from(const StageFolder& stage, const remesh::RepairPolicy& policy) {
  auto scan = scan_with_ply(stage, "clean.ply");
  if (!scan) return scan.error();
  if (!stage.edited.empty()) {
    auto again = remesh::clean(*scan, policy);
    if (!again) return in_file(again.error(), stage.folder);
    return again;
  }
  const StageFacts facts = facts_from(stage.record.facts);
  auto piece = array_of<std::uint32_t>(stage, "piece.npy");
  if (!piece) return piece.error();
  if (piece->size() != scan->triangles.size() ||
      std::ranges::any_of(*piece, [&](std::uint32_t p) { return p >= facts.pieces.size(); }))
    return misfit(stage, "piece.npy", "needs the number of a known piece per triangle");
  const auto topology =
      Topology::build(scan->triangles, static_cast<std::uint32_t>(scan->positions.size()), 0);
  if (!topology) return misfit(stage, kTriangles, topology.error().message);
  return remesh::CleanScan{std::move(*scan), std::move(*piece), facts.pieces, facts.clean};
}

Result<remesh::MappedScan> mapped_from(const StageFolder& stage) {
  for (const char* name : {kTriangles, kBaseTriangles, kScanVertex})
    if (stage.is_edited(name))
      return misfit(stage, name,
                    "was edited, but the map holds for its own triangles only; edit positions or "
                    "points, or go on from 02-clean");
  auto scan = scan_with_ply(stage, "");
  if (!scan) return scan.error();
  auto base = base_of(stage, scan->positions.size());
  if (!base) return base.error();
  const auto face = array_of<std::uint32_t>(stage, "point-face.npy");
  if (!face) return face.error();
  const auto weight = array_of<std::array<double, 3>>(stage, "point-weight.npy");
  if (!weight) return weight.error();
  if (face->size() != scan->positions.size() || weight->size() != face->size())
    return misfit(stage, "point-face.npy", "needs one row per vertex of the scan");
  remesh::MappedScan mapped;
  for (std::size_t v = 0; v < face->size(); ++v) {
    mapped.map.point.push_back({(*face)[v], (*weight)[v]});
    const auto ok = check_point(stage, mapped.map.point.back(), v, base->triangles.size());
    if (!ok) return ok.error();
  }
  if (const auto ok = check_boundary(stage, *scan, *base); !ok) return ok.error();
  mapped.map.base = std::move(*base);
  mapped.scan = std::make_shared<const Scan>(std::move(*scan));
  const StageFacts facts = facts_from(stage.record.facts);
  mapped.levels = facts.levels;
  mapped.is_kept = facts.is_kept;
  mapped.pieces = facts.pieces;
  return mapped;
}

Result<void> move_base(const StageFolder& stage, remesh::MappedScan& mapped) {
  const auto corners = scan_with_ply(stage, "base.ply");
  if (!corners) return corners.error();
  remesh::BaseMesh& base = mapped.map.base;
  if (corners->positions.size() != base.scan_vertex.size() || corners->triangles != base.triangles)
    return misfit(stage, kTriangles,
                  "is not the base mesh of 04-parameterisation beside it; in 03-base vertices can "
                  "be moved only");
  std::vector<char> boundary(base.scan_vertex.size(), 0);
  for (std::size_t f = 0; f < base.triangles.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k)
      if (base.neighbors[f][k] == kNone)
        boundary[base.triangles[f][k]] = boundary[base.triangles[f][(k + 1) % 3]] = 1;
  const Scan& scan = *mapped.scan;
  for (std::size_t v = 0; v < base.scan_vertex.size(); ++v) {
    const Vec3 p = corners->positions[v] + (corners->origin - scan.origin);
    if (p == scan.positions[base.scan_vertex[v]]) continue;
    if (boundary[v] != 0)
      return misfit(stage, kPositions,
                    fmt::format("vertex {} lies on the boundary; only inner ones can be moved", v));
    if (!mapped.tree) mapped.tree = std::make_shared<const remesh::LineTree>(scan);
    base.moved.resize(base.scan_vertex.size());
    base.moved[v] = mapped.tree->nearest(p);
  }
  return {};
}

Result<SemiRegularMesh> mesh_from(const StageFolder& stage) {
  SemiRegularMesh mesh;
  auto positions = finite_points(stage, kPositions);
  if (!positions) return positions.error();
  mesh.positions = std::move(*positions);
  auto triangles = triangles_of(stage, kBaseTriangles, mesh.positions.size());
  if (!triangles) return triangles.error();
  mesh.base_triangles = std::move(*triangles);
  for (const Triangle& t : mesh.base_triangles)
    mesh.base_vertex_count = std::max({mesh.base_vertex_count, t[0] + 1, t[1] + 1, t[2] + 1});
  const auto origin = origin_of(stage);
  if (!origin) return origin.error();
  mesh.origin = *origin;
  // The level count follows from the number of vertices.
  for (mesh.level_count = 0; mesh.level_count <= 12; ++mesh.level_count) {
    const auto topology =
        Topology::build(mesh.base_triangles, mesh.base_vertex_count, mesh.level_count);
    if (!topology) return misfit(stage, kBaseTriangles, topology.error().message);
    if (topology->vertex_count() > mesh.positions.size()) break;
    if (topology->vertex_count() < mesh.positions.size()) continue;
    const auto merged = stage.record.stage == DumpStage::kCoefficients
                            ? merge_bands(stage, facts_from(stage.record.facts).transform, mesh)
                            : merge_levels(stage, mesh);
    if (!merged) return merged.error();
    return mesh;
  }
  return misfit(stage, kPositions,
                fmt::format("has {} vertices, which no number of splits of the base makes",
                            mesh.positions.size()));
}

}  // namespace nacre::app
