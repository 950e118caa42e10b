// SPDX-License-Identifier: GPL-3.0-or-later
#include "metric/sampling.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "metric/triangle.h"

namespace nacre::metric {
namespace {

/// splitmix64 [Steele2014]: every output bit depends on every input bit.
std::uint64_t hash(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15u;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}

double unit_interval(std::uint64_t x) { return static_cast<double>(x >> 11) * 0x1p-53; }

/// Moves bit i of a 21-bit number to bit 3 i.
std::uint64_t spread_bits(std::uint64_t x) {
  x = (x | x << 32) & 0x001F00000000FFFFu;
  x = (x | x << 16) & 0x001F0000FF0000FFu;
  x = (x | x << 8) & 0x100F00F00F00F00Fu;
  x = (x | x << 4) & 0x10C30C30C30C30C3u;
  x = (x | x << 2) & 0x1249249249249249u;
  return x;
}

double face_twice_area(const Scan& scan, std::uint32_t face) {
  const Triangle& t = scan.triangles[face];
  return twice_area(scan.positions[t[0]], scan.positions[t[1]], scan.positions[t[2]]);
}

Vec3 centroid(const Scan& scan, std::uint32_t face) {
  const Triangle& t = scan.triangles[face];
  return (scan.positions[t[0]] + scan.positions[t[1]] + scan.positions[t[2]]) / 3;
}

/// The faces with an area, along a Morton curve; equal codes keep the order of the scan.
std::vector<std::uint32_t> faces_along_curve(const Scan& scan) {
  std::vector<std::uint32_t> faces;
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (std::uint32_t f = 0; f < scan.triangles.size(); ++f) {
    if (!(face_twice_area(scan, f) > 0)) continue;
    faces.push_back(f);
    const Vec3 c = centroid(scan, f);
    low = low.cwiseMin(c);
    high = high.cwiseMax(c);
  }
  constexpr double kCells = 2097151;  // 21 bits per axis
  const double extent = (high - low).maxCoeff();
  const double scale = extent > 0 ? kCells / extent : 0;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> coded;
  coded.reserve(faces.size());
  for (const std::uint32_t f : faces) {
    const Vec3 cell = (centroid(scan, f) - low) * scale;
    std::uint64_t code = 0;
    for (int k = 0; k < 3; ++k)
      code |= spread_bits(static_cast<std::uint64_t>(std::clamp(cell[k], 0.0, kCells))) << k;
    coded.emplace_back(code, f);
  }
  std::sort(coded.begin(), coded.end());
  std::transform(coded.begin(), coded.end(), faces.begin(), [](const auto& c) { return c.second; });
  return faces;
}

}  // namespace

SurfaceSampler::SurfaceSampler(const Scan& scan, std::size_t sample_count, std::uint64_t seed)
    : scan_(&scan), seed_(seed), faces_(faces_along_curve(scan)) {
  std::vector<double> area_up_to(faces_.size() + 1, 0.0);
  for (std::size_t i = 0; i < faces_.size(); ++i)
    area_up_to[i + 1] = area_up_to[i] + face_twice_area(scan, faces_[i]);
  const double wanted = static_cast<double>(sample_count);
  first_sample_.reserve(area_up_to.size());
  for (const double a : area_up_to)
    first_sample_.push_back(
        static_cast<std::size_t>(std::floor(a / area_up_to.back() * wanted + 0.5)));

  std::vector<bool> seen(scan.positions.size(), false);
  for (const std::uint32_t f : faces_) {
    for (const std::uint32_t v : scan.triangles[f]) {
      if (!seen[v]) vertices_.push_back(v);
      seen[v] = true;
    }
  }
}

std::size_t SurfaceSampler::face_of(std::size_t sample) const {
  const auto after = std::upper_bound(first_sample_.begin(), first_sample_.end(), sample);
  return static_cast<std::size_t>(after - first_sample_.begin()) - 1;
}

Vec3 SurfaceSampler::point(std::size_t face, std::size_t k) const {
  // Steps of the R2 sequence as fractions of 2^64: 1/g and 1/g² for g³ = g + 1, so that the
  // addition wraps exactly where the sequence does.
  constexpr std::uint64_t kStepU = 0xC13FA9A902A6328Fu;
  constexpr std::uint64_t kStepV = 0x91E10DA5C79E7B1Du;
  const std::uint32_t f = faces_[face];
  const std::uint64_t shift_u = hash(seed_ ^ hash(f));
  const std::uint64_t shift_v = hash(shift_u);
  double u = unit_interval(shift_u + kStepU * k);
  double v = unit_interval(shift_v + kStepV * k);
  if (u + v > 1) {  // the half of the parallelogram outside the triangle, turned into it
    u = 1 - u;
    v = 1 - v;
  }
  const Triangle& t = scan_->triangles[f];
  const Vec3& a = scan_->positions[t[0]];
  return a + u * (scan_->positions[t[1]] - a) + v * (scan_->positions[t[2]] - a);
}

}  // namespace nacre::metric
