// SPDX-License-Identifier: Apache-2.0
#include "wavelet/butterfly_mask.h"

#include <algorithm>
#include <cassert>

#include "wavelet/turn.h"

// READ ME FIRST. A ring stencil costs K products for each of K edges. Streams may hold a vertex of
// a million edges, so the sum is not taken edge by edge: the weights have only the frequencies 0, 1
// and 2, hence all K results follow from five weighted sums of the ring (its Fourier coefficients).
// The order of those sums is part of the format: counter-clockwise from the ring's lowest edge.

namespace nacre::wavelet {
namespace {

std::uint32_t side_of(const Triangle& triangle_edges, std::uint32_t edge) {
  return triangle_edges[0] == edge ? 0 : (triangle_edges[1] == edge ? 1 : 2);
}

std::uint32_t next_side(std::uint32_t side) { return side == 2 ? 0 : side + 1; }

std::uint32_t face_beyond(const Edge& edge, std::uint32_t face) {
  return edge.face[0] == face ? edge.face[1] : edge.face[0];
}

/// The point opposite `apex` across edge `e` of `face`, or its mirror image on the boundary.
Vec3 wing(const LevelTopology& level, std::span<const Vec3> p, std::uint32_t e, std::uint32_t face,
          std::uint32_t apex) {
  const Edge& edge = level.edges[e];
  const auto [a, b] = edge.vertex;
  const std::uint32_t beyond = face_beyond(edge, face);
  if (beyond == kNone) return (p[a] + p[b]) - p[apex];
  const Triangle& t = level.triangles[beyond];
  return p[t[0] ^ t[1] ^ t[2] ^ a ^ b];  // the third corner, without a search
}

/// The vertex that follows `v` on the boundary, coming along boundary edge `e`. A fan has two
/// boundary edges, so all walks of a level together visit each fan at most twice.
std::uint32_t next_on_boundary(const LevelTopology& level, std::uint32_t e, std::uint32_t v) {
  std::uint32_t face = level.edges[e].face[0];
  while (face != kNone) {
    const Triangle& edges = level.triangle_edges[face];
    const std::uint32_t k = side_of(edges, e);
    // Side k runs from corner k; the other side at v comes before it or after it.
    e = level.triangles[face][k] == v ? edges[next_side(next_side(k))] : edges[next_side(k)];
    face = face_beyond(level.edges[e], face);
  }
  const auto [a, b] = level.edges[e].vertex;
  return a == v ? b : a;
}

Vec3 four_point(const LevelTopology& level, std::span<const Vec3> p, std::uint32_t e) {
  const auto [a, b] = level.edges[e].vertex;
  const Vec3& before = p[next_on_boundary(level, e, a)];
  const Vec3& after = p[next_on_boundary(level, e, b)];
  return (p[a] + p[b]) * (9.0 / 16) - (before + after) * (1.0 / 16);
}

}  // namespace

ButterflyMask::ButterflyMask(const Topology& topology) : topology_(topology) {
  if (topology.level_count() > 0) find_rings();
}

void ButterflyMask::find_rings() {
  const LevelTopology& base = topology_.level(0);
  const auto edge_count = static_cast<std::uint32_t>(base.edges.size());
  ring_of_.assign(2 * static_cast<std::size_t>(edge_count), kNone);
  std::vector<bool> seen(ring_of_.size(), false);
  ring_begin_.push_back(0);
  for (std::uint32_t first = 0; first < ring_of_.size(); ++first) {
    if (seen[first]) continue;
    const std::uint32_t v = base.edges[first / 2].vertex[first % 2];
    std::uint32_t spoke = first;
    // Stopping at any seen spoke, not only the first, keeps open fans linear.
    do {
      seen[spoke] = true;
      spokes_.push_back({spoke / 2, spoke % 2});
      const std::uint32_t left = base.edges[spoke / 2].face[spoke % 2];
      if (left == kNone) break;
      const std::uint32_t k = side_of(base.triangle_edges[left], spoke / 2);
      const std::uint32_t next = base.triangle_edges[left][next_side(next_side(k))];
      spoke = 2 * next + (base.edges[next].vertex[0] == v ? 0 : 1);
    } while (!seen[spoke]);
    const std::size_t valence = spokes_.size() - ring_begin_.back();
    const bool closed = spoke == first && valence > 1;
    if (!closed || valence == 6) {
      spokes_.resize(ring_begin_.back());
      continue;
    }
    const auto ring = static_cast<std::uint32_t>(ring_begin_.size() - 1);
    for (std::size_t i = ring_begin_.back(); i < spokes_.size(); ++i)
      ring_of_[2 * static_cast<std::size_t>(spokes_[i].edge) + spokes_[i].end] = ring;
    ring_begin_.push_back(spokes_.size());
  }
}

void ButterflyMask::predict(int level_index, std::span<const Vec3> coarse,
                            std::span<Vec3> points) const {
  assert(coarse.size() >= topology_.level(level_index).vertex_count &&
         points.size() == topology_.level(level_index).edges.size());
  if (level_index == 0) {
    predict_base(coarse, points);
  } else {
    predict_split(level_index, coarse, points);
  }
  for (std::size_t ring = 0; ring + 1 < ring_begin_.size(); ++ring) {
    predict_ring(level_index, ring, coarse, [&](const Spoke& s, const Vec3& point) {
      Vec3& out = points[edge_at_level(level_index, s)];
      // Extraordinary vertices are neighbours on the base only; the later ring completes the mean.
      const std::uint32_t other = ring_of_[2 * static_cast<std::size_t>(s.edge) + (1 - s.end)];
      const bool second_of_two = level_index == 0 && other < ring;  // kNone is the largest id
      out = second_of_two ? Vec3((out + point) * 0.5) : point;
    });
  }
}

void ButterflyMask::predict_base(std::span<const Vec3> coarse, std::span<Vec3> points) const {
  const LevelTopology& level = topology_.level(0);
  for (std::uint32_t e = 0; e < points.size(); ++e) {
    const Edge& edge = level.edges[e];
    points[e] = edge.is_boundary() ? four_point(level, coarse, e)
                                   : Vec3((coarse[edge.vertex[0]] + coarse[edge.vertex[1]]) * 0.5);
  }
  // By triangle, since the wings across its sides serve two of its edges each.
  for (std::uint32_t f = 0; f < level.triangles.size(); ++f) {
    const Triangle& t = level.triangles[f];
    const Triangle& edges = level.triangle_edges[f];
    const std::array<Vec3, 3> across = {wing(level, coarse, edges[0], f, t[2]),
                                        wing(level, coarse, edges[1], f, t[0]),
                                        wing(level, coarse, edges[2], f, t[1])};
    for (std::uint32_t k = 0; k < 3; ++k) {
      if (level.edges[edges[k]].is_boundary()) continue;
      const std::uint32_t k1 = next_side(k), k2 = next_side(k1);
      points[edges[k]] += coarse[t[k2]] * 0.125 - (across[k1] + across[k2]) * 0.0625;
    }
  }
}

// The same, four triangles at a time by the one that was split: its neighbours have all the wings,
// which are midpoints of their sides, and inside of it there is nothing to look up.
void ButterflyMask::predict_split(int level_index, std::span<const Vec3> coarse,
                                  std::span<Vec3> points) const {
  const LevelTopology& level = topology_.level(level_index);
  const LevelTopology& parent = topology_.level(level_index - 1);
  const Vec3* const p = coarse.data();
  const Vec3* const middle = p + parent.vertex_count;  // of the parent's edges
  const auto parent_edges = static_cast<std::uint32_t>(parent.edges.size());
  for (std::uint32_t e = 0; e < parent_edges; ++e) {
    const Edge& edge = parent.edges[e];
    if (edge.is_boundary()) {
      for (const std::uint32_t half : {2 * e, 2 * e + 1})
        points[half] = four_point(level, coarse, half);
      continue;
    }
    points[2 * e] = (p[edge.vertex[0]] + middle[e]) * 0.5;
    points[2 * e + 1] = (middle[e] + p[edge.vertex[1]]) * 0.5;
  }
  for (std::uint32_t f = 0; f < parent.triangles.size(); ++f) {
    const Triangle& corners = parent.triangles[f];
    const Triangle& sides = parent.triangle_edges[f];
    std::array<Vec3, 3> at, mid;
    for (std::uint32_t k = 0; k < 3; ++k) {
      at[k] = p[corners[k]];
      mid[k] = middle[sides[k]];
    }
    // Of the halves of side k at corner k and at the next one: where they are, and their wings.
    std::array<std::array<std::uint32_t, 2>, 3> half;
    std::array<std::array<Vec3, 2>, 3> across;
    std::array<bool, 3> is_boundary;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t k1 = next_side(k), k2 = next_side(k1);
      const Edge& edge = parent.edges[sides[k]];
      const std::uint32_t first = edge.vertex[0] == corners[k] ? 0 : 1;
      half[k] = {2 * sides[k] + first, 2 * sides[k] + (1 - first)};
      is_boundary[k] = edge.is_boundary();
      if (is_boundary[k]) {
        across[k] = {(at[k] + mid[k]) - mid[k2], (mid[k] + at[k1]) - mid[k1]};
        continue;
      }
      // The other triangle has the side the other way round.
      const Triangle& beyond = parent.triangle_edges[face_beyond(edge, f)];
      const std::uint32_t q1 = next_side(side_of(beyond, sides[k])), q2 = next_side(q1);
      across[k] = {middle[beyond[q1]], middle[beyond[q2]]};
    }
    for (std::uint32_t k = 0; k < 3; ++k) {
      // The triangle at corner k, its sides' wings in order: beyond side k, the middle triangle,
      // and beyond the side before.
      const std::uint32_t k1 = next_side(k), k2 = next_side(k1);
      const Vec3 &out = across[k][0], &in = across[k2][1];
      if (!is_boundary[k]) points[half[k][0]] += mid[k2] * 0.125 - (mid[k1] + in) * 0.0625;
      if (!is_boundary[k2]) points[half[k2][1]] += mid[k] * 0.125 - (out + mid[k1]) * 0.0625;
      Vec3 inner = (mid[k] + mid[k2]) * 0.5;
      inner += at[k] * 0.125 - (in + out) * 0.0625;
      inner += mid[k1] * 0.125 - (at[k1] + at[k2]) * 0.0625;  // of the middle triangle
      points[2 * parent_edges + 3 * f + k] = inner;
    }
  }
}

