// SPDX-License-Identifier: GPL-3.0-or-later
#include "data/range_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"

namespace nacre::data {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kRadiansPerDegree = kPi / 180;
constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();
constexpr double kJump = 4.0;            // pixels; a deeper step between neighbours is an edge
constexpr double kGrazing = 0.16;        // below this cosine nothing comes back
constexpr double kUnsureGrazing = 0.40;  // up to this one, not always

enum Stream : std::uint64_t {
  kPose = 1,
  kTurn,
  kSpot,
  kSpotSize,
  kDust,
  kDustSize,
  kWhite = 100,
  kDrop = 200
};

struct Pose {
  Vec3 right, up, toward;
};

Pose pose(double azimuth_deg, double elevation_deg) {
  const double a = azimuth_deg * kRadiansPerDegree, e = elevation_deg * kRadiansPerDegree;
  Pose p;
  p.toward = Vec3(std::cos(e) * std::sin(a), std::sin(e), std::cos(e) * std::cos(a));
  p.right = Vec3(std::cos(a), 0, -std::sin(a));
  p.up = cross(p.toward, p.right);
  return p;
}

/// What the scanner does not know: a small turn and shift of the whole object.
struct Misplacement {
  Vec3 turn, shift;
  [[nodiscard]] Vec3 operator()(const Vec3& p) const { return p + cross(turn, p) + shift; }
};

/// Steps along a ray from outside until the surface is crossed, then halves the last step.
double march(const Target& target, const Vec3& start, const Vec3& direction, double length,
             double smallest_step) {
  double t = 0, before = 0;
  while (t < length) {
    const double d = target.distance(start + t * direction);
    if (d <= 0) break;
    before = t;
    t += std::max(d / target.lipschitz, smallest_step);
  }
  if (t >= length) return std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 12; ++i) {
    const double middle = (before + t) / 2;
    (target.distance(start + middle * direction) > 0 ? before : t) = middle;
  }
  return t;
}

Vec3 gradient(const Target& target, const Vec3& p, double h) {
  Vec3 g;
  for (int k = 0; k < 3; ++k) {
    const Vec3 e = h * Vec3::Unit(k);
    g[k] = target.distance(p + e) - target.distance(p - e);
  }
  return g / (norm(g) + 1e-300);
}

/// Where a random line from above meets the surface first, and the way it came.
struct Landing {
  Vec3 point, along;
};

Landing land(const Target& target, const Random& random, std::uint64_t stream, int index) {
  const auto i = static_cast<std::uint64_t>(index);
  Vec3 from = target.radius * random.direction(stream, 2 * i);
  from[1] = std::abs(from[1]);
  const Vec3 aim = 0.5 * target.radius * random.direction(stream, 2 * i + 1);
  const Vec3 along = (aim - from) / norm(aim - from);
  const double t = march(target, from, along, 2 * target.radius, 1e-3 * target.radius);
  return {std::isnan(t) ? aim : Vec3(from + t * along), along};
}

std::vector<Ball> dark_spots(const Target& target, const SimulationOptions& options) {
  const Random random{options.seed};
  std::vector<Ball> spots;
  for (int i = 0; i < options.dark_spots; ++i) {
    const double size = 0.020 + 0.025 * random.uniform(kSpotSize, static_cast<std::uint64_t>(i));
    spots.push_back({land(target, random, kSpot, i).point, size * target.radius});
  }
  return spots;
}

/// Specks that float in front of the surface.
std::vector<Ball> dust(const Target& target, const SimulationOptions& options) {
  const Random random{options.seed};
  std::vector<Ball> specks;
  for (int i = 0; i < options.dust; ++i) {
    const auto index = static_cast<std::uint64_t>(i);
    const double size = (0.030 + 0.02 * random.uniform(kDustSize, index)) * target.radius;
    const Landing on = land(target, random, kDust, i);
    specks.push_back({on.point - (0.03 * target.radius + size) * on.along, size});
  }
  return specks;
}

bool within(const std::vector<Ball>& balls, const Vec3& p) {
  return std::any_of(balls.begin(), balls.end(),
                     [&](const Ball& b) { return norm(p - b.center) < b.radius; });
}

void drop_jumps(RangeView& view) {
  const int n = view.pixels;
  const std::vector<float> before = view.height;
  const auto limit = static_cast<float>(kJump * view.pixel_size);
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      const std::size_t i = static_cast<std::size_t>(y) * n + x;
      const auto behind = [&](int dx, int dy) {
        const int u = x + dx, v = y + dy;
        return u >= 0 && v >= 0 && u < n && v < n &&
               before[static_cast<std::size_t>(v) * n + u] - before[i] > limit;
      };
      if (behind(1, 0) || behind(-1, 0) || behind(0, 1) || behind(0, -1)) view.height[i] = kNothing;
    }
  }
}

/// A turntable whose stops look down and slightly up in turn, then two steep views.
std::vector<Pose> poses(const SimulationOptions& options) {
  std::vector<Pose> all;
  for (int k = 0; k < options.turntable_views; ++k)
    all.push_back(pose(360.0 * k / options.turntable_views + 8, k % 2 == 0 ? 26 : -12));
  for (int k = 0; k < 2; ++k) all.push_back(pose(180.0 * k + 20, 58));
  return all;
}

