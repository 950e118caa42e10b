// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/dump_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "app/files.h"
#include "base/parallel.h"

namespace nacre::app {
namespace {

constexpr Rgb kNormalGrey = {206, 204, 198}, kBoundaryBlue = {30, 90, 220},
              kVectorOrange = {245, 130, 10}, kFoldMagenta = {225, 0, 140}, kBorder = {35, 35, 45};

/// The fractional parts of multiples of the golden ratio: neighbours in number differ in hue.
double hue_of(std::size_t index) {
  const double turns = 0.618033988749895 * static_cast<double>(index);
  return turns - std::floor(turns);
}

/// Hue 0 .. 1 round the wheel; saturation and value 0 .. 1.
Rgb from_hsv(double hue, double saturation, double value) {
  Rgb color{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double turn = std::fmod(5.0 - 2.0 * static_cast<double>(k) + 6 * hue, 6.0);
    const double dark = std::clamp(std::min(turn, 4 - turn), 0.0, 1.0);
    color[k] = static_cast<std::uint8_t>(std::lround(255 * value * (1 - saturation * dark)));
  }
  return color;
}

template <class Value>
void put(std::vector<std::uint8_t>& out, const Value& value) {
  const std::size_t at = out.size();  // little-endian machines only, as everywhere in the encoder
  out.resize(at + sizeof value);
  std::memcpy(out.data() + at, &value, sizeof value);
}

void put_text(std::vector<std::uint8_t>& out, const std::string& text) {
  out.insert(out.end(), text.begin(), text.end());
}

std::string channel_lines(bool quality, bool color) {
  std::string lines = quality ? "property float quality\n" : "";
  if (color)
    for (const char* name : {"red", "green", "blue"})
      lines += fmt::format("property uchar {}\n", name);
  return lines;
}

std::string header_of(const DumpMesh& dump, bool wide) {
  std::string header = "ply\nformat binary_little_endian 1.0\ncomment written by nacre\n";
  for (const std::string& comment : dump.comments) header += "comment " + comment + "\n";
  header += fmt::format("element vertex {}\n", dump.mesh.positions.size());
  for (const char* axis : {"x", "y", "z"})
    header += fmt::format("property {} {}\n", wide ? "double" : "float", axis);
  header += channel_lines(!dump.vertex_quality.empty(), !dump.vertex_color.empty());
  header += fmt::format("element face {}\nproperty list uchar int vertex_indices\n",
                        dump.mesh.triangles.size());
  header += channel_lines(!dump.face_quality.empty(), !dump.face_color.empty());
  return header + "end_header\n";
}

Result<void> check(const DumpMesh& dump) {
  const auto fits = [](std::size_t size, std::size_t count) { return size == 0 || size == count; };
  const std::size_t vertices = dump.mesh.positions.size(), faces = dump.mesh.triangles.size();
  if (!fits(dump.vertex_quality.size(), vertices) || !fits(dump.vertex_color.size(), vertices) ||
      !fits(dump.face_quality.size(), faces) || !fits(dump.face_color.size(), faces))
    return Error{ErrorCode::kBadInput, "a dump needs one value and colour per vertex or face"};
  for (std::size_t f = 0; f < faces; ++f)
    for (const std::uint32_t v : dump.mesh.triangles[f])
      if (v >= vertices) return Error{ErrorCode::kBadInput, "a triangle names a missing vertex", f};
  for (std::size_t v = 0; v < vertices; ++v)
    if (!dump.mesh.positions[v].allFinite())
      return Error{ErrorCode::kBadInput, "a coordinate is not a number", v};
  return {};
}

/// 1 for vertices on a side that has one triangle only.
std::vector<std::uint8_t> boundary_vertices(const Scan& scan) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> sides;
  sides.reserve(3 * scan.triangles.size());
  for (const Triangle& t : scan.triangles)
    for (std::size_t k = 0; k < 3; ++k) sides.push_back(std::minmax(t[k], t[(k + 1) % 3]));
  std::ranges::sort(sides);
  std::vector<std::uint8_t> boundary(scan.positions.size(), 0);
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end] == sides[i]) ++end;
    if (end == i + 1) boundary[sides[i].first] = boundary[sides[i].second] = 1;
    i = end;
  }
  return boundary;
}

}  // namespace

