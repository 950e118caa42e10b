// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/soup.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace nacre::io {
namespace {

constexpr double kFarInDiagonals = 16.0;
constexpr std::size_t kMaxNotCarried = 64;  // a hostile file can hold any number of names
// Ear clipping is quadratic; a file's polygons share this many steps (a few seconds), then fans.
constexpr std::size_t kEarStepsPerFile = std::size_t{1} << 30;

constexpr double kNoEar = std::numeric_limits<double>::infinity();

void fan(std::span<const std::uint32_t> corners, std::span<Triangle> triangles) {
  for (std::size_t i = 0; i + 2 < corners.size(); ++i) {
    triangles[i] = {corners[0], corners[i + 1], corners[i + 2]};
  }
}

/// The corners not yet cut off, as a ring.
class EarRing {
 public:
  EarRing(std::span<const std::uint32_t> corners, std::span<const Vec3> positions)
      : corners_(corners), positions_(positions), ring_(corners.size()), left_(corners.size()) {
    const std::size_t n = corners.size();
    for (std::size_t i = 0; i < n; ++i) {
      ring_[i] = {(i + n - 1) % n, (i + 1) % n, kNoEar};
      normal_ += cross(point(i) - point(0), point((i + 1) % n) - point(0));
    }
    for (std::size_t i = 0; i < n; ++i) ring_[i].diagonal = squared_diagonal(i);
  }

  [[nodiscard]] std::size_t left() const { return left_; }
  [[nodiscard]] std::size_t first() const { return first_; }
  [[nodiscard]] std::size_t next(std::size_t i) const { return ring_[i].next; }

  /// The ear with the shortest diagonal, the earliest of equal ones; corners.size() if there is
  /// none.
  [[nodiscard]] std::size_t best_ear() const {
    std::size_t best = corners_.size(), i = first_;
    double shortest = kNoEar;
    for (std::size_t k = 0; k < left_; ++k, i = ring_[i].next) {
      if (ring_[i].diagonal < shortest) shortest = ring_[best = i].diagonal;
    }
    return best;
  }

  /// Removes corner i and returns its triangle. Only its neighbours can change being ears.
  Triangle cut(std::size_t i) {
    const auto [before, after, unused] = ring_[i];
    ring_[before].next = after;
    ring_[after].previous = before;
    if (i == first_) first_ = after;
    --left_;
    ring_[before].diagonal = squared_diagonal(before);
    ring_[after].diagonal = squared_diagonal(after);
    return {corners_[before], corners_[i], corners_[after]};
  }

 private:
  struct Link {
    std::size_t previous, next;
    double diagonal;
  };
  [[nodiscard]] const Vec3& point(std::size_t i) const { return positions_[corners_[i]]; }
  [[nodiscard]] double area(const Vec3& a, const Vec3& b, const Vec3& c) const {
    return dot(cross(b - a, c - a), normal_);
  }

  [[nodiscard]] double squared_diagonal(std::size_t i) const {
    const Vec3 &a = point(ring_[i].previous), &b = point(i), &c = point(ring_[i].next);
    if (!(area(a, b, c) > 0.0)) return kNoEar;
    std::size_t k = ring_[ring_[i].next].next;
    for (; k != ring_[i].previous; k = ring_[k].next) {
      const Vec3& p = point(k);
      if (p == a || p == b || p == c) continue;
      if (area(a, b, p) >= 0.0 && area(b, c, p) >= 0.0 && area(c, a, p) >= 0.0) return kNoEar;
    }
    return dot(c - a, c - a);
  }

  std::span<const std::uint32_t> corners_;
  std::span<const Vec3> positions_;
  std::vector<Link> ring_;
  Vec3 normal_ = Vec3::Zero();
  std::size_t left_;
  std::size_t first_ = 0;
};

}  // namespace

void triangulate_polygon(std::span<const std::uint32_t> corners, std::span<const Vec3> positions,
                         std::span<Triangle> triangles) {
  EarRing ring(corners, positions);
  std::size_t made = 0;
  while (ring.left() > 3) {
    const std::size_t ear = ring.best_ear();
    if (ear == corners.size()) break;
    triangles[made++] = ring.cut(ear);
  }
  std::vector<std::uint32_t> rest;
  for (std::size_t k = 0, i = ring.first(); k < ring.left(); ++k, i = ring.next(i)) {
    rest.push_back(corners[i]);
  }
  fan(rest, triangles.subspan(made));
}

Vec3 choose_origin(const Scan& scan) {
  // Over the triangles: a placeholder vertex at zero that no face uses must not count.
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Triangle& t : scan.triangles) {
    for (const std::uint32_t v : t) {
      low = low.cwiseMin(scan.positions[v]);
      high = high.cwiseMax(scan.positions[v]);
    }
  }
  const double diagonal = norm(high - low);
  const Vec3 center = low + (high - low) / 2.0;
  if (!(diagonal > 0.0) || !(norm(center) > kFarInDiagonals * diagonal)) return Vec3::Zero();
  const double step = std::exp2(std::floor(std::log2(diagonal)));
  if (!(step > 0.0)) return Vec3::Zero();
  return (center / step).array().round().matrix() * step;
}

void Soup::add_face(std::span<const std::uint32_t> corners) {
  ++face_count_;
  if (corners.size() < 3) {
    ++skipped_;
    return;
  }
  if (corners.size() > 3) {
    polygons_.push_back({triangles_.size(), polygon_corners_.size(), corners.size()});
    polygon_corners_.insert(polygon_corners_.end(), corners.begin(), corners.end());
    triangles_.resize(triangles_.size() + corners.size() - 2);
    return;
  }
  triangles_.push_back({corners[0], corners[1], corners[2]});
}

void Soup::note_not_carried(std::string_view name) {
  if (not_carried_.size() >= kMaxNotCarried) return;
  if (std::find(not_carried_.begin(), not_carried_.end(), name) != not_carried_.end()) return;
  not_carried_.emplace_back(name);
}

Result<ReadResult> Soup::finish(const Source& source, std::string format) && {
  if (triangles_.empty()) {
    std::string what = source.name + ": ";
    if (positions.empty()) {
      what += "no vertices and no faces; check that this is the right file";
    } else if (face_count_ > 0) {
      what += "none of " + std::to_string(face_count_) + " faces has three corners; " +
              kRemedyExport + " with faces";
    } else {
      what += std::to_string(positions.size()) +
              " vertices and no faces, a point cloud; reconstruct a surface from it first";
    }
    return Error{ErrorCode::kUnreadableFile, what, 0};
  }
  std::size_t steps_left = kEarStepsPerFile;
  for (const Polygon& polygon : polygons_) {
    const std::size_t n = polygon.corner_count;
    const std::span corners = std::span(polygon_corners_).subspan(polygon.first_corner, n);
    const std::span triangles = std::span(triangles_).subspan(polygon.first_triangle, n - 2);
    if (n > steps_left / n / 4) {
      fan(corners, triangles);
      continue;
    }
    steps_left -= 4 * n * n;
    triangulate_polygon(corners, positions, triangles);
  }
  ReadResult result;
  result.report.format = std::move(format);
  result.report.file_bytes = source.bytes.size();
  result.report.polygons_triangulated = polygons_.size();
  result.report.faces_skipped = skipped_;
  result.report.not_carried = std::move(not_carried_);
  result.scan.positions = std::move(positions);
  result.scan.triangles = std::move(triangles_);
  result.scan.origin = choose_origin(result.scan);
  if (!result.scan.origin.isZero(0.0)) {
    for (Vec3& p : result.scan.positions) p -= result.scan.origin;
  }
  return result;
}

}  // namespace nacre::io
