// SPDX-License-Identifier: GPL-3.0-or-later
#include "entropy/detail_coder.h"

#include <gtest/gtest.h>

#include <cmath>

#include "entropy/binary_model.h"
#include "support/shapes.h"

namespace nacre::entropy {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// A small generator whose sequence is the same everywhere.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(2 * seed + 1) {}
  std::uint32_t below(std::uint32_t n) {
    state_ = state_ * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<std::uint32_t>(((state_ >> 33) * n) >> 31);
  }

 private:
  std::uint64_t state_;
};

Topology topology_of(const Scan& scan, int levels) {
  return *Topology::build(scan.triangles, static_cast<std::uint32_t>(scan.positions.size()),
                          levels);
}

BandPlace place_of(const Topology& topology, int j, int excess = 10) {
  return {&topology.level(j), j > 0 ? &topology.level(j - 1) : nullptr, j, j > 0 ? excess : 0};
}

/// Details of one band: `density` of 256 are not zero, magnitudes up to `largest`.
std::vector<DetailPoint> random_points(std::size_t count, std::uint32_t density, int largest,
                                       bool tangential, Random& random) {
  std::vector<DetailPoint> points(count, DetailPoint{0, 0, 0});
  for (DetailPoint& point : points) {
    for (std::size_t k = 0; k < (tangential ? 3u : 1u); ++k) {
      if (random.below(256) >= density) continue;
      const auto magnitude =
          static_cast<int>(random.below(static_cast<std::uint32_t>(largest))) + 1;
      point[k] = random.below(2) != 0 ? -magnitude : magnitude;
    }
  }
  return points;
}

/// Opens what the block's details need.
void begin_block(DetailEncoder& encoder, const std::vector<DetailPoint>& points,
                 std::uint32_t first) {
  const std::uint64_t active = encoder.active(first / kBlockDetails);
  bool rises = false, tangential = false;
  for (std::uint32_t e = first; e < std::min<std::size_t>(first + kBlockDetails, points.size());
       ++e) {
    rises |= points[e][0] != 0 && (active >> (e - first) & 1) == 0;
    tangential |= points[e][1] != 0 || points[e][2] != 0;
  }
  encoder.begin_block(first / kBlockDetails, rises, tangential);
}

std::vector<DetailPoint> dense(const DetailBand& band, std::size_t count) {
  std::vector<DetailPoint> points(count, DetailPoint{0, 0, 0});
  for (const DetailBand::Nonzero& n : band.points) points[n.edge] = n.point;
  return points;
}

Bytes encode_band(DetailModel& model, const BandPlace& place,
                  const std::vector<DetailPoint>& points, bool tangential,
                  std::uint64_t* cost = nullptr) {
  DetailEncoder encoder(model, place, tangential, 4);
  for (std::uint32_t e = 0; e < points.size(); ++e) {
    if (e % kBlockDetails == 0) begin_block(encoder, points, e);
    const DetailContext context = encoder.look(e);
    if (!encoder.is_open(context)) continue;
    if (cost != nullptr) {
      if (encoder.normal_is_open(context)) *cost += encoder.normal_cost(context, points[e][0]);
      *cost += encoder.tangential_cost(context, points[e]);
    }
    encoder.put(context, points[e]);
  }
  return encoder.finish({-8, 0, 7});
}

TEST(BinaryModel, SquashAndStretchAreInverse) {
  for (std::int32_t x = -kMaxStretched; x <= kMaxStretched; ++x) {
    const double exact = 65536 / (1 + std::exp(-x / 256.0));
    EXPECT_NEAR(squash(x), exact, 1.01) << x;
  }
  for (std::uint32_t p = 64; p < 65472; ++p) {
    const double exact = 256 * std::log(p / (65536.0 - p));
    EXPECT_NEAR(stretch(p), exact, 33) << p;
  }
  for (std::uint32_t p = 256; p < 65536; ++p)
    EXPECT_NEAR(bit_cost(p) / 4096.0, 16 - std::log2(p), 0.05) << p;
}

TEST(BinaryModel, CounterFindsTheMean) {
  BitCounter counter;
  Random random(1);
  for (int i = 0; i < 5000; ++i) counter.update(random.below(8) == 0);
  EXPECT_NEAR(counter.probability() / 65536.0, 0.125, 0.05);
  for (int i = 0; i < 100000; ++i) counter.update(true);
  for (int i = 0; i < 100000; ++i) counter.update(false);
  EXPECT_LE(counter.probability(), 1u);
}

TEST(BinaryModel, MixerTrustsTheContextThatKnows) {
  std::vector<BitCounter> knows(2), blind(1);
  MixerWeights weights;
  Random random(2);
  double cost = 0;
  for (int i = 0; i < 4000; ++i) {
    const bool hint = random.below(2) != 0, value = random.below(10) == 0 ? !hint : hint;
    MixedBit<2> bit(weights, {&blind[0], &knows[hint ? 1 : 0]});
    if (i >= 1000) cost += bit.cost(value) / 4096.0 / 3000;
    bit.update(value);
  }
  EXPECT_LT(cost, 0.52);  // the entropy is 0.469
}

TEST(DetailCoder, ClassesCoverTheMagnitudes) {
  for (int c = 0; c < kMagnitudeClasses; ++c) {
    const std::int32_t least = least_of_class(c);
    EXPECT_EQ(magnitude_class(least), c);
    EXPECT_EQ(magnitude_class(least + (1 << raw_bits_of_class(c)) - 1), c);
  }
  EXPECT_EQ(least_of_class(0), 1);
  EXPECT_EQ(magnitude_class(kMaxDetail), kMagnitudeClasses - 1);
}

