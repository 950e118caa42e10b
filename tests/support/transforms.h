// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "base/scan.h"
#include "random.h"  // beside this file, for programs outside of tests/ as well

/// The same scan in another guise: what a remesher must not care about, or not much.
namespace nacre::transforms {

/// A rotation drawn uniformly, about the scan's own origin.
inline Scan rotated(Scan scan, std::uint64_t seed) {
  TestRandom random(seed);
  Eigen::Vector4d q;  // uniform on the sphere: rejected from the cube
  do {
    const Vec3 p = random.point();
    q << p, random.signed_unit();
  } while (q.norm() > 1 || q.norm() < 0.1);
  q.normalize();
  const Eigen::Matrix3d turn = Eigen::Quaterniond(q).toRotationMatrix();
  for (Vec3& p : scan.positions) p = turn * p;
  return scan;
}

inline Scan scaled(Scan scan, double by) {
  for (Vec3& p : scan.positions) p *= by;
  scan.origin *= by;
  return scan;
}

/// The positions themselves move, and lose the digits that this costs; `origin` stays.
inline Scan moved_away(Scan scan, double by) {
  for (Vec3& p : scan.positions) p += Vec3(by, -by, by);
  return scan;
}

/// Vertices and triangles in another order; a triangle begins at another of its corners.
inline Scan renumbered(const Scan& scan, std::uint64_t seed) {
  TestRandom random(seed);
  const std::vector<std::uint32_t> vertex = random.permutation(scan.positions.size());
  const std::vector<std::uint32_t> face = random.permutation(scan.triangles.size());
  Scan out = scan;
  for (std::size_t v = 0; v < vertex.size(); ++v) out.positions[vertex[v]] = scan.positions[v];
  for (std::size_t f = 0; f < face.size(); ++f) {
    const std::size_t turn = random.below(3);
    for (std::size_t k = 0; k < 3; ++k)
      out.triangles[face[f]][k] = vertex[scan.triangles[f][(k + turn) % 3]];
  }
  return out;
}

/// Every triangle is turned over with probability one half.
inline Scan half_flipped(Scan scan, std::uint64_t seed) {
  TestRandom random(seed);
  for (Triangle& t : scan.triangles)
    if (random.below(2) == 1) std::swap(t[1], t[2]);
  return scan;
}

inline double mean_edge(const Scan& scan) {
  double sum = 0;
  for (const Triangle& t : scan.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      sum += (scan.positions[t[k]] - scan.positions[t[(k + 1) % 3]]).norm();
  return sum / (3 * static_cast<double>(std::max<std::size_t>(scan.triangles.size(), 1)));
}

/// Every vertex moves by `share` of the mean edge in a direction of its own; vertices at the same
/// place stay together, so that what cleaning welds it still welds.
inline Scan with_noise(Scan scan, double share, std::uint64_t seed) {
  const double length = share * mean_edge(scan);
  for (Vec3& p : scan.positions) {
    std::uint64_t key = seed;
    for (int k = 0; k < 3; ++k)
      key = TestRandom(key ^ std::bit_cast<std::uint64_t>(p[k] + 0.0)).bits();
    p += length * TestRandom(key).direction();
  }
  return scan;
}

inline constexpr std::array<const char*, 6> kNames = {"rotated",    "scaled",       "moved",
                                                      "renumbered", "half flipped", "noise"};

/// One of kNames with the sizes that are meant for all scans: x 1000, by 10^6, 1 % noise. Any other
/// name: the scan itself.
inline Scan named(const Scan& scan, const std::string& name, std::uint64_t seed) {
  if (name == "rotated") return rotated(scan, seed);
  if (name == "scaled") return scaled(scan, 1000);
  if (name == "moved") return moved_away(scan, 1e6);
  if (name == "renumbered") return renumbered(scan, seed);
  if (name == "half flipped") return half_flipped(scan, seed);
  if (name == "noise") return with_noise(scan, 0.01, seed);
  return scan;
}

}  // namespace nacre::transforms