/// The specks that only this view sees: those it looks at most squarely.
std::vector<Ball> specks_of(std::size_t view, const std::vector<Pose>& all,
                            const std::vector<Ball>& specks) {
  std::vector<Ball> mine;
  for (const Ball& speck : specks) {
    std::size_t best = 0;
    for (std::size_t k = 1; k < all.size(); ++k)
      if (dot(all[k].toward, speck.center) > dot(all[best].toward, speck.center)) best = k;
    if (best == view) mine.push_back(speck);
  }
  return mine;
}

/// One view's measurement of one ray at a time.
class Scanner {
 public:
  Scanner(const Target& seen, const SimulationOptions& options, const RangeView& view,
          std::uint64_t index, const std::vector<Ball>& dark)
      : seen_(seen),
        options_(options),
        view_(view),
        index_(index),
        dark_(dark),
        random_{options.seed},
        misplaced_{options.rotation_deg * kRadiansPerDegree * random_.gaussian3(kTurn, index),
                   options.registration * seen.radius * random_.gaussian3(kPose, index)} {}

  /// False when nothing comes back.
  bool measure(std::size_t pixel, RangeView::Sample& out) const {
    const auto n = static_cast<std::size_t>(view_.pixels);
    const auto offset = [&](std::size_t i) {
      return (static_cast<double>(i) + 0.5 - 0.5 * static_cast<double>(n)) * view_.pixel_size;
    };
    const double x = offset(pixel % n), y = offset(pixel / n);
    const double half = seen_.radius * seen_.radius - x * x - y * y;
    if (half <= 0) return false;
    const double top = std::sqrt(half);
    // The ray in the object's own frame: it is the object that is not where it should be.
    const Vec3 from = misplaced_(x * view_.right + y * view_.up + top * view_.toward);
    const Vec3 along = -(view_.toward + cross(misplaced_.turn, view_.toward));
    const double t = march(seen_, from, along, 2 * top, 0.1 * view_.pixel_size);
    if (std::isnan(t)) return false;
    const Vec3 hit = from + t * along;
    if (within(dark_, hit)) return false;
    out.facing = -dot(gradient(seen_, hit, 0.5 * view_.pixel_size), along);
    const double chance = (out.facing - kGrazing) / (kUnsureGrazing - kGrazing);
    if (random_.uniform(kDrop + index_, pixel) > chance) return false;
    const double spread = options_.depth_noise * seen_.radius / std::max(out.facing, 0.4);
    out.height = top - t + spread * random_.gaussian(kWhite + index_, pixel);
    return true;
  }

 private:
  const Target& seen_;
  const SimulationOptions& options_;
  const RangeView& view_;
  std::uint64_t index_;
  const std::vector<Ball>& dark_;
  Random random_;
  Misplacement misplaced_;
};

}  // namespace

bool RangeView::sample(const Vec3& p, Sample& out) const {
  const double x = dot(p, right) / pixel_size + 0.5 * pixels - 0.5;
  const double y = dot(p, up) / pixel_size + 0.5 * pixels - 0.5;
  if (!(x >= 0 && y >= 0 && x < pixels - 1 && y < pixels - 1)) return false;
  const auto i = static_cast<std::size_t>(x), j = static_cast<std::size_t>(y);
  const double u = x - static_cast<double>(i), v = y - static_cast<double>(j);
  const std::size_t a = j * static_cast<std::size_t>(pixels) + i,
                    b = a + static_cast<std::size_t>(pixels);
  const auto mix = [&](const std::vector<float>& f) {
    return (1 - v) * ((1 - u) * f[a] + u * f[a + 1]) + v * ((1 - u) * f[b] + u * f[b + 1]);
  };
  out.height = mix(height);
  out.facing = mix(facing);
  if (std::isnan(out.height)) return false;
  const auto [low, high] = std::minmax({height[a], height[a + 1], height[b], height[b + 1]});
  return high - low < kJump * pixel_size;
}

std::vector<RangeView> scan_views(const Target& target, const SimulationOptions& options) {
  const std::vector<Ball> dark = dark_spots(target, options), specks = dust(target, options);
  const std::vector<Pose> all = poses(options);
  const auto n = static_cast<std::size_t>(options.view_pixels);
  std::vector<RangeView> views;
  for (std::size_t k = 0; k < all.size(); ++k) {
    RangeView view;
    view.right = all[k].right, view.up = all[k].up, view.toward = all[k].toward;
    view.pixels = options.view_pixels;
    view.pixel_size = 2 * target.radius / options.view_pixels;
    view.height.assign(n * n, kNothing);
    view.facing.assign(n * n, 0);

    Target seen = target;
    const std::vector<Ball> mine = specks_of(k, all, specks);
    seen.distance = [&](const Vec3& p) {
      double d = target.distance(p);
      for (const Ball& speck : mine) d = std::min(d, norm(p - speck.center) - speck.radius);
      return d;
    };
    const Scanner scanner(seen, options, view, k, dark);
    const auto measure = [&](std::size_t i) {
      RangeView::Sample sample{};
      if (!scanner.measure(i, sample)) return;
      view.height[i] = static_cast<float>(sample.height);
      view.facing[i] = static_cast<float>(sample.facing);
    };
    parallel_for_each_index(n * n, measure, 64);
    drop_jumps(view);
    views.push_back(std::move(view));
  }
  return views;
}

}  // namespace nacre::data
