// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/choose_positions.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <utility>

#include "entropy/plane_position_writer.h"

namespace nacre::codec {
namespace {

using entropy::GridPoint;
using entropy::Outlook;
using entropy::PlanePositionWriter;
using entropy::PositionChoice;

/// A vertex that slides by the length of its edges loses so many squared steps, beside what its
/// triangles' planes say: what is free stays near where it was.
constexpr double kSlide = 1;
/// Triangles and borders count as at least so many steps wide: slivers of no area hold creases,
/// too.
constexpr double kStrip = 8;
/// Least cosine between a triangle's normals before and after.
constexpr double kLeastCosine = 0.3;
/// Squared steps over bits' worth of a coordinate told in single steps: 12 / (2 ln 2), from the
/// slope of a uniform quantiser.
constexpr double kStepsPerBit = 8.66;

/// d A d + b d, of a vertex moved by d.
struct Quadric {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Vec3 b = Vec3::Zero();

  [[nodiscard]] double operator()(const Vec3& d) const { return d.dot(a * d) + b.dot(d); }
  /// The best coordinate `last`, the two others being given.
  [[nodiscard]] double best_last(int last, const Vec3& d) const {
    double r = -b[last] / 2;
    for (int k = 0; k < 3; ++k)
      if (k != last) r -= a(last, k) * d[k];
    return r / a(last, last);
  }
  /// The best coordinate `second` where `first` is given and `last` will be the best.
  [[nodiscard]] double best_second(int first, int second, int last, const Vec3& d) const {
    const double rs = -b[second] / 2 - a(second, first) * d[first];
    const double rl = -b[last] / 2 - a(last, first) * d[first];
    const double determinant =
        a(second, second) * a(last, last) - a(second, last) * a(second, last);
    return (rs * a(last, last) - rl * a(second, last)) / determinant;
  }
};

/// An edge of the boundary, as a plane through it across the surface.
struct Border {
  std::uint32_t other;  ///< end
  Vec3 normal;
  double weight;
};

class Chooser {
 public:
  Chooser(std::span<const Vec3> positions, const entropy::Connectivity& connectivity, int bits,
          double bit_price);
  ChosenPositions run();

 private:
  struct Best {
    double total = std::numeric_limits<double>::infinity();
    GridPoint point{};
  };

  void add_borders(double per_area);
  [[nodiscard]] Quadric quadric_of(std::uint32_t vertex) const;
  [[nodiscard]] bool turns_over(std::uint32_t vertex, const Vec3& place) const;
  [[nodiscard]] std::uint32_t best_line(std::uint32_t plane, std::size_t first,
                                        std::size_t second) const;
  void try_plane(std::uint32_t plane);
  void try_choice(const PositionChoice& choice);
  void try_point(const PositionChoice& choice, const GridPoint& point);
  [[nodiscard]] double held_inside(double x) const {
    return std::clamp(x, 0.0, std::ldexp(1, bits_) - 1);
  }
  [[nodiscard]] std::int32_t rounded(double x) const {
    return static_cast<std::int32_t>(std::lround(held_inside(x)));
  }
  [[nodiscard]] Vec3 moved(const GridPoint& point) const {
    return Vec3(point[0], point[1], point[2]) - positions_[vertex_];
  }

