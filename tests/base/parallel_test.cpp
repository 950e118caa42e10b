// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/parallel.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

namespace nacre {
namespace {

double harmonic_sum() {
  return deterministic_sum<double>(100'000, [](std::size_t i) { return std::sin(double(i)) / (double(i) + 1); });
}

TEST(DeterministicSum, IsTheSameBitsAtAnyThreadCount) {
  const double many = harmonic_sum();
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(harmonic_sum(), many);
}

TEST(DeterministicSum, OfNothingIsZero) {
  EXPECT_EQ(deterministic_sum<double>(0, [](std::size_t) { return 1.0; }), 0.0);
}

}  // namespace
}  // namespace nacre
