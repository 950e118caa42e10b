// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <set>
#include <vector>

#include "quant/quant.h"

namespace nacre::quant {
namespace {

std::int64_t l1_norm(const LatticePoint& p) {
  return std::abs(std::int64_t{p[0]}) + std::abs(std::int64_t{p[1]}) + std::abs(std::int64_t{p[2]});
}

/// Every point of one shell that has a tangential part, found by looking at the whole cube.
std::vector<LatticePoint> shell(std::int32_t norm) {
  std::vector<LatticePoint> points;
  for (std::int32_t z = -norm; z <= norm; ++z) {
    for (std::int32_t t1 = -norm; t1 <= norm; ++t1) {
      for (std::int32_t t2 = -norm; t2 <= norm; ++t2) {
        const LatticePoint p = {z, t1, t2};
        if (l1_norm(p) == norm && (t1 != 0 || t2 != 0)) points.push_back(p);
      }
    }
  }
  return points;
}

std::int32_t symmetric_below(std::mt19937_64& random, std::int64_t bound) {
  const auto width = static_cast<std::uint64_t>(2 * bound + 1);
  return static_cast<std::int32_t>(static_cast<std::int64_t>(random() % width) - bound);
}

TEST(RankOnShell, NumbersEveryPointOfEverySmallShellOnce) {
  for (std::int32_t norm = 1; norm <= 16; ++norm) {
    const std::vector<LatticePoint> points = shell(norm);
    ASSERT_EQ(points.size(), static_cast<std::size_t>(4 * norm * norm));
    std::set<std::int64_t> ranks;
    for (const LatticePoint& point : points) {
      const std::int64_t rank = rank_on_shell(point);
      ASSERT_GE(rank, 0);
      ASSERT_LT(rank, 4 * norm * norm);
      ASSERT_EQ(unrank_on_shell(norm, rank), point);
      ranks.insert(rank);
    }
    ASSERT_EQ(ranks.size(), points.size());
  }
}

TEST(RankOnShell, GoesByTangentialNormThenSignOfNormal) {
  for (std::int32_t norm = 1; norm <= 12; ++norm) {
    std::array<std::int64_t, 2> before = {0, 0};
    for (std::int64_t rank = 0; rank < 4 * norm * norm; ++rank) {
      const LatticePoint p = unrank_on_shell(norm, rank);
      const std::array<std::int64_t, 2> key = {std::abs(p[1]) + std::abs(p[2]), p[0] < 0 ? 1 : 0};
      ASSERT_LE(before, key) << norm << " " << rank;
      before = key;
    }
  }
}

TEST(RankOnShell, TheShellOfNormTwo) {
  const std::vector<LatticePoint> golden = {{1, 1, 0},  {1, 0, 1},   {1, -1, 0},  {1, 0, -1},
                                            {-1, 1, 0}, {-1, 0, 1},  {-1, -1, 0}, {-1, 0, -1},
                                            {0, 2, 0},  {0, 1, 1},   {0, 0, 2},   {0, -1, 1},
                                            {0, -2, 0}, {0, -1, -1}, {0, 0, -2},  {0, 1, -1}};
  for (std::size_t rank = 0; rank < golden.size(); ++rank) {
    EXPECT_EQ(unrank_on_shell(2, static_cast<std::int64_t>(rank)), golden[rank]) << rank;
  }
}

TEST(RankOnShell, IsExactForTheLargestNorms) {
  std::mt19937_64 random(31);
  for (int i = 0; i < 200000; ++i) {
    const std::int64_t bound = std::int64_t{1} << (random() % 25);
    LatticePoint point = {symmetric_below(random, bound), symmetric_below(random, bound),
                          symmetric_below(random, bound)};
    if (point[1] == 0 && point[2] == 0) point[1] = 1;
    ASSERT_EQ(unrank_on_shell(l1_norm(point), rank_on_shell(point)), point);
  }
  // The ranks on both sides of every change of diamond, where a square root may round.
  const std::int64_t norm = 3 * std::int64_t{kMaxComponent};
  for (std::int64_t m = 2; m <= norm; m += 1 + m / 1000) {
    const LatticePoint last = unrank_on_shell(norm, 4 * m * (m - 1) - 1);
    const LatticePoint first = unrank_on_shell(norm, 4 * m * (m - 1));
    ASSERT_EQ(std::abs(last[1]) + std::abs(last[2]), m - 1);
    ASSERT_EQ(first,
              (LatticePoint{static_cast<std::int32_t>(norm - m), static_cast<std::int32_t>(m), 0}));
  }
}

std::vector<LatticePoint> random_points(std::mt19937_64& random, std::size_t count) {
  std::vector<LatticePoint> points(count);
  for (LatticePoint& p : points) {
    const std::int64_t bound = std::int64_t{1} << (random() % 25);
    const std::uint64_t kind = random() % 4;
    if (kind >= 1) p[0] = symmetric_below(random, bound);
    if (kind >= 2) p[1] = symmetric_below(random, bound);
    if (kind >= 2) p[2] = symmetric_below(random, 1 + bound / 64);
  }
  return points;
}

TEST(ProductCode, SaysNullNormalAndOther) {
  const std::vector<LatticePoint> points = {{0, 0, 0}, {-7, 0, 0}, {1, 1, 0}, {0, 0, 0}, {0, 0, 2}};
  const ProductCode code = to_product_code(points);
  EXPECT_EQ(code.prefix, (std::vector<std::int64_t>{0, -7, 2, 0, 2}));
  EXPECT_EQ(code.suffix, (std::vector<std::int64_t>{0, 1, 11}));
}

TEST(ProductCode, RoundTrips) {
  std::mt19937_64 random(32);
  for (int i = 0; i < 500; ++i) {
    const std::vector<LatticePoint> points = random_points(random, random() % 300);
    const ProductCode code = to_product_code(points);
    const auto decoded = from_product_code(code);
    ASSERT_TRUE(decoded.has_value()) << decoded.error().message;
    ASSERT_EQ(*decoded, points);
    for (const std::int64_t suffix : code.suffix) ASSERT_LT(suffix, std::int64_t{1} << 54);
  }
  const std::int32_t top = kMaxComponent;
  const std::vector<LatticePoint> corners = {{top, top, top}, {-top, -top, -top}, {-top, 0, 0},
                                             {0, top, -top},  {0, 0, top},        {top, 0, 1}};
  EXPECT_EQ(*from_product_code(to_product_code(corners)), corners);
}

void expect_corrupt(const ProductCode& code, std::size_t where) {
  const auto decoded = from_product_code(code);
  ASSERT_FALSE(decoded.has_value());
  EXPECT_EQ(decoded.error().code, ErrorCode::kCorruptStream);
  EXPECT_EQ(decoded.error().where, where);
}

TEST(ProductCode, RejectsImpossibleCodes) {
  constexpr std::int64_t kTop = kMaxComponent;
  expect_corrupt({{0, 1}, {}}, 1);      // suffix missing
  expect_corrupt({{0, 1}, {0, 0}}, 2);  // suffix left over
  expect_corrupt({{0}, {0}}, 1);        // null vectors have none
  expect_corrupt({{}, {1}}, 0);
  expect_corrupt({{3, -2}, {0, 1}}, 1);  // a negative norm
  expect_corrupt({{3}, {-1}}, 0);        // a negative suffix
  expect_corrupt({{3}, {37}}, 0);        // 36 ranks on shell 3
  expect_corrupt({{kTop + 1}, {0}}, 0);  // normal component
  expect_corrupt({{-kTop - 1}, {0}}, 0);
  expect_corrupt({{kTop + 1}, {4 * (kTop + 1) * kTop + 1}}, 0);  // (0, kTop + 1, 0)
  expect_corrupt({{3 * kTop + 1}, {1}}, 0);
  expect_corrupt({{INT64_MAX}, {1}}, 0);
  expect_corrupt({{INT64_MIN}, {1}}, 0);
  expect_corrupt({{INT64_MIN}, {0}}, 0);
  expect_corrupt({{kTop}, {INT64_MAX}}, 0);
  expect_corrupt({{kTop}, {INT64_MIN}}, 0);
  EXPECT_TRUE(from_product_code({{kTop + 1}, {1}}).has_value());  // (kTop, 1, 0)
  EXPECT_TRUE(from_product_code({{3}, {36}}).has_value());
  EXPECT_TRUE(from_product_code({}).has_value());
}

TEST(ProductCode, AcceptsOnlyWhatTheEncoderGives) {
  std::mt19937_64 random(33);
  int accepted = 0;
  for (int i = 0; i < 20000; ++i) {
    ProductCode code;
    const std::size_t count = random() % 5;
    for (std::size_t k = 0; k < count; ++k) code.prefix.push_back(symmetric_below(random, 3));
    const std::size_t suffixes = random() % (count + 1);
    for (std::size_t k = 0; k < suffixes; ++k) code.suffix.push_back(symmetric_below(random, 20));
    const auto points = from_product_code(code);
    if (!points) continue;
    ++accepted;
    const ProductCode again = to_product_code(*points);
    ASSERT_EQ(again.prefix, code.prefix);
    ASSERT_EQ(again.suffix, code.suffix);
  }
  EXPECT_GT(accepted, 1000);
}

}  // namespace
}  // namespace nacre::quant
