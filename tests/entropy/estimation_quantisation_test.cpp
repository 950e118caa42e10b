// SPDX-License-Identifier: GPL-3.0-or-later
#include "entropy/estimation_quantisation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "support/random.h"
#include "support/shapes.h"

namespace nacre::entropy {
namespace {

using Bytes = std::vector<std::uint8_t>;

const Topology& topology() {
  static const Topology built =
      *Topology::build(shapes::torus(6, 5).triangles,
                       static_cast<std::uint32_t>(shapes::torus(6, 5).positions.size()), 4);
  return built;
}

EqPlace place_of(int j) {
  return {&topology().level(j), j > 0 ? &topology().level(j - 1) : nullptr, j};
}

/// A model that stands before band j.
EqModel model_before(int j) {
  EqModel model;
  for (int k = 0; k < j; ++k) model.begin_band(place_of(k));
  return model;
}

std::vector<EqPoint> random_points(std::size_t count, std::uint32_t density, std::uint32_t largest,
                                   TestRandom& random) {
  std::vector<EqPoint> points(count, EqPoint{0, 0, 0});
  for (EqPoint& point : points)
    for (std::int32_t& v : point) {
      if (random.below(256) >= density) continue;
      const auto magnitude = static_cast<std::int32_t>(random.below(largest)) + 1;
      v = random.below(2) != 0 ? -magnitude : magnitude;
    }
  return points;
}

Bytes encode(EqModel& model, const EqPlace& place, const std::vector<EqPoint>& points,
             std::uint64_t* cost = nullptr) {
  EqEncoder encoder(model, place);
  for (std::size_t c = 0; c < 3; ++c)
    for (std::uint32_t e = 0; e < points.size(); ++e) {
      auto& statistics = encoder.look(e, c);
      if (cost != nullptr) *cost += EqEncoder::cost(statistics, points[e][c]);
      encoder.put(statistics, e, c, points[e][c]);
    }
  return encoder.finish({-8, 3, 7});
}

TEST(EstimationQuantisation, BandsComeBack) {
  TestRandom random(1);
  EqModel writing, reading;
  const std::array<std::pair<std::uint32_t, std::uint32_t>, 4> kinds = {
      {{255, kMaxEqMagnitude}, {128, 40}, {20, 3}, {2, 1}}};
  for (int j = 0; j < 4; ++j) {
    const auto [density, largest] = kinds[static_cast<std::size_t>(j)];
    const auto points = random_points(topology().level(j).edges.size(), density, largest, random);
    const Bytes payload = encode(writing, place_of(j), points);
    const auto band = decode_eq_band(payload, place_of(j), reading);
    ASSERT_TRUE(band.has_value()) << band.error().message;
    EXPECT_EQ(band->points, points) << j;
    EXPECT_EQ(band->shrink_32nds, (std::array<int, 3>{-8, 3, 7}));
  }
}

TEST(EstimationQuantisation, AnEmptyPayloadIsABandOfZeros) {
  TestRandom random(2);
  EqModel writing, reading;
  const auto coarse = random_points(topology().level(0).edges.size(), 200, 9, random);
  ASSERT_TRUE(decode_eq_band(encode(writing, place_of(0), coarse), place_of(0), reading));
  writing.begin_band(place_of(1));
  const auto zeros = decode_eq_band({}, place_of(1), reading);
  ASSERT_TRUE(zeros.has_value());
  for (const EqPoint& p : zeros->points) ASSERT_EQ(p, (EqPoint{0, 0, 0}));
  const auto fine = random_points(topology().level(2).edges.size(), 50, 9, random);
  const auto band = decode_eq_band(encode(writing, place_of(2), fine), place_of(2), reading);
  ASSERT_TRUE(band.has_value()) << band.error().message;
  EXPECT_EQ(band->points, fine);
}

TEST(EstimationQuantisation, CostsAreWhatIsWritten) {
  TestRandom random(3);
  EqModel model = model_before(3);
  const auto points = random_points(topology().level(3).edges.size(), 100, 12, random);
  std::uint64_t cost = 0;
  const Bytes payload = encode(model, place_of(3), points, &cost);
  EXPECT_NEAR(static_cast<double>(cost) / 4096 / 8, static_cast<double>(payload.size()),
              0.01 * static_cast<double>(payload.size()) + 4);
}

/// The point of the method: where large ones lie together, each one's scale is known beforehand.
TEST(EstimationQuantisation, ClusteredMagnitudesCostLess) {
  TestRandom random(4);
  const std::size_t count = topology().level(3).edges.size();
  std::vector<EqPoint> clustered(count, EqPoint{0, 0, 0});
  // Inner edges of every fourth base triangle.
  const std::size_t inner = 2 * topology().level(2).edges.size();
  for (std::size_t e = inner; e < count; ++e)
    if ((e - inner) / 48 % 4 == 0)
      clustered[e][0] = static_cast<std::int32_t>(random.below(31)) - 15;
  std::vector<EqPoint> shuffled = clustered;
  for (std::size_t i = count - 1; i > 0; --i) std::swap(shuffled[i], shuffled[random.below(i + 1)]);
  EqModel a = model_before(3), b = model_before(3);
  const auto together = encode(a, place_of(3), clustered).size();
  EXPECT_LT(static_cast<double>(together),
            0.85 * static_cast<double>(encode(b, place_of(3), shuffled).size()));
}

TEST(EstimationQuantisationHostile, EveryTruncationAndExtensionIsCorrupt) {
  TestRandom random(5);
  EqModel model = model_before(1);
  Bytes payload =
      encode(model, place_of(1), random_points(topology().level(1).edges.size(), 99, 9, random));
  const auto decodes = [](std::span<const std::uint8_t> bytes) {
    EqModel fresh = model_before(1);
    return decode_eq_band(bytes, place_of(1), fresh).has_value();
  };
  for (std::size_t size = 1; size < payload.size(); ++size)
    ASSERT_FALSE(decodes(std::span(payload).first(size))) << size;
  payload.push_back(0);
  EXPECT_FALSE(decodes(payload));
}

TEST(EstimationQuantisationHostile, RandomBytesAreHarmless) {
  TestRandom random(6);
  for (int round = 0; round < 3000; ++round) {
    Bytes bytes(random.below(120) + 1);
    for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(random.below(256));
    EqModel model;
    const auto band = decode_eq_band(bytes, place_of(0), model);
    if (!band) {
      EXPECT_EQ(band.error().code, ErrorCode::kCorruptStream);
    }
  }
}

}  // namespace
}  // namespace nacre::entropy
