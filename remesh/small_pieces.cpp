// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>

#include "remesh/chart.h"
#include "remesh/clean_steps.h"
#include "remesh/pierce.h"

namespace nacre::remesh {
namespace {

struct Size {
  Box box;
  double area = 0;
  std::uint32_t first_face = kNone;
};

/// Small pieces that are more than this share of the surface are no dust.
constexpr double kMostArea = 0.05;

std::vector<Size> measure(const CleanScan& cleaned) {
  const auto& [positions, triangles, origin] = cleaned.scan;
  std::vector<Size> sizes(cleaned.pieces.size());
  for (std::uint32_t f = 0; f < triangles.size(); ++f) {
    Size& size = sizes[cleaned.piece[f]];
    if (size.first_face == kNone) size.first_face = f;
    const Triangle& t = triangles[f];
    size.area +=
        (positions[t[1]] - positions[t[0]]).cross(positions[t[2]] - positions[t[0]]).norm() / 2;
    for (const std::uint32_t v : t) size.box.add(positions[v]);
  }
  return sizes;
}

/// Unmarks the pieces of which something is farther than `error` from the unmarked ones.
void keep_distant(const CleanScan& cleaned, double error, std::vector<char>& small) {
  const auto& [positions, triangles, origin] = cleaned.scan;
  Scan rest;
  rest.positions = positions;
  for (std::size_t f = 0; f < triangles.size(); ++f)
    if (!small[cleaned.piece[f]]) rest.triangles.push_back(triangles[f]);
  const LineTree tree(rest);
  const auto near = [&](const Vec3& p) {
    return (position_of(tree.nearest(p), rest.triangles, positions) - p).norm() <= error;
  };
  std::vector<char> distant(small.size(), 0);
  for (std::size_t f = 0; f < triangles.size(); ++f) {
    const std::uint32_t piece = cleaned.piece[f];
    if (!small[piece] || distant[piece]) continue;
    const Vec3 &a = positions[triangles[f][0]], &b = positions[triangles[f][1]],
               &c = positions[triangles[f][2]];
    for (const Vec3& p : {a, b, c, Vec3((a + b) / 2), Vec3((b + c) / 2), Vec3((c + a) / 2)})
      distant[piece] |= !near(p);
  }
  for (std::size_t p = 0; p < small.size(); ++p) small[p] &= !distant[p];
}

/// Takes out the marked pieces and the vertices that nothing else uses.
void remove_pieces(CleanScan& cleaned, const std::vector<char>& drop,
                   std::vector<std::uint32_t>& face_source) {
  std::vector<std::uint32_t> number(drop.size(), kNone);
  std::uint32_t pieces = 0;
  for (std::size_t p = 0; p < drop.size(); ++p) {
    if (drop[p]) continue;
    cleaned.pieces[pieces] = cleaned.pieces[p];
    number[p] = pieces++;
  }
  cleaned.pieces.resize(pieces);
  auto& [positions, triangles, origin] = cleaned.scan;
  std::vector<char> used(positions.size(), 0);
  std::size_t faces = 0;
  for (std::size_t f = 0; f < triangles.size(); ++f) {
    if (drop[cleaned.piece[f]]) continue;
    triangles[faces] = triangles[f];
    face_source[faces] = face_source[f];
    cleaned.piece[faces++] = number[cleaned.piece[f]];
  }
  triangles.resize(faces);
  face_source.resize(faces);
  cleaned.piece.resize(faces);
  for (const Triangle& t : triangles)
    for (const std::uint32_t v : t) used[v] = 1;
  std::vector<std::uint32_t> id(positions.size(), kNone);
  std::uint32_t vertices = 0;
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (!used[v]) continue;
    positions[vertices] = positions[v];
    id[v] = vertices++;
  }
  positions.resize(vertices);
  for (Triangle& t : triangles)
    for (std::uint32_t& v : t) v = id[v];
}

}  // namespace

std::vector<double> piece_extents(const CleanScan& cleaned) {
  std::vector<double> extents;
  for (const Size& size : measure(cleaned)) extents.push_back(size.box.extent());
  return extents;
}

void drop_small_pieces(CleanScan& cleaned, std::vector<std::uint32_t>& face_source,
                       const SmallPieces& options, CleanCounts& counts) {
  const std::vector<Size> sizes = measure(cleaned);
  // By the largest piece, which stays: so a second cleaning finds the same pieces small.
  double largest = 0, area = 0, small_area = 0;
  for (const Size& size : sizes) {
    largest = std::max(largest, size.box.extent());
    area += size.area;
  }
  std::vector<char> small(sizes.size(), 0);
  bool any = false;
  for (std::size_t p = 0; p < sizes.size(); ++p) {
    small[p] = sizes[p].box.extent() < options.extent * largest;
    any |= small[p] != 0;
    if (small[p]) small_area += sizes[p].area;
  }
  if (!any || small_area > kMostArea * area) return;
  if (std::isfinite(options.error)) keep_distant(cleaned, options.error * largest, small);
  any = false;
  for (std::size_t p = 0; p < sizes.size(); ++p) {
    if (!small[p]) continue;
    any = true;
    counts.small.add(face_source[sizes[p].first_face]);
    counts.small.measure(sizes[p].area, sizes[p].box.extent());
  }
  if (any) remove_pieces(cleaned, small, face_source);
}

}  // namespace nacre::remesh