Vec3 ButterflyMask::wing_beyond(const LevelTopology& parent, std::span<const Vec3> coarse,
                                std::uint32_t f, std::uint32_t k, std::uint32_t half) {
  const Triangle& corners = parent.triangles[f];
  const Triangle& sides = parent.triangle_edges[f];
  const Vec3* const middle = coarse.data() + parent.vertex_count;
  const std::uint32_t k1 = next_side(k), k2 = next_side(k1);
  const Edge& edge = parent.edges[sides[k]];
  if (edge.is_boundary()) {
    return half == 0 ? Vec3((coarse[corners[k]] + middle[sides[k]]) - middle[sides[k2]])
                     : Vec3((middle[sides[k]] + coarse[corners[k1]]) - middle[sides[k1]]);
  }
  const Triangle& beyond = parent.triangle_edges[face_beyond(edge, f)];
  const std::uint32_t q1 = next_side(side_of(beyond, sides[k]));
  return middle[beyond[half == 0 ? q1 : next_side(q1)]];
}

// The sums of predict_split(), in its order.
Vec3 ButterflyMask::predict_one(int level_index, std::span<const Vec3> coarse,
                                std::uint32_t e) const {
  const LevelTopology& parent = topology_.level(level_index - 1);
  const Vec3* const middle = coarse.data() + parent.vertex_count;
  const auto parent_edges = static_cast<std::uint32_t>(parent.edges.size());
  if (e >= 2 * parent_edges) {
    const std::uint32_t f = (e - 2 * parent_edges) / 3, k = (e - 2 * parent_edges) % 3;
    const std::uint32_t k1 = next_side(k), k2 = next_side(k1);
    const Triangle& corners = parent.triangles[f];
    const Triangle& sides = parent.triangle_edges[f];
    const Vec3 out = wing_beyond(parent, coarse, f, k, 0),
               in = wing_beyond(parent, coarse, f, k2, 1);
    Vec3 inner = (middle[sides[k]] + middle[sides[k2]]) * 0.5;
    inner += coarse[corners[k]] * 0.125 - (in + out) * 0.0625;
    inner += middle[sides[k1]] * 0.125 - (coarse[corners[k1]] + coarse[corners[k2]]) * 0.0625;
    return inner;
  }
  const std::uint32_t whole = e / 2, end = e % 2;
  const Edge& edge = parent.edges[whole];
  if (edge.is_boundary()) return four_point(topology_.level(level_index), coarse, e);
  Vec3 point = end == 0 ? Vec3((coarse[edge.vertex[0]] + middle[whole]) * 0.5)
                        : Vec3((middle[whole] + coarse[edge.vertex[1]]) * 0.5);
  const auto [first, second] = std::minmax(edge.face[0], edge.face[1]);
  for (const std::uint32_t f : {first, second}) {
    const Triangle& sides = parent.triangle_edges[f];
    const std::uint32_t k = side_of(sides, whole), k1 = next_side(k), k2 = next_side(k1);
    if ((edge.vertex[0] == parent.triangles[f][k]) == (end == 0)) {
      const Vec3 in = wing_beyond(parent, coarse, f, k2, 1);
      point += middle[sides[k2]] * 0.125 - (middle[sides[k1]] + in) * 0.0625;
    } else {
      const Vec3 out = wing_beyond(parent, coarse, f, k1, 0);
      point += middle[sides[k1]] * 0.125 - (out + middle[sides[k2]]) * 0.0625;
    }
  }
  return point;
}

