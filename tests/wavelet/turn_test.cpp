// SPDX-License-Identifier: GPL-3.0-or-later
#include "wavelet/turn.h"

#include <gtest/gtest.h>

#include <cmath>

namespace nacre::wavelet {
namespace {

TEST(Turn, AgreesWithLibm) {
  for (const std::uint32_t K : {1u, 2u, 3u, 4u, 5u, 7u, 8u, 12u, 97u, 1000u, 65537u}) {
    for (std::uint32_t m = 0; m < K; ++m) {
      const long double angle = 2 * std::acos(-1.0L) * m / K;
      const CosSin t = turn(m, K);
      ASSERT_NEAR(t.cos, static_cast<double>(std::cos(angle)), 3e-16) << m << "/" << K;
      ASSERT_NEAR(t.sin, static_cast<double>(std::sin(angle)), 3e-16) << m << "/" << K;
    }
  }
}

TEST(Turn, IsExactOnTheAxes) {
  for (const std::uint32_t K : {4u, 4000u, 0xFFFFFFFCu}) {
    EXPECT_EQ(turn(0, K).cos, 1.0);
    EXPECT_EQ(turn(0, K).sin, 0.0);
    EXPECT_EQ(turn(K / 4, K).cos, 0.0);
    EXPECT_EQ(turn(K / 4, K).sin, 1.0);
    EXPECT_EQ(turn(K / 2, K).cos, -1.0);
    EXPECT_EQ(turn(K / 2, K).sin, 0.0);
    EXPECT_EQ(turn(3 * (K / 4), K).cos, 0.0);
    EXPECT_EQ(turn(3 * (K / 4), K).sin, -1.0);
  }
}

TEST(Turn, IsSymmetricToTheBit) {
  constexpr std::uint32_t K = 1003;
  for (std::uint32_t m = 1; m < K; ++m) {
    EXPECT_EQ(turn(m, K).cos, turn(K - m, K).cos);
    EXPECT_EQ(turn(m, K).sin, -turn(K - m, K).sin);
  }
}

}  // namespace
}  // namespace nacre::wavelet
