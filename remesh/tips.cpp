// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/tips.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace nacre::remesh {
namespace {

constexpr double kMostAngle = 2 * M_PI / 3;
constexpr double kLeastLength = 2;  // in mean edges

}  // namespace

std::vector<std::uint32_t> tips_of(const Scan& scan) {
  const std::size_t n = scan.positions.size();
  std::vector<double> shortest(n, std::numeric_limits<double>::infinity()), angle(n, 0);
  // Around an inner vertex each neighbour comes once before and once after another.
  std::vector<std::uint32_t> open(n, 0);
  double sum = 0;
  for (const Triangle& t : scan.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = t[k], next = t[(k + 1) % 3], last = t[(k + 2) % 3];
      const double length = (scan.positions[next] - scan.positions[v]).norm();
      sum += length;
      shortest[v] = std::min(shortest[v], length);
      open[v] += next - last;
    }
  }
  const double least = kLeastLength * sum / (3 * static_cast<double>(scan.triangles.size()));
  for (const Triangle& t : scan.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (!(shortest[t[k]] > least)) continue;
      const Vec3 a = scan.positions[t[(k + 1) % 3]] - scan.positions[t[k]];
      const Vec3 b = scan.positions[t[(k + 2) % 3]] - scan.positions[t[k]];
      angle[t[k]] += std::atan2(a.cross(b).norm(), a.dot(b));
    }
  }
  std::vector<std::uint32_t> tips;
  for (std::uint32_t v = 0; v < n; ++v)
    if (open[v] == 0 && angle[v] > 0 && angle[v] < kMostAngle) tips.push_back(v);
  return tips;
}

std::vector<char> vertices_at_tips(const Scan& scan) {
  std::vector<char> is_tip(scan.positions.size(), 0), at_tip;
  for (const std::uint32_t v : tips_of(scan)) is_tip[v] = 1;
  at_tip = is_tip;
  for (const Triangle& t : scan.triangles)
    if (is_tip[t[0]] != 0 || is_tip[t[1]] != 0 || is_tip[t[2]] != 0)
      for (const std::uint32_t v : t) at_tip[v] = 1;
  return at_tip;
}

std::vector<char> held_vertices(const Scan& scan, const Parameterisation& map) {
  std::vector<char> held = pinned_vertices(map);
  const std::vector<char> at_tip = vertices_at_tips(scan);
  for (const std::uint32_t v : map.base.scan_vertex)
    if (at_tip[v] != 0) held[v] = 1;
  return held;
}

}  // namespace nacre::remesh
