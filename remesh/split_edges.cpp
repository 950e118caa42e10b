// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/split_edges.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "remesh/adjacency.h"
#include "remesh/tips.h"

namespace nacre::remesh {
namespace {

/// Shares of the extent: shorter sides would cut needles to dust; less area is rounding.
constexpr double kLeastSide = 1e-3, kLeastArea = 1e-15;

/// One order of all edges, the same seen from either face: by length, then by vertex ids. The ids
/// are mixed first: in a regular strip of equal edges, ids as they are would let each edge wait for
/// the one before it.
using EdgeKey = std::tuple<double, std::uint64_t, std::uint32_t>;

std::uint64_t mixed(std::uint64_t x) {  // [Steele2014] SplitMix64
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}

EdgeKey key_of_side(const Scan& scan, const Triangle& t, std::uint32_t k) {
  const std::uint32_t a = std::min(t[k], t[(k + 1) % 3]), b = std::max(t[k], t[(k + 1) % 3]);
  return {(scan.positions[a] - scan.positions[b]).squaredNorm(),
          mixed((std::uint64_t{a} << 32 | b) + 0x9E3779B97F4A7C15u), a};
}

std::uint32_t longest_side(const Scan& scan, const Triangle& t) {
  std::uint32_t best = 0;
  for (std::uint32_t k = 1; k < 3; ++k)
    if (key_of_side(scan, t, k) > key_of_side(scan, t, best)) best = k;
  return best;
}

/// Cuts face f from the middle of side k to the opposite corner; the new face takes the second
/// half.
void cut_face(CleanScan& cleaned, std::uint32_t f, std::uint32_t k, std::uint32_t middle) {
  auto& triangles = cleaned.scan.triangles;
  const Triangle t = triangles[f];
  triangles[f][(k + 1) % 3] = middle;
  Triangle second = t;
  second[k] = middle;
  triangles.push_back(second);
  cleaned.piece.push_back(cleaned.piece[f]);
}

/// One pass; true if anything was split.
bool split_once(CleanScan& cleaned, double longest, const std::vector<std::uint32_t>& tips) {
  Scan& scan = cleaned.scan;
  const auto& triangles = scan.triangles;
  const auto neighbors =
      side_neighbors(triangles, static_cast<std::uint32_t>(scan.positions.size()));
  const auto faces = static_cast<std::uint32_t>(triangles.size());
  std::vector<std::uint8_t> side(faces);
  for (std::uint32_t f = 0; f < faces; ++f)
    side[f] = static_cast<std::uint8_t>(longest_side(scan, triangles[f]));
  const auto is_at_tip = [&](std::uint32_t f) {
    return std::any_of(triangles[f].begin(), triangles[f].end(), [&](std::uint32_t v) {
      return std::binary_search(tips.begin(), tips.end(), v);
    });
  };
  bool any = false;
  for (std::uint32_t f = 0; f < faces; ++f) {
    const std::uint32_t k = side[f];
    const std::uint32_t other = neighbors[f][k];
    // Once cut, a face has another longest side; its entry in `side` then no longer names this
    // edge, so each edge is met from its lower face only, and each face is cut at most once a pass.
    if (other != kNone && (other < f || neighbors[other][side[other]] != f)) continue;
    const std::uint32_t a = triangles[f][k], b = triangles[f][(k + 1) % 3];
    if ((scan.positions[a] - scan.positions[b]).norm() <= longest) continue;
    if (is_at_tip(f) || (other != kNone && is_at_tip(other))) continue;
    const auto middle = static_cast<std::uint32_t>(scan.positions.size());
    scan.positions.push_back((scan.positions[a] + scan.positions[b]) / 2);
    cut_face(cleaned, f, k, middle);
    if (other != kNone) cut_face(cleaned, other, side[other], middle);
    any = true;
  }
  return any;
}

/// One pass, in which a face is cut at most once; true if anything was split.
bool split_chords_once(CleanScan& cleaned) {
  Scan& scan = cleaned.scan;
  const auto neighbors =
      side_neighbors(scan.triangles, static_cast<std::uint32_t>(scan.positions.size()));
  const auto faces = static_cast<std::uint32_t>(scan.triangles.size());
  std::vector<char> on_boundary(scan.positions.size(), 0), cut(faces, 0);
  for (std::uint32_t f = 0; f < faces; ++f)
    for (std::uint32_t k = 0; k < 3; ++k)
      if (neighbors[f][k] == kNone)
        on_boundary[scan.triangles[f][k]] = on_boundary[scan.triangles[f][(k + 1) % 3]] = 1;
  bool any = false;
  for (std::uint32_t f = 0; f < faces; ++f) {
    for (std::uint32_t k = 0; k < 3 && !cut[f]; ++k) {
      const std::uint32_t other = neighbors[f][k];
      const std::uint32_t a = scan.triangles[f][k], b = scan.triangles[f][(k + 1) % 3];
      if (other == kNone || cut[other] || !on_boundary[a] || !on_boundary[b]) continue;
      const auto middle = static_cast<std::uint32_t>(scan.positions.size());
      scan.positions.push_back((scan.positions[a] + scan.positions[b]) / 2);
      const std::uint32_t side = corner_of(scan.triangles[other], b);
      cut_face(cleaned, f, k, middle);
      cut_face(cleaned, other, side, middle);
      cut[f] = cut[other] = 1;
      any = true;
    }
  }
  return any;
}

}  // namespace

void split_chords(CleanScan& cleaned) {
  while (split_chords_once(cleaned)) {
  }
}

void split_long_edges(CleanScan& cleaned, double longest, std::size_t most_triangles) {
  const std::vector<std::uint32_t> tips = tips_of(cleaned.scan);
  while (cleaned.scan.triangles.size() < most_triangles && split_once(cleaned, longest, tips)) {
  }
}

double side_for_count(const Scan& scan, double count) {
  double area = 0;
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Triangle& t : scan.triangles) {
    area += (scan.positions[t[1]] - scan.positions[t[0]])
                .cross(scan.positions[t[2]] - scan.positions[t[0]])
                .norm() /
            2;
    for (const std::uint32_t v : t) {
      low = low.cwiseMin(scan.positions[v]);
      high = high.cwiseMax(scan.positions[v]);
    }
  }
  const double extent = (high - low).norm();
  if (!(area > kLeastArea * extent * extent)) return 0;
  return std::max(std::sqrt(area / count * 4 / std::sqrt(3.0)), kLeastSide * extent);
}

}  // namespace nacre::remesh
