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
  return {{{-s, l, 0},
           {s, l, 0},
           {-s, -l, 0},
           {s, -l, 0},
           {0, -s, l},
           {0, s, l},
           {0, -s, -l},
           {0, s, -l},
           {l, 0, -s},
           {l, 0, s},
           {-l, 0, -s},
           {-l, 0, s}},
          {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
           {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
           {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};
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

namespace nacre::shapes {

/// Both scans as one; the second one's ids follow the first one's.
inline Scan joined(const Scan& a, const Scan& b) {
  Scan scan = a;
  const auto offset = static_cast<std::uint32_t>(a.positions.size());
  scan.positions.insert(scan.positions.end(), b.positions.begin(), b.positions.end());
  for (const Triangle& t : b.triangles)
    scan.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  return scan;
}

/// Enclosed by a closed scan that is oriented outward.
inline double volume(const Scan& scan) {
  double six = 0;
  for (const Triangle& t : scan.triangles)
    six += scan.positions[t[0]].dot(scan.positions[t[1]].cross(scan.positions[t[2]]));
  return six / 6;
}

inline Scan moved(Scan scan, const Vec3& by) {
  for (Vec3& p : scan.positions) p += by;
  return scan;
}

/// Every triangle with three vertices of its own.
inline Scan exploded(const Scan& scan) {
  Scan out;
  for (const Triangle& t : scan.triangles) {
    const auto n = static_cast<std::uint32_t>(out.positions.size());
    for (const std::uint32_t v : t) out.positions.push_back(scan.positions[v]);
    out.triangles.push_back({n, n + 1, n + 2});
  }
  return out;
}

/// The triangles that `keep(index)` wants, without the vertices that they leave unused.
template <class Keep>
Scan only(const Scan& scan, const Keep& keep) {
  Scan out;
  std::vector<std::uint32_t> id(scan.positions.size(), kNone);
  for (std::size_t f = 0; f < scan.triangles.size(); ++f) {
    if (!keep(f)) continue;
    Triangle moved{};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = scan.triangles[f][k];
      if (id[v] == kNone) {
        id[v] = static_cast<std::uint32_t>(out.positions.size());
        out.positions.push_back(scan.positions[v]);
      }
      moved[k] = id[v];
    }
    out.triangles.push_back(moved);
  }
  return out;
}

/// Upper half of the unit sphere; its boundary, one loop, lies in z = 0.
inline Scan hemisphere(int levels) {
  const Scan whole = sphere(levels);
  return only(whole, [&](std::size_t f) {
    for (const std::uint32_t v : whole.triangles[f])
      if (whole.positions[v][2] < -1e-12) return false;
    return true;
  });
}

/// n × n grid without the squares i, k with low <= i, k < high; two boundary loops.
inline Scan holed_grid(std::uint32_t n, std::uint32_t low, std::uint32_t high) {
  return only(grid(n, n), [&](std::size_t f) {
    const std::size_t i = f / 2 / n, k = f / 2 % n;
    return i < low || i >= high || k < low || k >= high;
  });
}

/// Every triangle split 1→4 `levels` times, flat.
inline Scan split(const Scan& scan, int levels) {
  const Topology topology =
      *Topology::build(scan.triangles, static_cast<std::uint32_t>(scan.positions.size()), levels);
  Scan out{scan.positions, topology.level(levels).triangles, scan.origin};
  for (int j = 0; j < levels; ++j)
    for (const Edge& e : topology.level(j).edges)
      out.positions.push_back((out.positions[e.vertex[0]] + out.positions[e.vertex[1]]) / 2);
  return out;
}

/// A plate 2 genus + 1 long, 3 wide and 1 high, with `genus` square holes through it; sharp edges.
inline Scan plate(int genus) {
  const int nx = 2 * genus + 1, ny = 3;
  const auto solid = [&](int x, int y) {
    return x >= 0 && x < nx && y >= 0 && y < ny && !(x % 2 == 1 && y == 1);
  };
  Scan scan;
  for (int x = 0; x <= nx; ++x)
    for (int y = 0; y <= ny; ++y)
      for (int z = 0; z < 2; ++z) scan.positions.emplace_back(x, y, z);
  const auto id = [&](int x, int y, int z) {
    return static_cast<std::uint32_t>((x * (ny + 1) + y) * 2 + z);
  };
  const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    scan.triangles.push_back({a, b, c});
    scan.triangles.push_back({a, c, d});
  };
  for (int x = 0; x < nx; ++x) {
    for (int y = 0; y < ny; ++y) {
      if (!solid(x, y)) continue;
      const int X = x + 1, Y = y + 1;
      quad(id(x, y, 1), id(X, y, 1), id(X, Y, 1), id(x, Y, 1));
      quad(id(x, y, 0), id(x, Y, 0), id(X, Y, 0), id(X, y, 0));
      if (!solid(x - 1, y)) quad(id(x, y, 0), id(x, y, 1), id(x, Y, 1), id(x, Y, 0));
      if (!solid(X, y)) quad(id(X, y, 0), id(X, Y, 0), id(X, Y, 1), id(X, y, 1));
      if (!solid(x, y - 1)) quad(id(x, y, 0), id(X, y, 0), id(X, y, 1), id(x, y, 1));
      if (!solid(x, Y)) quad(id(x, Y, 0), id(x, Y, 1), id(X, Y, 1), id(X, Y, 0));
    }
  }
  return scan;
}

/// A band of n squares with half a twist.
inline Scan moebius(std::uint32_t n) {
  Scan scan;
  for (std::uint32_t i = 0; i < n; ++i) {
    const double u = 2 * M_PI * i / n;
    for (const double side : {-0.4, 0.4}) {
      const double r = 1 + side * std::cos(u / 2);
      scan.positions.emplace_back(r * std::cos(u), r * std::sin(u), side * std::sin(u / 2));
    }
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t a = 2 * i, b = 2 * i + 1;
    const std::uint32_t c = i + 1 < n ? 2 * i + 2 : 1, d = i + 1 < n ? 2 * i + 3 : 0;
    scan.triangles.push_back({a, c, d});
    scan.triangles.push_back({a, d, b});
  }
  return scan;
}

/// A star-shaped body with bumps: sphere(levels) with radius 1 + a sum of smooth waves.
inline Scan bumpy_sphere(int levels, double height = 0.15) {
  Scan scan = sphere(levels);
  for (Vec3& p : scan.positions) {
    p *= 1 + height * (std::sin(3 * p[0] + 1) * std::cos(2 * p[1]) + std::sin(4 * p[2] + p[0]));
  }
  return scan;
}

}  // namespace nacre::shapes
