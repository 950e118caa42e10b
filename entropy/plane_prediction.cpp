// SPDX-License-Identifier: Apache-2.0
#include "entropy/plane_prediction.h"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <utility>

namespace nacre::entropy {
namespace {

/// A coarse step is about the local edge length over this power of two.
constexpr int kCoarseBelow = 2;
/// Triangles and neighbours looked at, of each vertex.
constexpr int kMostFan = 32, kMostFans = 16;
/// A line's direction along the axis that it is told by, against its largest component: at least
/// 1 in so many.
constexpr std::int64_t kSteepness = 8;

Wide3 wide(const GridPoint& p) { return {p[0], p[1], p[2]}; }
Wide3 operator-(const Wide3& a, const Wide3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
std::int64_t dot(const Wide3& a, const Wide3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Wide3 cross(const Wide3& a, const Wide3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Wide3 shortened(Wide3 v, int bits) {
  std::uint64_t largest = 0;
  for (const std::int64_t x : v)
    largest = std::max(largest, static_cast<std::uint64_t>(std::abs(x)));
  const int excess = std::max(0, static_cast<int>(std::bit_width(largest)) - bits);
  for (std::int64_t& x : v) x /= std::int64_t{1} << excess;
  return v;
}

/// Within an angle whose sine is 1/8.
bool are_alike(const Wide3& one, const Wide3& other) {
  const Wide3 a = shortened(one, 12), b = shortened(other, 12);
  const std::int64_t d = dot(a, b);
  return d > 0 && 64 * d * d >= 63 * squared(a) * squared(b);
}

struct Cluster {
  Wide3 point{}, normal{};  // normal as long as twice the area
};

class Planes {
 public:
  void add(const Wide3& point, const Wide3& normal) {
    if (normal == Wide3{}) return;
    for (std::uint32_t i = 0; i < count_; ++i) {
      if (!are_alike(clusters_[i].normal, normal)) continue;
      if (i > 0)
        for (std::size_t k = 0; k < 3; ++k) clusters_[i].normal[k] += normal[k];
      return;
    }
    if (count_ < kMostPlanes) clusters_[count_++] = {point, normal};
  }
  [[nodiscard]] std::uint32_t count() const { return count_; }
  [[nodiscard]] Plane plane(std::uint32_t i) const {
    return {clusters_[i].point, shortened(clusters_[i].normal, kNormalBits)};
  }

 private:
  std::array<Cluster, kMostPlanes> clusters_{};
  std::uint32_t count_ = 0;
};

Wide3 scaled(const Wide3& p) { return {kPlaneUnit * p[0], kPlaneUnit * p[1], kPlaneUnit * p[2]}; }

/// The planes of the done triangles around a done vertex.
void add_fan(const PositionOrder& order, std::span<const GridPoint> points, std::uint32_t apex,
             Planes& planes) {
  const Wide3 at = wide(points[apex]);
  int seen = 0;
  order.for_triangles_while(apex, [&](std::uint32_t a, std::uint32_t b, std::uint32_t) {
    if (order.done(a) && order.done(b))
      planes.add(scaled(at), cross(wide(points[a]) - at, wide(points[b]) - at));
    return ++seen < kMostFan;
  });
}

}  // namespace

std::array<std::size_t, 3> plane_axes(const Wide3& normal) {
  std::array<std::size_t, 3> axes = {0, 1, 2};
  std::stable_sort(axes.begin(), axes.end(), [&](std::size_t i, std::size_t k) {
    return std::abs(normal[i]) < std::abs(normal[k]);
  });
  return axes;
}

Outlook look_out(const PositionOrder& order, std::span<const GridPoint> points,
                 std::span<const ToldVertex> told, std::uint32_t vertex, int bits,
                 int default_scale, std::int64_t reach) {
  Outlook out;
  out.near = predict_position(order, points, vertex, bits, default_scale, reach);
  out.coarse_bits = std::max(0, (out.near.scale - 1) / 2 - kCoarseBelow);
  Planes planes;
  planes.add(out.near.fine_point, out.near.normal);
  int done = 0, sum_last = 0;
  out.least_last = 99;
  std::uint32_t gate_weight = 0;
  std::array<std::uint32_t, kMostFans> fans{};
  std::array<int, 3> level_sums{}, level_counts{};
  int fan_count = 0;
  order.for_triangles_while(vertex, [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (!order.done(a)) return true;
    const ToldVertex& t = told[a];
    ++out.kinds[t.kind];
    out.least_last = std::min<int>(out.least_last, t.last_length);
    out.most_coarse = std::max<int>(out.most_coarse, t.coarse_length);
    sum_last += t.last_length;
    for (std::size_t k = 0; k < 3; ++k) {
      if (t.levels[k] == kNoLevel) continue;
      level_sums[k] += t.levels[k];
      ++level_counts[k];
    }
    ++done;
    fans[static_cast<std::size_t>(fan_count++)] = a;
    if (!order.done(b)) return fan_count < kMostFans;
    const std::uint32_t low = std::min(t.kind, told[b].kind), high = std::max(t.kind, told[b].kind);
    if (low + high >= gate_weight) {
      gate_weight = low + high;
      out.gate_kinds = 4 * low + high;
    }
    if (!order.done(c)) return fan_count < kMostFans;
    const Wide3 apex = wide(points[c]);
    planes.add(scaled(wide(points[a])), cross(wide(points[b]) - apex, wide(points[a]) - apex));
    return fan_count < kMostFans;
  });
  for (std::size_t k = 0; k < 3; ++k)
    out.mean_levels[k] =
        level_counts[k] == 0 ? kNoLevel : std::min(2 * level_sums[k] / level_counts[k], 14);
  out.is_level = planes.count() == 1;
  if (done > 0) out.mean_last = (sum_last + done / 2) / done;
  for (int i = 0; i < fan_count; ++i)
    add_fan(order, points, fans[static_cast<std::size_t>(i)], planes);
  out.plane_count = planes.count();
  for (std::uint32_t i = 0; i < out.plane_count; ++i) out.planes[i] = planes.plane(i);
  return out;
}

std::int64_t solve_plane(const Plane& plane, std::size_t axis, const GridPoint& point, int bits) {
  std::int64_t lean = 0;
  for (std::size_t k = 0; k < 3; ++k)
    if (k != axis) lean += plane.normal[k] * (kPlaneUnit * point[k] - plane.point[k]);
  const std::int64_t n = plane.normal[axis];
  const std::int64_t offset = n > 0 ? divide(-lean, n) : divide(lean, -n);
  return std::clamp<std::int64_t>(divide(plane.point[axis] + offset, kPlaneUnit), 0,
                                  (std::int64_t{1} << bits) - 1);
}

bool have_line(const Plane& one, const Plane& other, std::size_t axis) {
  const Wide3 line = cross(one.normal, other.normal);
  std::int64_t largest = 0;
  for (const std::int64_t x : line) largest = std::max(largest, std::abs(x));
  return largest > 0 && kSteepness * std::abs(line[axis]) >= largest;
}

std::int64_t solve_line(const Plane& one, const Plane& other, std::size_t axis, std::size_t second,
                        const GridPoint& point, int bits) {
  const std::size_t third = 3 - axis - second;
  const Wide3 &n = one.normal, &m = other.normal;
  const std::int64_t at = kPlaneUnit * point[axis];
  // n2 s + n3 t = e, m2 s + m3 t = f, s and t from the first plane's point on.
  const std::int64_t e = -n[axis] * (at - one.point[axis]);
  const std::int64_t f = -m[axis] * (at - other.point[axis]) -
                         m[second] * (one.point[second] - other.point[second]) -
                         m[third] * (one.point[third] - other.point[third]);
  const std::int64_t determinant = n[second] * m[third] - n[third] * m[second];
  const std::int64_t numerator = e * m[third] - n[third] * f;
  const std::int64_t offset =
      determinant > 0 ? divide(numerator, determinant) : divide(-numerator, -determinant);
  return std::clamp<std::int64_t>(divide(one.point[second] + offset, kPlaneUnit), 0,
                                  (std::int64_t{1} << bits) - 1);
}

}  // namespace nacre::entropy
