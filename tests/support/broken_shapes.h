// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "support/shapes.h"

/// Scans that are broken in ways that real ones are, at the size of small ones.
namespace nacre::shapes {

/// The vertices with equal coordinates made one.
inline Scan welded(const Scan& scan) {
  std::map<std::array<double, 3>, std::uint32_t> first;
  Scan out;
  out.origin = scan.origin;
  for (Triangle t : scan.triangles) {
    for (std::uint32_t& v : t) {
      const Vec3& p = scan.positions[v];
      const auto [it, fresh] = first.emplace(std::array{p[0], p[1], p[2]},
                                             static_cast<std::uint32_t>(out.positions.size()));
      if (fresh) out.positions.push_back(p);
      v = it->second;
    }
    out.triangles.push_back(t);
  }
  return out;
}

inline Scan inside_out(Scan scan) {
  for (Triangle& t : scan.triangles) std::swap(t[0], t[1]);
  return scan;
}

/// A band of n × m squares with half a twist.
inline Scan wide_moebius(std::uint32_t n, std::uint32_t m) {
  Scan scan;
  for (std::uint32_t i = 0; i < n; ++i) {
    const double u = 2 * M_PI * i / n;
    for (std::uint32_t k = 0; k <= m; ++k) {
      const double side = 0.8 * k / m - 0.4, r = 1 + side * std::cos(u / 2);
      scan.positions.emplace_back(r * std::cos(u), r * std::sin(u), side * std::sin(u / 2));
    }
  }
  const auto id = [&](std::uint32_t i, std::uint32_t k) {
    return i < n ? i * (m + 1) + k : m - k;  // once around, the other edge is met
  };
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t k = 0; k < m; ++k) {
      scan.triangles.push_back({id(i, k), id(i + 1, k), id(i + 1, k + 1)});
      scan.triangles.push_back({id(i, k), id(i + 1, k + 1), id(i, k + 1)});
    }
  }
  return scan;
}

/// Two domes whose tops are one vertex: two open fans there.
inline Scan bow_tie(int levels) {
  const Scan dome = hemisphere(levels);
  Scan other = inside_out(dome);
  for (Vec3& p : other.positions) p[2] = 2 - p[2];
  return welded(joined(dome, other));
}

/// A ball with a brim along half of its equator: edges there have three faces.
inline Scan brimmed_ball(int levels) {
  const Scan ball = sphere(levels);
  Scan scan = ball;
  std::map<std::uint32_t, std::uint32_t> outer;
  const auto on_brim = [&](std::uint32_t v) {
    return std::abs(ball.positions[v][2]) < 1e-9 && ball.positions[v][0] > -1e-9;
  };
  const auto outer_of = [&](std::uint32_t v) {
    const auto [it, fresh] = outer.emplace(v, static_cast<std::uint32_t>(scan.positions.size()));
    if (fresh) scan.positions.push_back(Vec3(ball.positions[v] * 1.5));
    return it->second;
  };
  for (const Triangle& t : ball.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      if (a > b || !on_brim(a) || !on_brim(b)) continue;
      const std::uint32_t c = outer_of(a), d = outer_of(b);
      scan.triangles.push_back({a, b, d});
      scan.triangles.push_back({a, d, c});
    }
  }
  return scan;
}

/// Every so-manyth edge, by its first face, with a vertex `share` of its length from one end.
inline Scan with_needles(Scan scan, std::size_t every, double share) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> inner;
  const std::size_t faces = scan.triangles.size();
  std::vector<char> cut(faces, 0);
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> side;
  for (std::size_t f = 0; f < faces; ++f)
    for (std::size_t k = 0; k < 3; ++k)
      side[{scan.triangles[f][k], scan.triangles[f][(k + 1) % 3]}] = 3 * f + k;
  for (std::size_t f = 0; f < faces; f += every) {
    if (cut[f]) continue;
    const std::uint32_t a = scan.triangles[f][0], b = scan.triangles[f][1];
    const std::size_t other = side.at({b, a});
    if (cut[other / 3]) continue;
    const auto m = static_cast<std::uint32_t>(scan.positions.size());
    scan.positions.push_back(
        Vec3(scan.positions[a] + share * (scan.positions[b] - scan.positions[a])));
    for (const std::size_t s : {3 * f, other}) {
      Triangle& t = scan.triangles[s / 3];
      Triangle second = t;
      t[(s % 3 + 1) % 3] = m;
      second[s % 3] = m;
      cut[s / 3] = 1;
      scan.triangles.push_back(second);
    }
  }
  return scan;
}

/// A ball slit open along the two edges on either side of a vertex, as wide as `width`.
inline Scan slit_ball(int levels, double width) {
  Scan scan = sphere(levels);
  // On the arc y = 0 the edges run straight through each vertex.
  std::uint32_t middle = kNone;
  for (std::uint32_t v = 6; v < scan.positions.size() && middle == kNone; ++v)
    if (scan.positions[v][1] == 0 && scan.positions[v][0] > 0.3 && scan.positions[v][2] > 0.3)
      middle = v;
  const auto twin = static_cast<std::uint32_t>(scan.positions.size());
  scan.positions.push_back(Vec3(scan.positions[middle] + Vec3(0, width, 0)));
  for (Triangle& t : scan.triangles) {
    double y = 0;
    for (const std::uint32_t v : t) y += scan.positions[v][1];
    for (std::uint32_t& v : t)
      if (v == middle && y > 0) v = twin;
  }
  return scan;
}

/// Two balls with one vertex in common, the first one's farthest along x.
inline Scan balls_with_a_common_vertex(int levels) {
  const Scan ball = sphere(levels);
  return welded(joined(ball, moved(ball, {2, 0, 0})));
}

/// Two balls with one edge in common: the second is the first turned half round, so that the edge's
/// ends change places.
inline Scan balls_with_a_common_edge(int levels) {
  const Scan ball = sphere(levels);
  const std::uint32_t a = ball.triangles[0][0], b = ball.triangles[0][1];
  const Vec3 middle = (ball.positions[a] + ball.positions[b]) / 2;
  // About the line through the middle of the edge that touches the ball, across the edge.
  const Vec3 axis = middle.cross(ball.positions[b] - ball.positions[a]).normalized();
  Scan other = ball;
  for (Vec3& p : other.positions) {
    const Vec3 from = p - middle;
    p = middle + 2 * axis.dot(from) * axis - from;
  }
  other.positions[a] = ball.positions[b];  // exactly
  other.positions[b] = ball.positions[a];
  return welded(joined(ball, other));
}

/// A torus one meridian of which has this radius; with 0 all its vertices lie in one place.
inline Scan pinched_torus(std::uint32_t n, std::uint32_t m, double radius) {
  Scan scan = torus(n, m);
  for (std::uint32_t i = 0; i < n; ++i) {
    const double u = 2 * M_PI * i / n;
    const Vec3 centre(std::cos(u), std::sin(u), 0);
    // Narrow around u = 0 and as it was on the other side.
    const double share = std::min(1.0, radius / 0.4 + std::sin(u / 2));
    for (std::uint32_t k = 0; k < m; ++k) {
      Vec3& p = scan.positions[i * m + k];
      p = centre + share * (p - centre);
      if (share == 0) p = centre;
    }
  }
  return scan;
}

}  // namespace nacre::shapes
