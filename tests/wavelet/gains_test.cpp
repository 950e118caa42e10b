// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "meshes.h"
#include "wavelet/wavelet.h"

namespace nacre::wavelet {
namespace {

using testing::topology_of;

/// Energy of one impulse at a base vertex of a large torus after all its refinements.
double refined_impulse_energy(int levels, Transform transform) {
  const Topology topology = topology_of(shapes::torus(14, 14), levels);
  Pyramid pyramid;
  pyramid.base_positions.assign(14 * 14, Vec3::Zero());
  pyramid.base_positions[100][0] = 1;
  for (int j = 0; j < levels; ++j) pyramid.bands.emplace_back(topology.band_size(j), Vec3::Zero());
  double sum = 0;
  const std::vector<Vec3> refined = *synthesize(topology, pyramid, transform);
  for (const Vec3& p : refined) sum += p[0] * p[0];
  return sum;
}

TEST(RegularGains, AreThoseOfTheRefinedImpulse) {
  for (const Transform transform : {Transform::kButterfly, Transform::kLoop}) {
    for (int k = 0; k <= 5; ++k) {
      EXPECT_NEAR(regular_gains(k, transform).energy[0] / refined_impulse_energy(k, transform), 1,
                  1e-12)
          << k;
    }
  }
}

TEST(RegularGains, MatchTheKnownTable) {
  const std::vector<double> known = {1,          2.640625,   10.077637,  40.164011,
                                     160.615435, 642.451004, 2569.80125, 10279.2043};
  const Gains gains = regular_gains(7);
  // Base first, finest band last: E_7, then E_6 .. E_0.
  ASSERT_EQ(gains.energy.size(), 8u);
  for (std::size_t k = 0; k < 8; ++k)
    EXPECT_NEAR(gains.energy[7 - k] / known[k], 1, 1e-7) << "E_" << k;
  EXPECT_EQ(regular_gains(0).energy, std::vector<double>{1.0});
}

TEST(RegularGains, ShorterPyramidsAreTailsOfLongerOnes) {
  for (const Transform transform : {Transform::kButterfly, Transform::kLoop}) {
    const Gains ten = regular_gains(10, transform), three = regular_gains(3, transform);
    ASSERT_EQ(three.energy.size(), 4u);
    for (std::size_t i = 1; i <= 4; ++i) EXPECT_EQ(three.energy[4 - i], ten.energy[11 - i]);
  }
}

/// Σ of squares of every single refined impulse, over their number: what the signals estimate.
double exact_base_gain(const Topology& topology, Transform transform) {
  const std::size_t count = topology.level(0).vertex_count;
  double total = 0;
  for (std::size_t v = 0; v < count; ++v) {
    Pyramid pyramid;
    pyramid.base_positions.assign(count, Vec3::Zero());
    pyramid.base_positions[v][1] = 1;
    for (int j = 0; j < topology.level_count(); ++j)
      pyramid.bands.emplace_back(topology.band_size(j), Vec3::Zero());
    const std::vector<Vec3> refined = *synthesize(topology, pyramid, transform);
    for (const Vec3& p : refined) total += p[1] * p[1];
  }
  return total / static_cast<double>(count);
}

TEST(MeasuredGains, EstimateTheMeanOverAllImpulses) {
  for (const Transform transform : {Transform::kButterfly, Transform::kLoop}) {
    for (const Scan& scan : {testing::flipped_sphere(2, 400, 5), shapes::grid(5, 5)}) {
      const Topology topology = topology_of(scan, 3);
      const Gains gains = measured_gains(topology, transform);
      ASSERT_EQ(gains.energy.size(), 4u);
      EXPECT_NEAR(gains.energy[0] / exact_base_gain(topology, transform), 1, 0.1);
      EXPECT_EQ(gains.energy[3], 1.0);
    }
  }
}

TEST(MeasuredGains, ApproachTheRegularOnesOnATorus) {
  const Topology topology = topology_of(shapes::torus(24, 24), 4);
  for (const Transform transform : {Transform::kButterfly, Transform::kLoop}) {
    const Gains measured = measured_gains(topology, transform),
                regular = regular_gains(4, transform);
    for (std::size_t i = 0; i < 5; ++i)
      EXPECT_NEAR(measured.energy[i] / regular.energy[i], 1, 0.05) << i;
  }
}

TEST(MeasuredGains, AreTheSameAtAnyThreadCount) {
  const Topology topology = topology_of(shapes::icosahedron(), 4);
  const auto with_threads = [&](std::size_t n) {
    tbb::global_control control(tbb::global_control::max_allowed_parallelism, n);
    return measured_gains(topology).energy;
  };
  EXPECT_EQ(with_threads(1), with_threads(4));
}

}  // namespace
}  // namespace nacre::wavelet