Result<std::vector<std::uint8_t>> to_ply(const DumpMesh& dump) {
  if (Result<void> ok = check(dump); !ok) return ok.error();
  const bool wide = !dump.mesh.origin.isZero(0.0);
  std::vector<std::uint8_t> out;
  out.reserve(dump.mesh.positions.size() * 31 + dump.mesh.triangles.size() * 20 + 2000);
  put_text(out, header_of(dump, wide));
  for (std::size_t v = 0; v < dump.mesh.positions.size(); ++v) {
    const Vec3 p = dump.mesh.positions[v] + dump.mesh.origin;
    for (int k = 0; k < 3; ++k) {
      if (wide) {
        put(out, p[k]);
      } else {
        put(out, static_cast<float>(p[k]));
      }
    }
    if (!dump.vertex_quality.empty()) put(out, dump.vertex_quality[v]);
    if (!dump.vertex_color.empty()) put(out, dump.vertex_color[v]);
  }
  for (std::size_t f = 0; f < dump.mesh.triangles.size(); ++f) {
    out.push_back(3);
    put(out, dump.mesh.triangles[f]);
    if (!dump.face_quality.empty()) put(out, dump.face_quality[f]);
    if (!dump.face_color.empty()) put(out, dump.face_color[f]);
  }
  return out;
}

void append(DumpMesh& dump, DumpMesh more) {
  if (dump.mesh.positions.empty()) {
    dump = std::move(more);
    return;
  }
  const auto offset = static_cast<std::uint32_t>(dump.mesh.positions.size());
  const auto join = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  for (Triangle& t : more.mesh.triangles)
    for (std::uint32_t& v : t) v += offset;
  join(dump.mesh.positions, more.mesh.positions);
  join(dump.mesh.triangles, more.mesh.triangles);
  join(dump.vertex_quality, more.vertex_quality);
  join(dump.vertex_color, more.vertex_color);
  join(dump.face_quality, more.face_quality);
  join(dump.face_color, more.face_color);
}

DumpMesh dump_clean(const remesh::CleanScan& cleaned) {
  DumpMesh dump;
  dump.mesh = cleaned.scan;
  dump.comments = {"clean: quality is the piece; boundary vertices are blue"};
  dump.vertex_quality.resize(cleaned.scan.positions.size());
  dump.vertex_color.resize(cleaned.scan.positions.size());
  const std::vector<std::uint8_t> boundary = boundary_vertices(cleaned.scan);
  for (std::size_t f = 0; f < cleaned.piece.size(); ++f) {
    const std::uint32_t piece = cleaned.piece[f];
    const Rgb color = piece == 0 ? kNormalGrey : from_hsv(hue_of(piece), 0.35, 0.9);
    for (const std::uint32_t v : cleaned.scan.triangles[f]) {
      dump.vertex_quality[v] = static_cast<float>(piece);
      dump.vertex_color[v] = boundary[v] != 0 ? kBoundaryBlue : color;
    }
  }
  return dump;
}

DumpMesh dump_base(const Scan& scan, const remesh::Parameterisation& map, std::size_t first_face) {
  const remesh::BaseMesh& base = map.base;
  DumpMesh dump;
  dump.mesh.origin = scan.origin;
  dump.mesh.triangles = base.triangles;
  for (const std::uint32_t v : base.scan_vertex) dump.mesh.positions.push_back(scan.positions[v]);
  dump.comments = {"base: quality of a vertex is its number of edges; boundary vertices are blue"};
  const std::vector<std::uint8_t> boundary = boundary_vertices(dump.mesh);
  dump.vertex_quality.assign(base.scan_vertex.size(), 0);
  for (std::size_t f = 0; f < base.triangles.size(); ++f) {
    for (const std::uint32_t v : base.triangles[f]) dump.vertex_quality[v] += 1;
    dump.face_color.push_back(from_hsv(hue_of(first_face + f), 0.45, 0.92));
  }
  for (std::size_t v = 0; v < boundary.size(); ++v) {
    if (boundary[v] != 0) dump.vertex_quality[v] += 1;
    dump.vertex_color.push_back(boundary[v] != 0 ? kBoundaryBlue : kNormalGrey);
  }
  return dump;
}

