// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "base/scan.h"

/// Small meshes with known properties, made in code. All closed ones face outward.
namespace nacre::shapes {

inline Scan tetrahedron() {
  return {{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}},
          {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}}};
}

inline Scan octahedron() {
  return {{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
          {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
}

/// Unit icosahedron: 12 vertices of valence 5.
inline Scan icosahedron() {
  const double g = (1.0 + std::sqrt(5.0)) / 2.0, s = 1.0 / std::sqrt(1.0 + g * g), l = g * s;
  return {{{-s, l, 0}, {s, l, 0}, {-s, -l, 0}, {s, -l, 0}, {0, -s, l}, {0, s, l},
           {0, -s, -l}, {0, s, -l}, {l, 0, -s}, {l, 0, s}, {-l, 0, -s}, {-l, 0, s}},
          {{0, 11, 5}, {0, 5, 1}, {0, 1, 7}, {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
           {11, 10, 2}, {10, 7, 6}, {7, 1, 8}, {3, 9, 4}, {3, 4, 2}, {3, 2, 6}, {3, 6, 8},
           {3, 8, 9}, {4, 9, 5}, {2, 4, 11}, {6, 2, 10}, {8, 6, 7}, {9, 8, 1}}};
}

/// n × m torus about the z axis, all vertices of valence 6; genus 1.
inline Scan torus(std::uint32_t n, std::uint32_t m, double major = 1.0, double minor = 0.4) {
  Scan scan;
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t k = 0; k < m; ++k) {
      const double u = 2 * M_PI * i / n, v = 2 * M_PI * k / m;
      const double r = major + minor * std::cos(v);
      scan.positions.emplace_back(r * std::cos(u), r * std::sin(u), minor * std::sin(v));
    }
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t k = 0; k < m; ++k) {
      const std::uint32_t i1 = (i + 1) % n, k1 = (k + 1) % m;
      scan.triangles.push_back({i * m + k, i1 * m + k, i1 * m + k1});
      scan.triangles.push_back({i * m + k, i1 * m + k1, i * m + k1});
    }
  }
  return scan;
}

/// Flat n × m grid of unit squares in the plane z = 0; one boundary loop.
inline Scan grid(std::uint32_t n, std::uint32_t m) {
  Scan scan;
  for (std::uint32_t i = 0; i <= n; ++i)
    for (std::uint32_t k = 0; k <= m; ++k) scan.positions.emplace_back(i, k, 0.0);
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t k = 0; k < m; ++k) {
      const std::uint32_t a = i * (m + 1) + k, b = (i + 1) * (m + 1) + k;
      scan.triangles.push_back({a, b, b + 1});
      scan.triangles.push_back({a, b + 1, a + 1});
    }
  }
  return scan;
}

/// Unit sphere: an octahedron split 1→4 `levels` times, every vertex pushed to radius 1.
inline Scan sphere(int levels);

}  // namespace nacre::shapes

#include "base/topology.h"

namespace nacre::shapes {

inline Scan sphere(int levels) {
  const Scan base = octahedron();
  const Topology topology = *Topology::build(base.triangles, 6, levels);
  Scan scan;
  scan.positions = base.positions;
  for (int j = 0; j < levels; ++j) {
    for (const Edge& e : topology.level(j).edges) {
      const Vec3 m = scan.positions[e.vertex[0]] + scan.positions[e.vertex[1]];
      scan.positions.push_back(m / m.norm());
    }
  }
  scan.triangles = topology.level(levels).triangles;
  return scan;
}

}  // namespace nacre::shapes