bool ButterflyMask::at_ring(int level_index, std::uint32_t e) const {
  const std::uint32_t base = e >> level_index, place = e & ((1u << level_index) - 1);
  if (2 * static_cast<std::size_t>(base) >= ring_of_.size()) return false;
  if (place == 0) return ring_of_[2 * static_cast<std::size_t>(base)] != kNone;
  return place + 1 == 1u << level_index &&
         ring_of_[2 * static_cast<std::size_t>(base) + 1] != kNone;
}

void ButterflyMask::predict_ring(
    int level_index, std::size_t ring, std::span<const Vec3> coarse,
    const std::function<void(const Spoke&, const Vec3&)>& visit) const {
  const LevelTopology& level = topology_.level(level_index);
  const std::span<const Spoke> spokes(&spokes_[ring_begin_[ring]],
                                      ring_begin_[ring + 1] - ring_begin_[ring]);
  const auto K = static_cast<std::uint32_t>(spokes.size());
  const Vec3 centre = coarse[topology_.level(0).edges[spokes[0].edge].vertex[spokes[0].end]];

  Vec3 sum = Vec3::Zero(), cos1 = sum, sin1 = sum, cos2 = sum, sin2 = sum;
  for (std::uint32_t i = 0; i < K; ++i) {
    const Edge& edge = level.edges[edge_at_level(level_index, spokes[i])];
    const Vec3 q = coarse[edge.vertex[1 - spokes[i].end]] - centre;
    const CosSin one = turn(i, K);
    const CosSin two = turn(static_cast<std::uint32_t>((2 * static_cast<std::uint64_t>(i)) % K), K);
    sum += q;
    cos1 += q * one.cos;
    sin1 += q * one.sin;
    cos2 += q * two.cos;
    sin2 += q * two.sin;
  }
  const double a1 = K == 2 ? 0.5 : 1.0;
  const double a2 = K < 4 ? 0.0 : (K == 4 ? 0.25 : 0.5);
  for (std::uint32_t i = 0; i < K; ++i) {
    const CosSin one = turn(i, K);
    const CosSin two = turn(static_cast<std::uint32_t>((2 * static_cast<std::uint64_t>(i)) % K), K);
    const Vec3 first = (cos1 * one.cos + sin1 * one.sin) * a1;
    const Vec3 second = (cos2 * two.cos + sin2 * two.sin) * a2;
    const Vec3 point = centre + ((sum * 0.25 + first) + second) / static_cast<double>(K);
    visit(spokes[i], point);
  }
}

}  // namespace nacre::wavelet
