// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "base/semi_regular_mesh.h"
#include "support/shapes.h"

/// Base meshes and signals for the transform's tests, in libm-free arithmetic where bits matter.
namespace nacre::wavelet::testing {

/// SplitMix64; doubles in [-1, 1).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }
  double signed_unit() { return static_cast<double>(bits() >> 11) * 0x1p-52 - 1.0; }
  Vec3 point() {
    const double x = signed_unit(), y = signed_unit();
    return {x, y, signed_unit()};
  }

 private:
  std::uint64_t state_;
};

inline std::vector<Vec3> random_points(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<Vec3> points(count);
  for (Vec3& p : points) p = random.point();
  return points;
}

/// Random base positions and details that shrink by half per band.
inline Pyramid random_pyramid(const Topology& topology, std::uint64_t seed) {
  Pyramid pyramid;
  pyramid.base_positions = random_points(topology.level(0).vertex_count, seed);
  double scale = 0.25;
  for (int j = 0; j < topology.level_count(); ++j, scale *= 0.5) {
    auto& band = pyramid.bands.emplace_back(random_points(topology.band_size(j), ++seed));
    for (Vec3& d : band) d *= scale;
  }
  return pyramid;
}

/// K triangles around vertex 0, whose ring is 1 .. K; closed by a second apex K + 1 if asked.
inline Scan cone(std::uint32_t K, bool closed) {
  Scan scan;
  scan.positions = random_points(K + 1 + (closed ? 1 : 0), K);
  for (std::uint32_t i = 0; i < K; ++i) {
    const std::uint32_t a = 1 + i, b = 1 + (i + 1) % K;
    scan.triangles.push_back({0, a, b});
    if (closed) scan.triangles.push_back({K + 1, b, a});
  }
  return scan;
}

inline std::vector<std::uint32_t> valences(const Scan& scan) {
  std::vector<std::uint32_t> count(scan.positions.size(), 0);
  const Topology topology =
      *Topology::build(scan.triangles, static_cast<std::uint32_t>(scan.positions.size()), 0);
  for (const Edge& e : topology.level(0).edges)
    for (const std::uint32_t v : e.vertex) ++count[v];
  return count;
}

/// A sphere whose edges were flipped at random, valences kept within 3 .. 12.
inline Scan flipped_sphere(int levels, int flips, std::uint64_t seed) {
  Scan scan = shapes::sphere(levels);
  Random random(seed);
  std::vector<std::uint32_t> valence = valences(scan);
  for (int i = 0; i < flips; ++i) {
    const Topology topology =
        *Topology::build(scan.triangles, static_cast<std::uint32_t>(scan.positions.size()), 0);
    const LevelTopology& level = topology.level(0);
    const std::size_t e = random.bits() % level.edges.size();
    const auto [a, b] = level.edges[e].vertex;
    const auto [f, g] = level.edges[e].face;
    const std::uint32_t c = level.opposite_corner(f, static_cast<std::uint32_t>(e));
    const std::uint32_t d = level.opposite_corner(g, static_cast<std::uint32_t>(e));
    const bool joined = std::any_of(level.edges.begin(), level.edges.end(), [&](const Edge& x) {
      return (x.vertex[0] == c && x.vertex[1] == d) || (x.vertex[0] == d && x.vertex[1] == c);
    });
    if (joined || c == d || valence[a] <= 3 || valence[b] <= 3 || valence[c] >= 12 ||
        valence[d] >= 12)
      continue;
    scan.triangles[f] = {c, d, b};
    scan.triangles[g] = {d, c, a};
    --valence[a], --valence[b], ++valence[c], ++valence[d];
  }
  return scan;
}

inline Scan join(const Scan& a, const Scan& b) {
  Scan scan = a;
  const auto offset = static_cast<std::uint32_t>(a.positions.size());
  scan.positions.insert(scan.positions.end(), b.positions.begin(), b.positions.end());
  for (const Triangle& t : b.triangles)
    scan.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  return scan;
}

/// Two tetrahedra that share one vertex; its ring falls into two fans.
inline Scan bow_tie() {
  Scan scan = shapes::tetrahedron();
  for (const Triangle& t : shapes::tetrahedron().triangles) {
    Triangle moved;
    for (std::size_t k = 0; k < 3; ++k) moved[k] = t[k] == 0 ? 0 : t[k] + 3;
    scan.triangles.push_back(moved);
  }
  scan.positions = random_points(7, 77);
  return scan;
}

inline Topology topology_of(const Scan& scan, int levels) {
  return *Topology::build(scan.triangles, static_cast<std::uint32_t>(scan.positions.size()),
                          levels);
}

/// Everything a transform can meet: closed, genus 1, open, several components, odd valences.
inline std::vector<std::pair<std::string, Scan>> zoo() {
  Scan isolated = shapes::tetrahedron();
  isolated.positions.insert(isolated.positions.end(), {{5, 5, 5}, {6, 6, 6}});
  return {{"tetrahedron", shapes::tetrahedron()},
          {"icosahedron", shapes::icosahedron()},
          {"torus", shapes::torus(5, 4)},
          {"grid", shapes::grid(3, 4)},
          {"one triangle", {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}}},
          {"disk of 9", cone(9, false)},
          {"flipped sphere", flipped_sphere(2, 400, 5)},
          {"three components", join(join(shapes::grid(2, 2), shapes::torus(4, 3)), cone(3, true))},
          {"two-sided triangle", {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}}}},
          {"bow tie", bow_tie()},
          {"isolated vertices", isolated}};
}

}  // namespace nacre::wavelet::testing