TEST(DetailCoder, RoundTripsBandByBand) {
  for (const Scan& scan : {shapes::icosahedron(), shapes::grid(3, 4), shapes::torus(4, 5)}) {
    const Topology topology = topology_of(scan, 4);
    for (const bool tangential : {false, true}) {
      Random random(7);
      DetailModel writer, reader;
      for (int j = 0; j < 4; ++j) {
        const BandPlace place = place_of(topology, j);
        const auto points = random_points(topology.band_size(j), j == 2 ? 0 : 160 >> (2 * j),
                                          j == 0 ? kMaxDetail : 9, tangential, random);
        const bool is_empty = j == 2;
        Bytes payload;
        if (is_empty) {
          writer.skip_band(place);
        } else {
          payload = encode_band(writer, place, points, tangential);
        }
        const auto band = decode_details(payload, place, reader);
        ASSERT_TRUE(band.has_value()) << band.error().message;
        EXPECT_EQ(dense(*band, points.size()), points);
        EXPECT_EQ(band->shrink_32nds, (is_empty ? std::array{0, 0, 0} : std::array{-8, 0, 7}));
        EXPECT_EQ(band->ratio_quarters, tangential && !is_empty ? 4 : 0);
      }
    }
  }
}

TEST(DetailCoder, CostsAreWhatIsWritten) {
  const Topology topology = topology_of(shapes::icosahedron(), 4);
  Random random(3);
  DetailModel model;
  for (int j = 0; j < 4; ++j) {
    const auto points = random_points(topology.band_size(j), 120, 12, true, random);
    std::uint64_t cost = 0;
    const Bytes payload = encode_band(model, place_of(topology, j), points, true, &cost);
    EXPECT_NEAR(static_cast<double>(cost) / 4096 / 8, static_cast<double>(payload.size()),
                4 + 0.01 * static_cast<double>(payload.size()));
  }
}

TEST(DetailCoder, ZerosAreNearlyFree) {
  const Topology topology = topology_of(shapes::icosahedron(), 6);
  DetailModel model;
  std::size_t bytes = 0, details = 0;
  for (int j = 0; j < 6; ++j) {
    std::vector<DetailPoint> points(topology.band_size(j), DetailPoint{0, 0, 0});
    points[points.size() / 2][0] = 1;
    bytes += encode_band(model, place_of(topology, j), points, false).size();
    details += points.size();
  }
  EXPECT_GT(details, 40000u);
  EXPECT_LT(bytes, 70u);
}

TEST(DetailCoder, NeighboursHelp) {
  // Magnitudes that are large in one part of the mesh: far below the entropy of one distribution.
  const Topology topology = topology_of(shapes::icosahedron(), 4);
  DetailModel model;
  Random random(5);
  std::size_t bytes = 0;
  double ones = 0, count = 0;
  for (int j = 0; j < 4; ++j) {
    std::vector<DetailPoint> points(topology.band_size(j), DetailPoint{0, 0, 0});
    for (std::uint32_t e = 0; e < points.size(); ++e) {
      std::uint32_t face = topology.level(j).edges[e].face[0] >> (2 * j);
      if (face < 5 && random.below(2) != 0) points[e][0] = random.below(2) != 0 ? 1 : -1;
      ones += points[e][0] != 0 ? 1 : 0;
      count += 1;
    }
    bytes += encode_band(model, place_of(topology, j), points, false).size();
  }
  const double p = ones / count;
  const double alone = -count * (p * std::log2(p) + (1 - p) * std::log2(1 - p)) + ones;
  EXPECT_LT(8.0 * static_cast<double>(bytes), 0.93 * alone);
}

TEST(DetailCoder, RejectsEveryTruncationAndExtension) {
  const Topology topology = topology_of(shapes::grid(3, 3), 2);
  Random random(9);
  const auto points = random_points(topology.band_size(0), 128, 6, true, random);
  DetailModel model;
  const Bytes payload = encode_band(model, place_of(topology, 0), points, true);
  for (std::size_t size = 1; size < payload.size(); ++size) {
    const Bytes cut(payload.data(), payload.data() + size);
    DetailModel reader;
    const auto band = decode_details(cut, place_of(topology, 0), reader);
    ASSERT_FALSE(band.has_value()) << size;
    EXPECT_EQ(band.error().code, ErrorCode::kCorruptStream);
  }
  Bytes longer = payload;
  longer.push_back(0);
  DetailModel reader;
  EXPECT_FALSE(decode_details(longer, place_of(topology, 0), reader).has_value());
}

TEST(DetailCoder, AnyBytesEnd) {
  const Topology topology = topology_of(shapes::grid(3, 3), 3);
  Random random(13);
  for (int round = 0; round < 3000; ++round) {
    Bytes bytes(1 + random.below(40));
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random.below(256));
    DetailModel model;
    for (int j = 0; j < 3; ++j) {
      const auto band = decode_details(bytes, place_of(topology, j, 300), model);
      if (!band) break;
      // What is accepted is what an encoder writes for it.
      for (const DetailBand::Nonzero& n : band->points)
        for (const std::int32_t v : n.point) EXPECT_LE(std::abs(v), kMaxDetail);
    }
  }
}

}  // namespace
}  // namespace nacre::entropy
