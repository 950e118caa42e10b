// SPDX-License-Identifier: Apache-2.0
#include "entropy/position_prediction.h"

#include <algorithm>
#include <bit>

namespace nacre::entropy {
namespace {

/// Of predictions outside of the grid, in 1/16 of a step.
constexpr std::int64_t kFarthest = std::int64_t{1} << 29;

constexpr std::size_t kBuckets = 64;
constexpr std::uint32_t kTriangleKey = 4;  // one triangle counts as much as four neighbours

std::size_t bucket_of(std::uint32_t key) { return std::min<std::size_t>(key, kBuckets - 1); }

Wide3 wide(const GridPoint& p) { return {p[0], p[1], p[2]}; }
Wide3 operator+(const Wide3& a, const Wide3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Wide3 operator-(const Wide3& a, const Wide3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Wide3 cross(const Wide3& a, const Wide3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Sums over what is known around a vertex: its neighbours; its triangles with two known corners
/// a, b; and those of them for which the apex c across (a, b) is known, too.
struct Surroundings {
  std::int64_t neighbours = 0, edges = 0, apexes = 0;
  Wide3 sum{};     // over neighbours
  Wide3 ends{};    // over edges, a + b
  Wide3 chord{};   // over edges, b - a: from one end of the known fan to the other
  Wide3 steps{};   // over apexes, a + b - 2 c: twice the step that completes half a parallelogram
  Wide3 normal{};  // over apexes
  std::int64_t length2 = 0;    // squared lengths, over edges and apexes
  std::int64_t beside = 0;     // valence excesses of a and b
  std::int64_t imbalance = 0;  // that of b less that of a
  std::int64_t opposite = 0;   // that of c
};

Surroundings look_around(const PositionOrder& order, std::span<const GridPoint> points,
                         std::uint32_t vertex) {
  Surroundings s;
  order.for_each_triangle(vertex, [&](std::uint32_t ia, std::uint32_t ib, std::uint32_t ic) {
    if (!order.done(ia) || s.neighbours == kMostNeighbours) return;
    const Wide3 a = wide(points[ia]);
    s.sum = s.sum + a;
    ++s.neighbours;
    if (!order.done(ib)) return;
    const Wide3 b = wide(points[ib]);
    s.ends = s.ends + a + b;
    s.chord = s.chord + b - a;
    ++s.edges;
    s.length2 += squared(b - a);
    s.beside += order.excess(ia) + order.excess(ib);
    s.imbalance += order.excess(ib) - order.excess(ia);
    if (!order.done(ic)) return;
    const Wide3 c = wide(points[ic]);
    s.steps = s.steps + (a - c) + (b - c);
    s.normal = s.normal + cross(b - c, a - c);
    ++s.apexes;
    s.length2 += (squared(b - c) + squared(a - c)) / 2;
    s.opposite += order.excess(ic);
  });
  return s;
}

/// In 1/256. The first four say how much of a half parallelogram to add: in general, and per unit
/// of excess valence of the vertex, the apexes and the vertices beside.
struct Weights {
  std::int64_t step, step_own, step_opposite, step_beside;
  std::int64_t middle;  // of the mean edge middle, against the mean neighbour
  std::int64_t chord;   // per unit of imbalance
};

// By known neighbours. Fitted (least logarithm of the error, then by trial) to simplifications of
// bunny, mask, laurana, fandisk, doll_face, maneki_neko, conrod and rangemap to 100 .. 700
// vertices. A whole parallelogram (step 256) would go much too far on such coarse meshes. Vertices
// of low valence see wide angles, so a new vertex lies nearer to them and further out.
constexpr Weights kWeights[5] = {{},
                                 {},
                                 {153, 20, -14, -10, 0, -25},
                                 {165, 20, -20, -28, -190, -10},
                                 {141, 19, -25, -50, -44, -8}};

}  // namespace

PositionOrder::PositionOrder(const ClosedMesh& mesh)
    : mesh_(mesh),
      edge_of_(mesh.valences.size()),
      done_(mesh.valences.size(), false),
      keys_(mesh.valences.size(), 0),
      buckets_(kBuckets) {
  for (std::uint32_t h = 0; h < mesh.twins.size(); ++h) edge_of_[mesh.from(h)] = h;
}

std::uint32_t PositionOrder::next() {
  for (std::size_t b = kBuckets; b-- > 1;) {
    while (!buckets_[b].empty()) {
      const std::uint32_t v = buckets_[b].back();
      buckets_[b].pop_back();
      if (!done_[v] && bucket_of(keys_[v]) == b) return v;
    }
  }
  while (first_ < mesh_.vertex_count && done_[first_]) ++first_;
  return first_ < mesh_.vertex_count ? first_ : kNone;
}

void PositionOrder::finish(std::uint32_t vertex) {
  done_[vertex] = true;
  for_each_triangle(vertex, [&](std::uint32_t a, std::uint32_t b, std::uint32_t) {
    raise(a, 1);
    if (done(b)) raise(a, kTriangleKey);
    if (done(a)) raise(b, kTriangleKey);
  });
}

void PositionOrder::raise(std::uint32_t vertex, std::uint32_t by) {
  if (mesh_.is_dummy(vertex) || done_[vertex]) return;
  keys_[vertex] += by;
  buckets_[bucket_of(keys_[vertex])].push_back(vertex);
}

Prediction predict_position(const PositionOrder& order, std::span<const GridPoint> points,
                            std::uint32_t vertex, int bits, int default_scale, std::int64_t reach) {
  const Surroundings s = look_around(order, points, vertex);
  Prediction p;
  p.neighbours = static_cast<int>(std::min<std::int64_t>(s.neighbours, 4));
  p.scale = default_scale;
  if (s.neighbours == 0) return p;
  if (s.edges > 0) {
    const auto mean = static_cast<std::uint64_t>(s.length2 / (s.edges + s.apexes));
    p.scale = std::max(2, static_cast<int>(std::bit_width(mean)));
  }
  p.normal = s.normal;
  const Weights& w = kWeights[p.neighbours];
  std::int64_t step = 0;
  if (s.apexes > 0) {
    step = w.step + reach + w.step_own * order.excess(vertex) +
           divide(w.step_opposite * s.opposite, s.apexes) +
           divide(w.step_beside * s.beside, 2 * s.edges);
  }
  const std::int64_t chord = w.chord * std::clamp<std::int64_t>(s.imbalance, -4, 4);
  for (std::size_t k = 0; k < 3; ++k) {
    std::int64_t x = divide(256 * s.sum[k], s.neighbours);
    if (s.edges > 0) {
      const std::int64_t middle = divide(128 * s.ends[k], s.edges);
      x += divide(w.middle * (middle - x), 256) + chord * s.chord[k];
    }
    if (s.apexes > 0) x += divide(step * s.steps[k], 2 * s.apexes);
    p.fine_point[k] = std::clamp(divide(x, 16), -kFarthest, kFarthest);
    p.point[k] = std::clamp<std::int64_t>(divide(x, 256), 0, (std::int64_t{1} << bits) - 1);
  }
  return p;
}

}  // namespace nacre::entropy