  std::span<const Vec3> positions_;
  const entropy::Connectivity& connectivity_;
  int bits_;
  double bit_price_;
  PlanePositionWriter writer_;
  std::vector<std::vector<std::uint32_t>> triangles_of_;
  std::vector<Vec3> normals_;    // of unit length; zero where there is none
  std::vector<double> weights_;  // of triangles: a sixth of their area, per mean area of a vertex
  std::vector<Vec3> places_;     // as decoded, or as they were
  std::vector<bool> done_;
  std::vector<std::vector<Border>> borders_;  // of each vertex
  std::uint32_t vertex_ = kNone;
  Quadric quadric_;
  Eigen::Matrix3d inverse_;
  Vec3 optimum_ = Vec3::Zero();
  Best best_;
};

Chooser::Chooser(std::span<const Vec3> positions, const entropy::Connectivity& connectivity,
                 int bits, double bit_price)
    : positions_(positions),
      connectivity_(connectivity),
      bits_(bits),
      bit_price_(bit_price),
      writer_(connectivity, bits),
      triangles_of_(positions.size()),
      places_(positions.begin(), positions.end()),
      done_(positions.size(), false) {
  double area = 0;
  for (std::size_t t = 0; t < connectivity.triangles.size(); ++t) {
    const auto& [a, b, c] = connectivity.triangles[t];
    Vec3 n = cross(positions[b] - positions[a], positions[c] - positions[a]);
    const double length = norm(n);
    area += length / 2;
    const double longest = std::sqrt(std::max({(positions[b] - positions[a]).squaredNorm(),
                                               (positions[c] - positions[a]).squaredNorm(),
                                               (positions[c] - positions[b]).squaredNorm()}));
    weights_.push_back(std::max(length, std::min(longest * kStrip, longest * longest)) / 12);
    normals_.push_back(length > 0 ? Vec3(n / length) : Vec3(Vec3::Zero()));
    for (const std::uint32_t v : connectivity.triangles[t])
      triangles_of_[v].push_back(static_cast<std::uint32_t>(t));
  }
  const double per_area = area > 0 ? static_cast<double>(positions.size()) / area : 0;
  for (double& w : weights_) w *= per_area;
  add_borders(per_area);
}

void Chooser::add_borders(double per_area) {
  borders_.resize(positions_.size());
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> sides;
  for (std::size_t t = 0; t < connectivity_.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      sides[{connectivity_.triangles[t][k], connectivity_.triangles[t][(k + 1) % 3]}] =
          static_cast<std::uint32_t>(t);
  for (const auto& [side, t] : sides) {
    if (sides.contains({side.second, side.first})) continue;
    const Vec3 edge = positions_[side.second] - positions_[side.first];
    const double length = norm(edge);
    if (!(length > 0)) continue;
    const double weight = std::min(length * kStrip, length * length) / 6 * per_area;
    const Vec3 across = cross(Vec3(edge / length), normals_[t]);
    borders_[side.first].push_back({side.second, across, weight});
    borders_[side.second].push_back({side.first, across, weight});
  }
}

Quadric Chooser::quadric_of(std::uint32_t vertex) const {
  Quadric q;
  for (const std::uint32_t t : triangles_of_[vertex]) {
    const Vec3& n = normals_[t];
    double others = 0;
    for (const std::uint32_t v : connectivity_.triangles[t])
      if (v != vertex && done_[v]) others += dot(n, places_[v] - positions_[v]);
    q.a += weights_[t] * n * n.transpose();
    q.b += weights_[t] * others * n;
  }
  for (const Border& border : borders_[vertex]) {
    q.a += border.weight * border.normal * border.normal.transpose();
    if (done_[border.other])
      q.b += border.weight * dot(border.normal, places_[border.other] - positions_[border.other]) *
             border.normal;
  }
  double length2 = 0;
  int edges = 0;
  for (const std::uint32_t t : triangles_of_[vertex]) {
    for (const std::uint32_t v : connectivity_.triangles[t]) {
      length2 += (positions_[v] - positions_[vertex]).squaredNorm();
      edges += v != vertex ? 1 : 0;
    }
  }
  q.a +=
      (kSlide * q.a.trace() / std::max(length2 / edges, 1.0) + 1e-9) * Eigen::Matrix3d::Identity();
  return q;
}

bool Chooser::turns_over(std::uint32_t vertex, const Vec3& place) const {
  for (const std::uint32_t t : triangles_of_[vertex]) {
    std::array<Vec3, 3> p;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = connectivity_.triangles[t][k];
      p[k] = v == vertex ? place : places_[v];
    }
    const Vec3 n = cross(p[1] - p[0], p[2] - p[0]);
    if (!normals_[t].isZero() && dot(n, normals_[t]) < kLeastCosine * norm(n)) return true;
  }
  return false;
}

void Chooser::try_point(const PositionChoice& choice, const GridPoint& point) {
  if (!writer_.can_tell(choice, point)) return;
  const Vec3 d = moved(point);
  const double error = quadric_(d);
  if (error >= best_.total) return;
  const double total = error + bit_price_ * writer_.cost(choice, point) / 4096;
  if (total >= best_.total) return;
  if (turns_over(vertex_, positions_[vertex_] + d)) return;
  best_ = {total, point};
}

/// Steps from what is expected: to what is best, and one less.
std::array<std::int64_t, 2> steps_to(double best) {
  const auto nearest = static_cast<std::int64_t>(std::llround(best));
  return {nearest, nearest > 0 ? nearest - 1 : (nearest < 0 ? nearest + 1 : 0)};
}

void Chooser::try_choice(const PositionChoice& choice) {
  const Outlook& o = writer_.outlook();
  const entropy::Plane& plane = o.planes[choice.plane];
  const auto axes = entropy::plane_axes(plane.normal);
  const std::size_t f = entropy::first_told(choice);
  const std::size_t first = axes[f], second = axes[1 - f], last = axes[2];
  const auto as_int = [](std::size_t k) { return static_cast<int>(k); };
  const Vec3& at = positions_[vertex_];
  const auto along = [&](std::size_t axis, int shift, std::int64_t expected, double best,
                         auto&& body) {
    // Where nothing holds the vertex, the best may be anywhere.
    const double place =
        std::isfinite(best) ? held_inside(best + at[as_int(axis)]) : at[as_int(axis)];
    const auto steps = steps_to(std::ldexp(place - static_cast<double>(expected), -shift));
    for (std::size_t i = 0; i < steps.size(); ++i) {
      if (i > 0 && steps[i] == steps[i - 1]) break;
      const std::int64_t x = expected + steps[i] * (std::int64_t{1} << shift);
      if (x >= 0 && x < std::int64_t{1} << bits_) body(static_cast<std::int32_t>(x));
    }
  };
  GridPoint point{};
  along(first, o.shift(choice.levels[f]), o.near.point[first], optimum_[as_int(first)],
        [&](std::int32_t x) {
          point[first] = x;
          const std::int64_t expected =
              choice.second_plane != kNone
                  ? entropy::solve_line(plane, o.planes[choice.second_plane], first, second, point,
                                        bits_)
                  : o.near.point[second];
          const double best =
              quadric_.best_second(as_int(first), as_int(second), as_int(last), moved(point));
          along(second, o.shift(choice.levels[1 - f]), expected, best, [&](std::int32_t y) {
            point[second] = y;
            along(last, 0, entropy::solve_plane(plane, last, point, bits_),
                  quadric_.best_last(as_int(last), moved(point)), [&](std::int32_t z) {
                    point[last] = z;
                    try_point(choice, point);
                  });
          });
        });
}

std::uint32_t Chooser::best_line(std::uint32_t plane, std::size_t first, std::size_t second) const {
  const Outlook& o = writer_.outlook();
  GridPoint point{};
  for (int k = 0; k < 3; ++k)
    point[static_cast<std::size_t>(k)] = rounded(positions_[vertex_][k] + optimum_[k]);
  std::uint32_t best = kNone;
  std::int64_t least = 0;
  for (std::uint32_t i = 0; i < o.plane_count; ++i) {
    if (i == plane || !entropy::have_line(o.planes[plane], o.planes[i], first)) continue;
    const std::int64_t off =
        std::abs(point[second] -
                 entropy::solve_line(o.planes[plane], o.planes[i], first, second, point, bits_));
    if (best != kNone && off >= least) continue;
    least = off;
    best = i;
  }
  return best;
}

void Chooser::try_plane(std::uint32_t plane) {
  const Outlook& o = writer_.outlook();
  const auto axes = entropy::plane_axes(o.planes[plane].normal);
  PositionChoice choice;
  choice.plane = plane;
  const int finest = o.finest_level();
  const auto level_of = [&](double stiffness) {
    const double shift = 0.5 * std::log2(kStepsPerBit * bit_price_ / std::max(stiffness, 1e-12));
    return std::clamp(static_cast<int>(std::lround((o.coarse_bits - shift) / 2)), 0, finest);
  };
  for (std::size_t f = 0; f < 2; ++f) {
    const int first = static_cast<int>(axes[f]), second = static_cast<int>(axes[1 - f]),
              last = static_cast<int>(axes[2]);
    const double stiffness = quadric_.a(second, second) - quadric_.a(second, last) *
                                                              quadric_.a(second, last) /
                                                              quadric_.a(last, last);
    const int a = level_of(1 / inverse_(first, first)), b = level_of(stiffness);
    if (a > b || (f == 1 && a == b)) continue;
    choice.levels[f] = static_cast<std::uint8_t>(a);
    choice.levels[1 - f] = static_cast<std::uint8_t>(b);
    choice.second_plane = kNone;
    try_choice(choice);
    if (b == 0) continue;
    choice.second_plane = best_line(plane, axes[f], axes[1 - f]);
    if (choice.second_plane != kNone) try_choice(choice);
  }
}

ChosenPositions Chooser::run() {
  ChosenPositions chosen;
  chosen.grid.resize(positions_.size());
  for (vertex_ = writer_.next(); vertex_ != kNone; vertex_ = writer_.next()) {
    const Outlook& o = writer_.outlook();
    quadric_ = quadric_of(vertex_);
    inverse_ = quadric_.a.inverse();
    optimum_ = -0.5 * inverse_ * quadric_.b;
    best_ = {};
    GridPoint nearest;
    for (int k = 0; k < 3; ++k)
      nearest[static_cast<std::size_t>(k)] = rounded(positions_[vertex_][k]);
    for (std::uint32_t p = 0; p < o.plane_count; ++p) try_plane(p);
    if (!std::isfinite(best_.total)) best_.point = nearest;  // by whatever choice tells it
    chosen.grid[vertex_] = best_.point;
    places_[vertex_] = positions_[vertex_] + moved(best_.point);
    done_[vertex_] = true;
    writer_.write(best_.point);
  }
  chosen.payload = writer_.finish();
  return chosen;
}

}  // namespace

ChosenPositions choose_positions(std::span<const Vec3> positions,
                                 const entropy::Connectivity& connectivity, int bits,
                                 double bit_price) {
  return Chooser(positions, connectivity, bits, bit_price).run();
}

CodedBase encode_base_by_planes(std::span<const Vec3> positions,
                                const entropy::Connectivity& connectivity, int step_index,
                                double bit_price) {
  const double step = step_size(step_index);
  CodedBase base;
  base.grid_bits = grid_bits_at(positions, step_index);
  Vec3 corner = positions[0];
  for (const Vec3& p : positions) corner = corner.cwiseMin(p);
  for (int k = 0; k < 3; ++k) {
    base.corner[static_cast<std::size_t>(k)] = std::llround(corner[k] / step);
    corner[k] = static_cast<double>(base.corner[static_cast<std::size_t>(k)]);
  }
  std::vector<Vec3> places;
  places.reserve(positions.size());
  for (const Vec3& p : positions) places.push_back(p / step - corner);
  ChosenPositions chosen = choose_positions(places, connectivity, base.grid_bits, bit_price);
  base.decoded.reserve(positions.size());
  for (const entropy::GridPoint& g : chosen.grid)
    base.decoded.push_back((corner + Vec3(g[0], g[1], g[2])) * step);
  base.distortion = mean_squared_difference(positions, base.decoded);
  base.payload = std::move(chosen.payload);
  return base;
}

}  // namespace nacre::codec
