// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/chart.h"

#include <algorithm>
#include <cmath>

#include "remesh/adjacency.h"
#include "remesh/indices_where.h"

namespace nacre::remesh {
namespace {

using Vec2 = Eigen::Vector2d;

/// Corners of the unit triangle that every base triangle is.
const std::array<Vec2, 3> kUnit = {Vec2(0, 0), Vec2(1, 0), Vec2(0.5, 0.86602540378443864676)};

constexpr std::size_t kMostPoints = 4;  // that share a chart
/// Triangles further apart than this many, counted outward from the middle one, have no net.
constexpr std::size_t kNetSize = 12;
constexpr double kWedge = M_PI / 3;  // the angle of a unit triangle

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
    exponent_.push_back(!star.boundary ? 6 / k : std::min(1.0, 3 / k));
    for (std::size_t m = 0; m < star.faces.size(); ++m)
      star_faces_.push_back({star.faces[m], corner_of(base.triangles[star.faces[m]], v)});
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
  if (common == kNone) {
    chart.kind_ = Chart::Kind::kNet;
    chart.net_ = net_of(triangles);
    if (!chart.net_) return std::nullopt;
    return chart;
  }
  chart.kind_ = Chart::Kind::kStar;
  chart.id_ = common;
  return chart;
}

std::optional<DomainPoint> Atlas::seen_from(const DomainPoint& point,
                                            std::uint32_t triangle) const {
  if (point.face == triangle) return point;
  DomainPoint seen{triangle, {}};
  for (std::size_t k = 0; k < 3; ++k) {
    if (point.weight[k] == 0) continue;
    const std::uint32_t v = base_.triangles[point.face][k];
    const std::uint32_t c = corner_of(base_.triangles[triangle], v);
    if (base_.triangles[triangle][c] != v) return std::nullopt;
    seen.weight[c] = point.weight[k];
  }
  return seen;
}

std::optional<Atlas::Chart> Atlas::common_chart(std::span<DomainPoint> points) const {
  std::array<std::uint32_t, kMostPoints> faces{};
  bool same = true;
  for (std::size_t i = 0; i < points.size(); ++i) {
    faces[i] = points[i].face;
    same &= faces[i] == faces[0];
  }
  if (same) return triangle_chart(faces[0]);
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::array<DomainPoint, kMostPoints> all;
    std::size_t seen = 0;
    for (; seen < points.size(); ++seen) {
      const auto p = seen_from(points[seen], faces[i]);
      if (!p) break;
      all[seen] = *p;
    }
    if (seen < points.size()) continue;
    std::copy_n(all.begin(), seen, points.begin());
    return triangle_chart(faces[i]);
  }
  return common_chart(std::span<const std::uint32_t>(faces.data(), points.size()));
}

std::optional<double> Atlas::doubled_area(std::array<DomainPoint, 3> p) const {
  const auto chart = common_chart(p);
  if (!chart) return std::nullopt;
  const Vec2 a = *chart->map(p[0]);
  return cross2(*chart->map(p[1]) - a, *chart->map(p[2]) - a);
}

std::shared_ptr<const std::vector<Atlas::NetFace>> Atlas::net_of(
    std::span<const std::uint32_t> triangles) const {
  std::vector<std::uint32_t> wanted(triangles.begin(), triangles.end());
  make_unique(wanted);
  std::vector<NetFace> net, best;
  std::size_t nearest = kNetSize;
  for (const std::uint32_t centre : wanted) {
    // Breadth first, the centre's own plane carried over each side.
    net.assign(1, {centre, kUnit});
    std::size_t found = 1;
    for (std::size_t i = 0; i < net.size() && net.size() < nearest && found < wanted.size(); ++i) {
      for (std::uint32_t k = 0; k < 3 && found < wanted.size(); ++k) {
        const std::uint32_t from = net[i].face, next = base_.neighbors[from][k];
        if (next == kNone ||
            std::any_of(net.begin(), net.end(), [&](const NetFace& n) { return n.face == next; }))
          continue;
        const std::uint32_t start =
            corner_of(base_.triangles[next], base_.triangles[from][(k + 1) % 3]);
        const auto& at = net[i].corner;
        NetFace laid{next, {}};
        laid.corner[start] = at[(k + 1) % 3];
        laid.corner[(start + 1) % 3] = at[k];
        laid.corner[(start + 2) % 3] = at[k] + at[(k + 1) % 3] - at[(k + 2) % 3];
        net.push_back(laid);
        found += std::binary_search(wanted.begin(), wanted.end(), next);
      }
    }
    if (found < wanted.size() || net.size() >= nearest) continue;
    nearest = net.size();
    best = net;
  }
  if (best.empty()) return nullptr;
  return std::make_shared<const std::vector<NetFace>>(std::move(best));
}

std::optional<Vec2> Atlas::Chart::map(const DomainPoint& p) const {
  const auto place = [&](const Vec2& a, const Vec2& b, const Vec2& c, std::uint32_t first) -> Vec2 {
    return p.weight[first] * a + p.weight[(first + 1) % 3] * b + p.weight[(first + 2) % 3] * c;
  };
  if (kind_ == Kind::kStar) {
    const auto faces = atlas_->star(id_);
    const double a = atlas_->exponent_[id_];
    for (std::size_t m = 0; m < faces.size(); ++m) {
      if (faces[m].face != p.face) continue;
      const Vec2 local = place(kUnit[0], kUnit[1], kUnit[2], faces[m].corner);
      const double r2 = local.squaredNorm();
      if (r2 == 0) return Vec2::Zero();
      const double angle = a * (std::atan2(local[1], local[0]) + kWedge * static_cast<double>(m));
      const double radius = std::pow(r2, a / 2);
      return Vec2(radius * std::cos(angle), radius * std::sin(angle));
    }
    return std::nullopt;
  }
  if (kind_ == Kind::kNet) {
    for (const NetFace& n : *net_)
      if (n.face == p.face) return place(n.corner[0], n.corner[1], n.corner[2], 0);
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
    const double a = atlas_->exponent_[id_], wedges = static_cast<double>(faces.size());
    const double r2 = place.squaredNorm();
    double angle = std::atan2(place[1], place[0]) / (a * kWedge);  // in wedges
    if (angle < 0) {
      // Behind the boundary: the nearer of its two ends.
      const double round = 2 * M_PI / (a * kWedge);
      angle = round > wedges + 1e-6 && -angle < (round - wedges) / 2 ? 0 : angle + round;
    }
    angle = std::clamp(angle, 0.0, wedges);
    const double m = std::min(std::floor(angle), wedges - 1);
    const double radius = std::pow(r2, 0.5 / a), local = (angle - m) * kWedge;
    const auto w = weights_in(kUnit[0], kUnit[1], kUnit[2],
                              Vec2(radius * std::cos(local), radius * std::sin(local)));
    const StarFace& face = faces[static_cast<std::size_t>(m)];
    std::array<double, 3> rotated{};
    for (std::uint32_t k = 0; k < 3; ++k) rotated[(face.corner + k) % 3] = w[k];
    return clamped(face.face, rotated);
  }
  if (kind_ == Kind::kNet) {
    double best = -1e300;
    DomainPoint out;
    for (const NetFace& n : *net_) {
      const auto w = weights_in(n.corner[0], n.corner[1], n.corner[2], place);
      const double least = std::min({w[0], w[1], w[2]});
      if (least <= best) continue;
      best = least;
      out = clamped(n.face, w);
      if (least >= 0) break;
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
