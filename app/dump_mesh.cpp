// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/dump_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "app/dump_colors.h"
#include "app/files.h"

namespace nacre::app {
namespace {

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
