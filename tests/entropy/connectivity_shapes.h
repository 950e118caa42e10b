// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "entropy/closed_mesh.h"
#include "entropy/connectivity.h"
#include "tests/support/shapes.h"

/// Connectivities to code: shapes of known genus and boundaries, and random changes to them.
namespace nacre::entropy::test {

struct Surface {
  std::vector<Triangle> triangles;
  std::uint32_t vertex_count = 0;
};

/// The same numbers on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15u + 1) {}
  std::uint32_t below(std::uint32_t bound) {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::uint32_t>(((state_ >> 32) * bound) >> 32);
  }

 private:
  std::uint64_t state_;
};

inline std::vector<GridPoint> random_points(std::uint32_t count, int bits, Random& random) {
  std::vector<GridPoint> points(count);
  for (GridPoint& p : points)
    for (std::int32_t& x : p) x = static_cast<std::int32_t>(random.below(1u << bits));
  return points;
}

/// One bit flipped in even rounds, nothing as it was in odd ones.
inline std::vector<std::uint8_t> damaged(std::vector<std::uint8_t> bytes, int round,
                                         Random& random) {
  if (round % 2 == 0) {
    bytes[random.below(static_cast<std::uint32_t>(bytes.size()))] ^=
        static_cast<std::uint8_t>(1u << random.below(8));
  } else {
    for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(random.below(256));
  }
  return bytes;
}

/// `decode(bytes)` of every proper prefix is an error.
template <class Decode>
void expect_every_truncation_is_corrupt(const std::vector<std::uint8_t>& full,
                                        const Decode& decode) {
  for (std::size_t size = 0; size < full.size(); ++size) {
    const auto decoded = decode(std::vector<std::uint8_t>(full.data(), full.data() + size));
    ASSERT_FALSE(decoded.has_value());
    EXPECT_EQ(decoded.error().code, ErrorCode::kCorruptStream);
  }
}

inline Surface from_scan(const Scan& scan) {
  return {scan.triangles, static_cast<std::uint32_t>(scan.positions.size())};
}
inline Surface sphere(int levels) { return from_scan(shapes::sphere(levels)); }

/// Drops unused vertices.
inline Surface compacted(const std::vector<Triangle>& triangles) {
  std::map<std::uint32_t, std::uint32_t> ids;
  Surface surface;
  for (const Triangle& t : triangles) {
    Triangle u;
    for (std::size_t k = 0; k < 3; ++k)
      u[k] = ids.emplace(t[k], static_cast<std::uint32_t>(ids.size())).first->second;
    surface.triangles.push_back(u);
  }
  surface.vertex_count = static_cast<std::uint32_t>(ids.size());
  return surface;
}

inline void append(Surface& surface, const Surface& other) {
  for (const Triangle& t : other.triangles) {
    const std::uint32_t n = surface.vertex_count;
    surface.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
  }
  surface.vertex_count += other.vertex_count;
}

/// Vertices, triangles and first corners in random order.
inline Surface renumbered(Surface surface, Random& random) {
  std::vector<std::uint32_t> ids(surface.vertex_count);
  for (std::uint32_t i = 0; i < ids.size(); ++i) {
    ids[i] = i;
    std::swap(ids[i], ids[random.below(i + 1)]);
  }
  for (std::uint32_t i = 0; i < surface.triangles.size(); ++i) {
    const Triangle t = surface.triangles[i];
    const std::uint32_t k = random.below(3);
    surface.triangles[i] = {ids[t[k]], ids[t[(k + 1) % 3]], ids[t[(k + 2) % 3]]};
    std::swap(surface.triangles[i], surface.triangles[random.below(i + 1)]);
  }
  return surface;
}

/// Flips random edges of a closed surface, keeping it simple.
inline Surface flipped(Surface surface, std::uint32_t flips, Random& random) {
  ClosedMesh mesh = *close_mesh(surface.triangles, surface.vertex_count);
  const auto sides = static_cast<std::uint32_t>(mesh.twins.size());
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::uint32_t h = 0; h < sides; ++h) edges.emplace(mesh.from(h), mesh.from(next_side(h)));
  for (; flips > 0; --flips) {
    // Triangles (a, b, c) and (b, a, d) become (c, a, d) and (d, b, c).
    const std::uint32_t h = random.below(sides), g = mesh.twins[h];
    const std::uint32_t a = mesh.from(h), b = mesh.from(g);
    const std::uint32_t c = mesh.from(previous_side(h)), d = mesh.from(previous_side(g));
    if (c == d || edges.count({c, d}) > 0) continue;
    edges.erase({a, b});
    edges.erase({b, a});
    edges.insert({{c, d}, {d, c}});
    const std::uint32_t f = 3 * (h / 3), e = 3 * (g / 3);
    const std::array<std::uint32_t, 4> outer = {
        mesh.twins[previous_side(h)], mesh.twins[next_side(g)],   // c → a, a → d
        mesh.twins[previous_side(g)], mesh.twins[next_side(h)]};  // d → b, b → c
    mesh.triangles[h / 3] = {c, a, d};
    mesh.triangles[g / 3] = {d, b, c};
    const std::array<std::uint32_t, 4> inner = {f, f + 1, e, e + 1};
    std::array<std::uint32_t, 4> across = outer;
    const std::array<std::uint32_t, 4> old = {previous_side(h), next_side(g), previous_side(g),
                                              next_side(h)};
    for (std::uint32_t& o : across)
      for (std::size_t k = 0; k < 4; ++k)
        if (o == old[k]) {
          o = inner[k];
          break;
        }
    for (std::size_t k = 0; k < 4; ++k) {
      mesh.twins[inner[k]] = across[k];
      mesh.twins[across[k]] = inner[k];
    }
    mesh.twins[f + 2] = e + 2;
    mesh.twins[e + 2] = f + 2;
  }
  surface.triangles = mesh.triangles;
  return surface;
}

