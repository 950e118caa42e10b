// SPDX-License-Identifier: GPL-3.0-or-later
#include "data/ammonite.h"

#include <algorithm>
#include <cmath>

namespace nacre::data {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kWhorlRatio = 2.05;     // how much the spiral grows per turn
constexpr double kTube = 0.365;          // tube radius over spiral radius; 0.344 would just touch
constexpr double kFlatness = 0.92;       // the tube's thickness over its height
constexpr double kApertureAngle = 0.35;  // where the last whorl ends, from +x toward +y
constexpr double kChamber = 0.9;         // the hollow reaches this far back from the aperture, rad
constexpr double kWall = 0.17;           // wall over tube radius
constexpr int kWhorls = 6;
constexpr double kRibsPerTurn = 25;

double smooth_min(double a, double b, double k) {
  if (std::abs(a - b) >= k) return std::min(a, b);
  const double h = 0.5 + 0.5 * (b - a) / k;
  return b + (a - b) * h - k * h * (1 - h);
}

double smooth_step(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

double bump(double x, double width) { return std::exp(-(x * x) / (width * width)); }

double lattice_value(std::int64_t x, std::int64_t y, std::int64_t z) {
  auto h = static_cast<std::uint64_t>(x * 73856093 ^ y * 19349663 ^ z * 83492791);
  h = (h ^ (h >> 30)) * 0xBF58476D1CE4E5B9ULL;
  h = (h ^ (h >> 27)) * 0x94D049BB133111EBULL;
  return static_cast<double>((h ^ (h >> 31)) >> 11) * 0x1p-52 - 1.0;
}

/// Value noise in -1 .. 1, one feature per unit.
double noise(const Vec3& p) {
  const double fx = std::floor(p[0]), fy = std::floor(p[1]), fz = std::floor(p[2]);
  const auto x = static_cast<std::int64_t>(fx), y = static_cast<std::int64_t>(fy),
             z = static_cast<std::int64_t>(fz);
  const double u = smooth_step(0, 1, p[0] - fx), v = smooth_step(0, 1, p[1] - fy),
               w = smooth_step(0, 1, p[2] - fz);
  double sum = 0;
  for (int k = 0; k < 8; ++k) {
    const int i = k & 1, j = (k >> 1) & 1, l = k >> 2;
    sum += (i ? u : 1 - u) * (j ? v : 1 - v) * (l ? w : 1 - w) * lattice_value(x + i, y + j, z + l);
  }
  return sum;
}

/// Outward relief of the shell, as a share of the tube's radius. `phi` is the angle along the
/// spiral (0 at the aperture, negative inward), `alpha` that around the tube (0 outermost, ±π
/// innermost).
double relief(double phi, double alpha) {
  const double flank = std::abs(alpha);
  const double bend =
      0.10 * std::sin(2 * flank) + 0.05 * flank;  // ribs sweep forward to the venter
  const double phase = kRibsPerTurn * (phi - bend);
  const double venter = smooth_step(1.35, 0.85, flank);  // there each rib forks into two
  const double primary = 0.5 + 0.5 * std::cos(phase), forked = 0.5 + 0.5 * std::cos(2 * phase);
  const double strength = smooth_step(2.7, 1.9, flank) * smooth_step(0.08, 0.22, flank);
  const double ribs = strength * (primary * (1 - venter) + 0.6 * forked * venter);
  const double nodes = bump(flank - 1.05, 0.16) * std::pow(primary, 3.0);
  const double keel = bump(alpha, 0.13) * (0.85 + 0.15 * std::cos(3 * kRibsPerTurn * phi));
  const double growth = std::cos(118 * (phi - bend));
  return 0.085 * ribs + 0.10 * nodes + 0.10 * keel + 0.007 * growth;
}

/// The tube at one whorl: distance bound to its outside, before the aperture cuts it.
double tube(double radial, double z, double c, double phi) {
  const double t = kTube * c * (1 + 0.10 * std::exp(7 * std::min(phi, 0.0)));  // a flared lip
  const double zs = z / kFlatness;
  const double plain = std::sqrt(radial * radial + zs * zs) - t;
  const double age = smooth_step(0.14, 0.30, c);  // the innermost whorls are smooth
  if (age == 0 || plain < -0.5 * t) return plain;
  if (plain > 0.4 * t) return plain - 0.3 * t * age;  // no relief reaches higher
  return plain - t * age * relief(phi, std::atan2(zs, radial));
}

double shell(const Vec3& p) {
  const double rho = std::sqrt(p[0] * p[0] + p[1] * p[1]);
  double theta = std::atan2(p[1], p[0]) - kApertureAngle;  // to (-2π, 0]
  while (theta > 0) theta -= 2 * kPi;
  while (theta <= -2 * kPi) theta += 2 * kPi;
  const double growth = std::log(kWhorlRatio) / (2 * kPi);
  double c = std::exp(growth * theta) * kWhorlRatio, phi = theta + 2 * kPi;
  double d = 1e9, chamber = 1e9;
  for (int n = -1; n < kWhorls; ++n, c /= kWhorlRatio, phi -= 2 * kPi) {
    if (phi > kPi / 2) continue;  // the far side of the aperture
    const double radial = rho - c;
    double whorl = tube(radial, p[2], c, phi);
    const double cap = phi > -kPi / 2 ? rho * std::sin(phi) : -rho;
    if (phi > -2.2) {
      const double zs = p[2] / kFlatness;
      const double hollow = std::sqrt(radial * radial + zs * zs) -
                            kTube * c * (1 - kWall) * (1 + 0.10 * std::exp(7 * std::min(phi, 0.0)));
      chamber = std::min(
          chamber,
          std::max(hollow, -rho * std::sin(std::clamp(phi + kChamber, -kPi / 2, kPi / 2))));
    }
    whorl = -smooth_min(-whorl, -cap, 0.03);
    d = smooth_min(d, whorl, 0.035 * c);
  }
  const Vec3 seed(p[0] / 0.15, p[1] / 0.15, p[2] / 0.045);  // closes the middle, too small to scan
  d = smooth_min(d, (norm(seed) - 1) * 0.045, 0.02);
  return -smooth_min(-d, chamber, 0.03);
}

double rock(const Vec3& p) {
  const Vec3 q = p - Vec3(0.02, -1.42, 0.0);
  const Vec3 s(q[0] / 1.05, q[1] / 0.42, q[2] / 0.72);
  const double ellipsoid = (norm(s) - 1) * 0.42;
  const double rough = 0.085 * noise(2.6 * p) + 0.035 * noise(6.5 * p) + 0.014 * noise(15 * p);
  return std::max(ellipsoid + (ellipsoid < 0.4 ? rough : 0.0), -0.20 - q[1]);
}

}  // namespace

double ammonite(const Vec3& p) { return smooth_min(shell(p), rock(p), 0.05); }

}  // namespace nacre::data
