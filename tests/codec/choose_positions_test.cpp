// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/choose_positions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "entropy/plane_positions_decode.h"
#include "tests/codec/synthetic.h"

namespace nacre::codec {
namespace {

constexpr int kSide = 21, kBits = 12;
constexpr double kSpacing = 150, kMiddle = 20 + kSpacing * (kSide - 1) / 2;

/// A roof over a square, its ridge along y; vertices at random in its two flats, but for those of
/// the ridge and of the border.
struct Roof {
  Roof() {
    synthetic::Random random(5);
    const auto triangles = shapes::grid(kSide - 1, kSide - 1).triangles;
    auto encoded = *entropy::encode_connectivity(triangles, kSide * kSide);
    connectivity = encoded.decoded;
    std::vector<Vec3> all;
    for (int x = 0; x < kSide; ++x) {
      for (int y = 0; y < kSide; ++y) {
        const auto place = [&](int i, bool is_kept) {
          const double jitter = random.uniform() - 0.5;
          return 20 + kSpacing * i + (is_kept ? 0 : 60 * jitter);
        };
        const double px = place(x, x == 0 || x == kSide - 1 || x == kSide / 2);
        const double py = place(y, y == 0 || y == kSide - 1);
        all.emplace_back(px, py, height(px));
      }
    }
    for (const std::uint32_t v : encoded.vertex_order) positions.push_back(all[v]);
  }
  static double height(double x) { return 100.37 + 0.3 * std::abs(x - kMiddle); }

  entropy::Connectivity connectivity;
  std::vector<Vec3> positions;
};

TEST(ChoosePositions, DecodesToWhatWasChosen) {
  const Roof roof;
  for (const double bit_price : {0.0, 0.1, 10.0}) {
    const auto chosen = choose_positions(roof.positions, roof.connectivity, kBits, bit_price);
    const auto decoded =
        entropy::decode_positions_by_planes(chosen.payload, roof.connectivity, kBits);
    ASSERT_TRUE(decoded.has_value());
    EXPECT_EQ(*decoded, chosen.grid);
  }
}

// What a vertex may lose is what its bits are worth, at most 40 of them, and rounding's own 3/4.
// A plane of the ridge has a quarter of its vertices' weight, a flat's half; two edges of the
// border have 8 / 3 / kSpacing.
TEST(ChoosePositions, SlidesInFlatsAndAlongCreasesOnly) {
  const Roof roof;
  constexpr double kPrice = 0.02, kLoss = 40 * kPrice + 0.75;
  const double most = std::sqrt(4 * kLoss), most_at_border = std::sqrt(kLoss * kSpacing * 3 / 8);
  const auto chosen = choose_positions(roof.positions, roof.connectivity, kBits, kPrice);
  double slide = 0;
  for (std::size_t v = 0; v < chosen.grid.size(); ++v) {
    const Vec3& p = roof.positions[v];
    const Vec3 q(chosen.grid[v][0], chosen.grid[v][1], chosen.grid[v][2]);
    for (const double side : {-1.0, 1.0}) {
      if (side * (p[0] - kMiddle) < 0) continue;  // both hold the ridge
      const double off = q[2] - 100.37 - 0.3 * side * (q[0] - kMiddle);
      EXPECT_LT(std::abs(off) / std::sqrt(1.09), most);
    }
    for (const double line : {20.0, 20 + kSpacing * (kSide - 1)}) {
      for (int k = 0; k < 2; ++k)
        EXPECT_LT(p[k] == line ? std::abs(q[k] - line) : 0, most_at_border);
    }
    slide = std::max(slide, (q - p).norm());
  }
  EXPECT_GT(slide, 5);  // steps: they are free, and use it
}

TEST(ChoosePositions, CostsFarLessThanRounding) {
  const Roof roof;
  const auto chosen = choose_positions(roof.positions, roof.connectivity, kBits, 0.1);
  const CodedBase rounded = encode_base(roof.positions, roof.connectivity, 0);
  EXPECT_LT(static_cast<double>(chosen.payload.size()),
            0.7 * static_cast<double>(rounded.payload.size()));
}

TEST(ChoosePositions, TurnsNoTriangleOver) {
  const Roof roof;
  const auto chosen = choose_positions(roof.positions, roof.connectivity, kBits, 10);
  for (const Triangle& t : roof.connectivity.triangles) {
    const auto point = [&](std::size_t k) {
      const auto& g = chosen.grid[t[k]];
      return Vec3(g[0], g[1], g[2]);
    };
    EXPECT_GT(cross(point(1) - point(0), point(2) - point(0))[2], 0);
  }
}

TEST(ChoosePositions, AStepIsTheGridOfRounding) {
  const Roof roof;
  const int step_index = 64;  // 4 units
  const CodedBase rounded = encode_base(roof.positions, roof.connectivity, step_index);
  const CodedBase chosen =
      encode_base_by_planes(roof.positions, roof.connectivity, step_index, 0.1);
  EXPECT_EQ(chosen.grid_bits, rounded.grid_bits);
  EXPECT_EQ(chosen.corner, rounded.corner);
  EXPECT_EQ(chosen.distortion, mean_squared_difference(roof.positions, chosen.decoded));
}

// One triangle twice, of no area, and all in one place: nothing to go by, and nothing to fear.
TEST(ChoosePositions, TakesMeshesWithoutArea) {
  const std::vector<Triangle> triangles = {{0, 1, 2}, {0, 2, 1}};
  const auto encoded = entropy::encode_connectivity(triangles, 3);
  ASSERT_TRUE(encoded.has_value());
  for (const double x : {0.0, 100.0}) {
    const std::vector<Vec3> positions = {{0, 0, 0}, {x, 0, 0}, {x / 2, 0, 0}};
    const auto chosen = choose_positions(positions, encoded->decoded, 8, 0.1);
    const auto decoded = entropy::decode_positions_by_planes(chosen.payload, encoded->decoded, 8);
    ASSERT_TRUE(decoded.has_value());
    EXPECT_EQ(*decoded, chosen.grid);
  }
}

}  // namespace
}  // namespace nacre::codec
