// SPDX-License-Identifier: GPL-3.0-or-later
//
// The scan's own triangles are too coarse to show where the map's lines run, so they are split
// first. A small triangle lies in one base triangle or across one of its sides; the few that lie
// around a base corner, in several, are left dark.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "app/dump_colors.h"
#include "app/dump_mesh.h"
#include "base/parallel.h"
#include "base/topology.h"

namespace nacre::app {
namespace {

using Weights = std::array<double, 3>;

constexpr std::size_t kMostTriangles = 400'000;  // of the split scan
constexpr int kMostSplits = 2;
constexpr std::size_t kTrianglesPerCell = 8;  // of the checkerboard
constexpr double kBorder = 0.025;             // half the width of a line, in weights

/// Weights of a point in base triangle `face`, which may be negative: points of its neighbours are
/// seen with the two unfolded into one plane. Nothing for points farther away.
std::optional<Weights> seen_from(const remesh::BaseMesh& base, const remesh::DomainPoint& p,
                                 std::uint32_t face) {
  if (p.face == face) return p.weight;
  const Triangle& own = base.triangles[face];
  const Triangle& other = base.triangles[p.face];
  for (std::size_t c = 0; c < 3; ++c) {  // a base corner belongs to every triangle around it
    if (p.weight[c] != 1) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      if (own[k] != other[c]) continue;
      Weights corner{};
      corner[k] = 1;
      return corner;
    }
  }
  for (std::size_t k = 0; k < 3; ++k) {
    if (base.neighbors[face][k] != p.face) continue;
    const std::size_t next = (k + 1) % 3, far = (k + 2) % 3;
    Weights out{};
    for (std::size_t c = 0; c < 3; ++c) {
      if (other[c] == own[k]) {
        out[k] += p.weight[c];
      } else if (other[c] == own[next]) {
        out[next] += p.weight[c];
      } else {  // the far corner's mirror image: far = k + next - mirrored
        out[k] += p.weight[c];
        out[next] += p.weight[c];
        out[far] -= p.weight[c];
      }
    }
    return out;
  }
  return std::nullopt;
}

/// The reverse: where such weights lie.
remesh::DomainPoint located(const remesh::BaseMesh& base, std::uint32_t face, const Weights& w) {
  for (std::size_t far = 0; far < 3; ++far) {
    const std::size_t k = (far + 1) % 3, next = (far + 2) % 3;
    const std::uint32_t across = base.neighbors[face][k];
    if (w[far] >= 0 || across == kNone) continue;
    const Triangle& own = base.triangles[face];
    remesh::DomainPoint out{across, {}};
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t v = base.triangles[across][c];
      out.weight[c] = v == own[k] ? w[k] + w[far] : v == own[next] ? w[next] + w[far] : -w[far];
    }
    return out;
  }
  return {face, w};
}

/// A scan triangle as it lies in the domain, seen from `face`; kNone if it lies in too many.
struct Image {
  std::uint32_t face = kNone;
  std::array<Weights, 3> corner{};
  double inside = -std::numeric_limits<double>::infinity();  ///< the least weight
};

/// Seen from the base triangle that it lies in most: from the wrong side of a base corner it would
/// seem to lie around it.
Image image_of(const remesh::Parameterisation& map, const Triangle& t) {
  Image best;
  const auto look_from = [&](std::uint32_t face) {
    Image image{face, {}, 0};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto weights = seen_from(map.base, map.point[t[k]], face);
      if (!weights) return;
      image.corner[k] = *weights;
      image.inside = std::min(image.inside, *std::min_element(weights->begin(), weights->end()));
    }
    if (image.inside > best.inside) best = image;
  };
  for (const std::uint32_t v : t) look_from(map.point[v].face);
  if (best.inside == 0) return best;
  for (const std::uint32_t v : t)
    for (const std::uint32_t face : map.base.neighbors[map.point[v].face])
      if (face != kNone) look_from(face);
  return best;
}

/// The larger over the smaller singular value of the map of a triangle into the plane of a base
/// triangle of unit sides.
float anisotropy(const std::array<Vec3, 3>& corner, const Image& image) {
  const auto place = [&](std::size_t k) {
    const Weights& w = image.corner[k];
    return Eigen::Vector2d(w[1] + w[2] / 2, w[2] * std::sqrt(3.0) / 2);
  };
  const Vec3 e = corner[1] - corner[0], g = corner[2] - corner[0];
  const double length = norm(e), area = norm(cross(e, g));
  if (!(length > 0) || !(area > 0)) return 0;
  Eigen::Matrix2d from, to;
  from << length, dot(e, g) / length, 0, area / length;
  to << place(1) - place(0), place(2) - place(0);
  const Eigen::Matrix2d map = to * from.inverse();
  // The sum of the squares of the singular values, and their product, give both.
  const double sum = map.squaredNorm(), product = std::abs(map.determinant());
  const double spread = std::sqrt(std::max(0.0, sum * sum - 4 * product * product));
  constexpr double kMost = 1e6;  // a triangle that the map flattens
  return static_cast<float>(
      std::sqrt(std::min((sum + spread) / std::max(sum - spread, 1e-300), kMost * kMost)));
}