namespace {

/// A base triangle cut into cells², as fine as the scan's triangles can show.
int checker_cells(std::size_t scan_triangles, std::size_t base_triangles) {
  constexpr std::size_t kScanTrianglesPerCell = 6;
  int cells = 1;
  while (cells < 8 && base_triangles * 4 * cells * cells * kScanTrianglesPerCell <= scan_triangles)
    cells *= 2;
  return cells;
}

Rgb map_color(const remesh::DomainPoint& p, std::size_t first_face, int cells) {
  const double hue = hue_of(first_face + p.face);
  if (std::min({p.weight[0], p.weight[1], p.weight[2]}) < 0.025) return kBorder;
  int whole = 0;  // cells - 1 in cells that stand as the triangle does, cells - 2 in the others
  for (const double w : p.weight) whole += static_cast<int>(std::floor(w * cells));
  return whole == cells - 2 ? from_hsv(hue, 0.25, 0.98) : from_hsv(hue, 0.6, 0.8);
}

/// The larger over the smaller singular value of a linear map of triangles: into the plane of
/// `corner`, and into a base triangle of unit sides.
float anisotropy(const std::array<Vec3, 3>& corner,
                 const std::array<const remesh::DomainPoint*, 3>& image) {
  const auto place = [](const remesh::DomainPoint& p) {
    return Eigen::Vector2d(p.weight[1] + p.weight[2] / 2, p.weight[2] * std::sqrt(3.0) / 2);
  };
  const Vec3 e = corner[1] - corner[0], g = corner[2] - corner[0];
  const double length = norm(e), area = norm(cross(e, g));
  if (!(length > 0) || !(area > 0)) return 0;
  Eigen::Matrix2d from, to;
  from << length, dot(e, g) / length, 0, area / length;
  to << place(*image[1]) - place(*image[0]), place(*image[2]) - place(*image[0]);
  const Eigen::Matrix2d map = to * from.inverse();
  // σ1² + σ2² and σ1 σ2 give both.
  const double sum = map.squaredNorm(), product = std::abs(map.determinant());
  const double spread = std::sqrt(std::max(0.0, sum * sum - 4 * product * product));
  constexpr double kMost = 1e6;  // a face that the map flattens
  return static_cast<float>(
      std::sqrt(std::min((sum + spread) / std::max(sum - spread, 1e-300), kMost * kMost)));
}

}  // namespace

DumpMesh dump_parameterisation(const Scan& scan, const remesh::Parameterisation& map,
                               std::size_t first_face) {
  DumpMesh dump;
  dump.mesh = scan;
  dump.comments = {
      "parameterisation: a hue per base triangle, cut as some splits cut it; quality of a face is "
      "the ratio of its singular values"};
  const int cells = checker_cells(scan.triangles.size(), map.base.triangles.size());
  const std::size_t count = scan.triangles.size();
  dump.face_quality.assign(count, 0);
  dump.face_color.resize(count);
  dump.vertex_color.resize(scan.positions.size());
  parallel_for_each_index(dump.vertex_color.size(), [&](std::size_t v) {
    dump.vertex_color[v] = map_color(map.point[v], first_face, cells);
  });
  parallel_for_each_index(count, [&](std::size_t f) {
    const Triangle& t = scan.triangles[f];
    const std::array<const remesh::DomainPoint*, 3> image = {&map.point[t[0]], &map.point[t[1]],
                                                             &map.point[t[2]]};
    const std::uint32_t face = image[0]->face;
    if (image[1]->face != face || image[2]->face != face) {
      dump.face_color[f] = kBorder;
      return;
    }
    remesh::DomainPoint centroid{face, {}};
    for (const auto* p : image)
      for (std::size_t k = 0; k < 3; ++k) centroid.weight[k] += p->weight[k] / 3;
    dump.face_color[f] = map_color(centroid, first_face, cells);
    dump.face_quality[f] =
        anisotropy({scan.positions[t[0]], scan.positions[t[1]], scan.positions[t[2]]}, image);
  });
  return dump;
}

Result<DumpMesh> dump_level(const SemiRegularMesh& mesh, int level,
                            std::span<const std::uint8_t> kind, const FoldCheck& scan) {
  Result<TriangleMesh> triangles = to_triangles(mesh, level);
  if (!triangles) return triangles.error();
  const std::size_t vertices = triangles->positions.size();
  if (kind.size() < vertices)
    return Error{ErrorCode::kBadInput, "a level needs one kind of detail per vertex"};
  const FoldCheck::Outcome outcome = scan.check(*triangles);
  DumpMesh dump;
  dump.mesh = std::move(*triangles);
  dump.comments = {
      fmt::format("level {} of {}: {} folded triangles (magenta)", level, mesh.level_count,
                  outcome.folds),
      "quality of a vertex: 0 normal detail, 1 boundary (blue), 2 vector (orange); of a face: "
      "distance of its centroid to the scan"};
  for (std::size_t v = 0; v < vertices; ++v) {
    const auto of = static_cast<remesh::DetailKind>(kind[v]);
    dump.vertex_quality.push_back(static_cast<float>(kind[v]));
    dump.vertex_color.push_back(of == remesh::DetailKind::kBoundary ? kBoundaryBlue
                                : of == remesh::DetailKind::kVector ? kVectorOrange
                                                                    : kNormalGrey);
  }
  for (std::size_t f = 0; f < dump.mesh.triangles.size(); ++f) {
    const bool folded = outcome.folded[f] != 0;
    dump.face_quality.push_back(static_cast<float>(outcome.distance[f]));
    dump.face_color.push_back(folded ? kFoldMagenta
                                     : from_hsv(hue_of(f >> (2 * level)), 0.18, 0.95));
    if (folded)
      for (const std::uint32_t v : dump.mesh.triangles[f]) dump.vertex_color[v] = kFoldMagenta;
  }
  return dump;
}

}  // namespace nacre::app