/// Takes away the triangles around up to `holes` random vertices, where that leaves a surface.
inline Surface pierced(Surface surface, int holes, Random& random) {
  for (int hole = 0; hole < holes; ++hole) {
    const std::uint32_t v = random.below(surface.vertex_count);
    std::vector<Triangle> kept;
    for (const Triangle& t : surface.triangles)
      if (t[0] != v && t[1] != v && t[2] != v) kept.push_back(t);
    const Surface smaller = compacted(kept);
    if (close_mesh(smaller.triangles, smaller.vertex_count)) surface = smaller;
  }
  return surface;
}

/// The skin of a plate of unit cubes with `genus` square holes in a row.
inline Surface voxel_plate(int genus) {
  const int nx = 2 * genus + 1, ny = 3;
  const auto solid = [&](int x, int y, int z) {
    return x >= 0 && x < nx && y >= 0 && y < ny && z == 0 && !(x % 2 == 1 && y == 1);
  };
  const auto id = [&](int x, int y, int z) {
    return static_cast<std::uint32_t>((x * (ny + 1) + y) * 2 + z);
  };
  std::vector<Triangle> triangles;
  for (int x = 0; x < nx; ++x) {
    for (int y = 0; y < ny; ++y) {
      if (!solid(x, y, 0)) continue;
      const auto quad = [&](std::array<std::uint32_t, 4> q) {
        triangles.push_back({q[0], q[1], q[2]});
        triangles.push_back({q[0], q[2], q[3]});
      };
      const int X = x + 1, Y = y + 1;
      quad({id(x, y, 1), id(X, y, 1), id(X, Y, 1), id(x, Y, 1)});
      quad({id(x, y, 0), id(x, Y, 0), id(X, Y, 0), id(X, y, 0)});
      if (!solid(x - 1, y, 0)) quad({id(x, y, 0), id(x, y, 1), id(x, Y, 1), id(x, Y, 0)});
      if (!solid(X, y, 0)) quad({id(X, y, 0), id(X, Y, 0), id(X, Y, 1), id(X, y, 1)});
      if (!solid(x, y - 1, 0)) quad({id(x, y, 0), id(X, y, 0), id(X, y, 1), id(x, y, 1)});
      if (!solid(x, Y, 0)) quad({id(x, Y, 0), id(x, Y, 1), id(X, Y, 1), id(X, Y, 0)});
    }
  }
  return compacted(triangles);
}

/// An n × n grid without every square whose coordinates are both 1 modulo `spacing` (>= 2).
inline Surface holed_grid(std::uint32_t n, std::uint32_t spacing) {
  const Scan grid = shapes::grid(n, n);
  std::vector<Triangle> kept;
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t k = 0; k < n; ++k)
      if (i % spacing != 1 || k % spacing != 1 || i + 1 == n || k + 1 == n)
        for (std::uint32_t half = 0; half < 2; ++half)
          kept.push_back(grid.triangles[2 * (i * n + k) + half]);
  return compacted(kept);
}

/// Many components, open and closed, of several genera.
inline Surface mixed(Random& random) {
  Surface surface;
  append(surface, from_scan(shapes::torus(5, 4)));
  append(surface, holed_grid(6, 2));
  append(surface, {{{0, 1, 2}}, 3});
  append(surface, voxel_plate(2));
  append(surface, flipped(sphere(2), 50, random));
  append(surface, {{{0, 1, 2}, {2, 1, 3}}, 4});
  append(surface, from_scan(shapes::tetrahedron()));
  return renumbered(surface, random);
}

inline std::vector<std::pair<std::string, Surface>> all_shapes() {
  Random random(99);
  Surface crumbs;
  for (int i = 0; i < 300; ++i) append(crumbs, {{{0, 1, 2}}, 3});
  for (int i = 0; i < 300; ++i) append(crumbs, from_scan(shapes::octahedron()));
  std::vector<Triangle> ring;
  for (std::uint32_t i = 0; i < 8; ++i) {
    const std::uint32_t a = 2 * i, c = (2 * i + 2) % 16;
    ring.push_back({a, a + 1, c});
    ring.push_back({a + 1, c + 1, c});
  }
  return {{"tetrahedron", from_scan(shapes::tetrahedron())},
          {"octahedron", from_scan(shapes::octahedron())},
          {"icosahedron", from_scan(shapes::icosahedron())},
          {"sphere", sphere(3)},
          {"two triangles back to back", {{{0, 1, 2}, {0, 2, 1}}, 3}},
          {"triangle", {{{0, 1, 2}}, 3}},
          {"two triangles", {{{0, 1, 2}, {2, 1, 3}}, 4}},
          {"fan", {{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}, 6}},
          {"smallest torus", from_scan(shapes::torus(3, 3))},
          {"torus", from_scan(shapes::torus(9, 7))},
          {"genus 0 plate", voxel_plate(0)},
          {"genus 2", voxel_plate(2)},
          {"genus 3", voxel_plate(3)},
          {"genus 20", voxel_plate(20)},
          {"grid", from_scan(shapes::grid(7, 5))},
          {"ring", {ring, 16}},
          {"annulus", holed_grid(3, 2)},
          {"holes", holed_grid(12, 3)},
          {"many holes", holed_grid(9, 2)},
          {"torus with holes", pierced(from_scan(shapes::torus(12, 9)), 6, random)},
          {"600 components", crumbs},
          {"mixed", mixed(random)}};
}

}  // namespace nacre::entropy::test
