// SPDX-License-Identifier: GPL-3.0-or-later
#include <limits>

#include "remesh/clean_steps.h"

namespace nacre::remesh {
namespace {

struct Box {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  void add(const Vec3& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  [[nodiscard]] double extent() const { return (high - low).norm(); }
};

struct Size {
  Box box;
  double area = 0;
  std::uint32_t first_face = kNone;
};

/// Takes out the marked pieces and the vertices that nothing else uses.
void remove_pieces(CleanScan& cleaned, const std::vector<char>& drop) {
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
    cleaned.piece[faces++] = number[cleaned.piece[f]];
  }
  triangles.resize(faces);
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

void drop_small_pieces(CleanScan& cleaned, std::span<const std::uint32_t> face_source,
                       double extent_share, double area_share, CleanCounts& counts) {
  const auto& [positions, triangles, origin] = cleaned.scan;
  std::vector<Size> sizes(cleaned.pieces.size());
  Box all;
  double area = 0;
  for (std::uint32_t f = 0; f < triangles.size(); ++f) {
    Size& size = sizes[cleaned.piece[f]];
    if (size.first_face == kNone) size.first_face = f;
    const Triangle& t = triangles[f];
    size.area +=
        (positions[t[1]] - positions[t[0]]).cross(positions[t[2]] - positions[t[0]]).norm() / 2;
    for (const std::uint32_t v : t) size.box.add(positions[v]);
  }
  for (const Size& size : sizes) {
    all.add(size.box.low);
    all.add(size.box.high);
    area += size.area;
  }
  std::vector<char> drop(sizes.size(), 0);
  double dropped_area = 0;
  std::size_t dropped = 0;
  for (std::size_t p = 0; p < sizes.size(); ++p) {
    drop[p] = sizes[p].box.extent() < extent_share * all.extent();
    if (!drop[p]) continue;
    dropped_area += sizes[p].area;
    ++dropped;
  }
  // All of them or none: what is much of the surface is no dust, however small its pieces are.
  if (dropped == 0 || dropped == sizes.size() || dropped_area > area_share * area) return;
  for (std::size_t p = 0; p < sizes.size(); ++p) {
    if (!drop[p]) continue;
    counts.small.add(face_source[sizes[p].first_face]);
    counts.small.measure(sizes[p].area, sizes[p].box.extent());
  }
  remove_pieces(cleaned, drop);
}

}  // namespace nacre::remesh