/// Corners of child `child` of a triangle with these corners, numbered as in Topology.
std::array<Weights, 3> child_of(const std::array<Weights, 3>& corner, std::size_t child) {
  const auto middle = [&](std::size_t side) {
    Weights m{};
    for (std::size_t i = 0; i < 3; ++i) m[i] = (corner[side][i] + corner[(side + 1) % 3][i]) / 2;
    return m;
  };
  if (child == 3) return {middle(0), middle(1), middle(2)};
  return {corner[child], middle(child), middle((child + 2) % 3)};
}

Rgb color_at(const remesh::DomainPoint& p, std::size_t first_face, int cells) {
  if (std::min({p.weight[0], p.weight[1], p.weight[2]}) < kBorder) return kBorderDark;
  const double hue = hue_of(first_face + p.face);
  int whole = 0;  // cells - 1 in cells that stand as the triangle does, cells - 2 in the others
  for (const double w : p.weight) whole += static_cast<int>(std::floor(w * cells));
  return whole == cells - 2 ? from_hsv(hue, 0.25, 0.98) : from_hsv(hue, 0.6, 0.8);
}

/// A base triangle cut into cells², as fine as the triangles can show.
int checker_cells(std::size_t triangles, std::size_t base_triangles) {
  int cells = 1;
  while (cells < 8 &&
         4 * static_cast<std::size_t>(cells * cells) * kTrianglesPerCell * base_triangles <=
             triangles)
    cells *= 2;
  return cells;
}

struct SplitScan {
  Scan scan;
  int splits = 0;
};

SplitScan split(const Scan& scan) {
  SplitScan out;
  while (out.splits < kMostSplits &&
         (scan.triangles.size() << (2 * (out.splits + 1))) <= kMostTriangles)
    ++out.splits;
  const auto topology = Topology::build(
      scan.triangles, static_cast<std::uint32_t>(scan.positions.size()), out.splits);
  if (!topology) return {scan, 0};
  out.scan = {scan.positions, topology->level(out.splits).triangles, scan.origin};
  for (int level = 0; level < out.splits; ++level)
    for (const Edge& e : topology->level(level).edges)
      out.scan.positions.push_back(
          (out.scan.positions[e.vertex[0]] + out.scan.positions[e.vertex[1]]) / 2);
  return out;
}

}  // namespace

DumpMesh dump_parameterisation(const Scan& scan, const remesh::Parameterisation& map,
                               std::size_t first_face) {
  SplitScan fine = split(scan);
  DumpMesh dump;
  dump.mesh = std::move(fine.scan);
  dump.comments = {
      "parameterisation: a hue per base triangle, cut as some splits cut it",
      "quality of a face: the larger over the smaller singular value of the map; 0: not known"};
  const std::size_t children = std::size_t{1} << (2 * fine.splits);
  const std::size_t count = dump.mesh.triangles.size();
  const int cells = checker_cells(count, map.base.triangles.size());
  dump.face_quality.assign(count, 0);
  dump.face_color.assign(count, kBorderDark);
  parallel_for_each_index(count / children, [&](std::size_t f) {
    const Triangle& t = scan.triangles[f];
    const Image image = image_of(map, t);
    if (image.face == kNone) return;
    const float quality =
        anisotropy({scan.positions[t[0]], scan.positions[t[1]], scan.positions[t[2]]}, image);
    for (std::size_t i = f * children; i < (f + 1) * children; ++i) {
      std::array<Weights, 3> corner = image.corner;
      for (int level = fine.splits - 1; level >= 0; --level)
        corner = child_of(corner, (i >> (2 * level)) & 3);
      Weights centroid{};
      for (const Weights& w : corner)
        for (std::size_t k = 0; k < 3; ++k) centroid[k] += w[k] / 3;
      dump.face_quality[i] = quality;
      dump.face_color[i] = color_at(located(map.base, image.face, centroid), first_face, cells);
    }
  });
  return dump;
}

}  // namespace nacre::app
