// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/chart.h"

#include <algorithm>
#include <cmath>

#include "remesh/adjacency.h"

namespace nacre::remesh {
namespace {

using Vec2 = Eigen::Vector2d;

/// Corners of the unit triangle that every base triangle is.
const std::array<Vec2, 3> kUnit = {Vec2(0, 0), Vec2(1, 0), Vec2(0.5, 0.86602540378443864676)};

double cross2(const Vec2& a, const Vec2& b) { return a[0] * b[1] - a[1] * b[0]; }

/// Barycentric weights of p in the triangle (a, b, c).
std::array<double, 3> weights_in(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& p) {
  const double area = cross2(b - a, c - a);
  const double wb = cross2(p - a, c - a) / area, wc = cross2(b - a, p - a) / area;
  return {1 - wb - wc, wb, wc};
}

DomainPoint clamped(std::uint32_t face, std::array<double, 3> w) {
  double sum = 0;
  for (double& x : w) {
    x = std::max(x, 0.0);
    sum += x;
  }
  for (double& x : w) x /= sum;
  return {face, w};
}

/// Where the triangle across side k of the unit triangle has its third corner.
Vec2 mirrored_corner(std::uint32_t side) {
  return kUnit[side] + kUnit[(side + 1) % 3] - kUnit[(side + 2) % 3];
}

}  // namespace

Atlas::Atlas(const BaseMesh& base) : base_(base) {
  const auto n = static_cast<std::uint32_t>(base.scan_vertex.size());
  const std::vector<std::uint32_t> first = face_of_vertex(base.triangles, n);
  star_start_.assign(n + 1, 0);
  Star star;
  for (std::uint32_t v = 0; v < n; ++v) {
    collect_star(base.triangles, base.neighbors, v, first[v], star);
    const auto k = static_cast<double>(star.faces.size());
    // A boundary star fills the half plane, unless it is too narrow for that.
    const double span = !star.boundary ? 2 * M_PI : std::min(M_PI, k * M_PI / 3);
    for (std::size_t m = 0; m < star.faces.size(); ++m)
      star_faces_.push_back({star.faces[m], corner_of(base.triangles[star.faces[m]], v)});
    for (std::size_t m = 0; m <= star.faces.size(); ++m) {
      const double angle = span * static_cast<double>(m) / k;
      directions_.emplace_back(std::cos(angle), std::sin(angle));
    }
    star_start_[v + 1] = static_cast<std::uint32_t>(star_faces_.size());
  }
}

Atlas::Chart Atlas::triangle_chart(std::uint32_t triangle) const {
  Chart chart;
  chart.id_ = triangle;
  chart.atlas_ = this;
  return chart;
}

std::optional<Atlas::Chart> Atlas::common_chart(std::span<const std::uint32_t> triangles) const {
  Chart chart = triangle_chart(triangles[0]);
  std::uint32_t other = kNone;
  bool pair = true;
  for (const std::uint32_t t : triangles) {
    if (t == triangles[0] || t == other) continue;
    if (other != kNone) pair = false;
    other = t;
  }
  if (other == kNone) return chart;
  // The same chart whichever triangle comes first.
  for (std::uint32_t k = 0; pair && k < 3; ++k) {
    const std::uint32_t low = std::min(triangles[0], other), high = std::max(triangles[0], other);
    if (base_.neighbors[low][k] != high) continue;
    chart.kind_ = Chart::Kind::kPair;
    chart.id_ = low;
    chart.side_ = k;
    return chart;
  }
  std::uint32_t common = kNone;
  for (const std::uint32_t v : base_.triangles[triangles[0]]) {
    const bool in_all = std::all_of(triangles.begin(), triangles.end(), [&](std::uint32_t t) {
      const Triangle& c = base_.triangles[t];
      return c[0] == v || c[1] == v || c[2] == v;
    });
    if (in_all) common = std::min(common, v);
  }
  if (common == kNone) return std::nullopt;
  chart.kind_ = Chart::Kind::kStar;
  chart.id_ = common;
  return chart;
}

std::optional<Vec2> Atlas::Chart::map(const DomainPoint& p) const {
  const auto place = [&](const Vec2& a, const Vec2& b, const Vec2& c, std::uint32_t first) -> Vec2 {
    return p.weight[first] * a + p.weight[(first + 1) % 3] * b + p.weight[(first + 2) % 3] * c;
  };
  if (kind_ == Kind::kStar) {
    const auto faces = atlas_->star(id_);
    const Vec2* polygon = atlas_->polygon(id_);
    for (std::size_t m = 0; m < faces.size(); ++m) {
      if (faces[m].face == p.face)
        return place(Vec2::Zero(), polygon[m], polygon[m + 1], faces[m].corner);
    }
    return std::nullopt;
  }
  if (p.face == id_) return place(kUnit[0], kUnit[1], kUnit[2], 0);
  if (kind_ == Kind::kTriangle) return std::nullopt;
  const BaseMesh& base = atlas_->base_;
  if (base.neighbors[id_][side_] != p.face) return std::nullopt;
  const std::uint32_t start =
      corner_of(base.triangles[p.face], base.triangles[id_][(side_ + 1) % 3]);
  return place(kUnit[(side_ + 1) % 3], kUnit[side_], mirrored_corner(side_), start);
}

DomainPoint Atlas::Chart::unmap(const Vec2& place) const {
  if (kind_ == Kind::kStar) {
    const auto faces = atlas_->star(id_);
    const Vec2* polygon = atlas_->polygon(id_);
    double best = -1e300;
    DomainPoint out;
    for (std::size_t m = 0; m < faces.size(); ++m) {
      const auto w = weights_in(Vec2::Zero(), polygon[m], polygon[m + 1], place);
      const double least = std::min(w[1], w[2]);
      if (least <= best) continue;
      best = least;
      std::array<double, 3> rotated{};
      for (std::uint32_t k = 0; k < 3; ++k) rotated[(faces[m].corner + k) % 3] = w[k];
      out = clamped(faces[m].face, rotated);
    }
    return out;
  }
  const auto w = weights_in(kUnit[0], kUnit[1], kUnit[2], place);
  if (kind_ == Kind::kTriangle || w[(side_ + 2) % 3] >= 0) return clamped(id_, w);
  const BaseMesh& base = atlas_->base_;
  const std::uint32_t other = base.neighbors[id_][side_];
  const std::uint32_t start =
      corner_of(base.triangles[other], base.triangles[id_][(side_ + 1) % 3]);
  const auto u = weights_in(kUnit[(side_ + 1) % 3], kUnit[side_], mirrored_corner(side_), place);
  std::array<double, 3> rotated{};
  for (std::uint32_t k = 0; k < 3; ++k) rotated[(start + k) % 3] = u[k];
  return clamped(other, rotated);
}

}  // namespace nacre::remesh
