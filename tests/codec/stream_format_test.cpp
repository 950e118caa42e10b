// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/stream_format.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string_view>

#include "codec/byte_reader.h"
#include "codec/byte_writer.h"

namespace nacre::codec {
namespace {

std::span<const std::uint8_t> as_bytes(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

TEST(StreamFormat, StepsArePowersOfTwoToTheBit) {
  EXPECT_EQ(step_size(0), 1.0);
  EXPECT_EQ(step_size(32), 2.0);
  EXPECT_EQ(step_size(-kMaxStepIndex), 0x1p-200);
  EXPECT_EQ(step_size(kMaxStepIndex), 0x1p200);
  EXPECT_EQ(step_size(16), std::sqrt(2.0));
  for (int index = -kMaxStepIndex; index + 32 <= kMaxStepIndex; ++index) {
    ASSERT_EQ(step_size(index + 32), 2 * step_size(index)) << index;
    ASSERT_LT(step_size(index), step_size(index + 1)) << index;
  }
  for (int index = 0; index < 32; ++index) {
    // The 32-bit mantissa product of long doubles decides what the nearest double is.
    const auto nearest = static_cast<double>(std::pow(2.0L, index / 32.0L));
    EXPECT_EQ(step_size(index), nearest) << index;
  }
}

TEST(StreamFormat, ChecksumsGiveTheCatalogueValues) {
  EXPECT_EQ(crc16(as_bytes("123456789")), 0x29B1);
  EXPECT_EQ(crc32c(as_bytes("123456789")), 0xE3069283u);
}

TEST(StreamFormat, ZigzagIsABijectionInOrderOfMagnitude) {
  EXPECT_EQ(zigzag(0), 0u);
  EXPECT_EQ(zigzag(-1), 1u);
  EXPECT_EQ(zigzag(1), 2u);
  for (const std::int64_t v : {std::int64_t{0}, std::int64_t{-5}, kMaxGridCorner, -kMaxGridCorner})
    EXPECT_EQ(unzigzag(zigzag(v)), v);
}

TEST(StreamFormat, VarintsRoundTripAndHaveOneForm) {
  for (const std::uint64_t v : {0ull, 1ull, 127ull, 128ull, 16383ull, 16384ull, (1ull << 62) + 5}) {
    ByteWriter writer;
    writer.varint(v);
    ByteReader reader(writer.bytes());
    EXPECT_EQ(reader.varint(), v);
    EXPECT_FALSE(reader.failed());
    EXPECT_EQ(reader.position(), writer.bytes().size());
  }
  for (const std::vector<std::uint8_t>& bad :
       {std::vector<std::uint8_t>{0x80, 0x00}, {0xFF}, std::vector<std::uint8_t>(10, 0xFF)}) {
    ByteReader reader(bad);
    EXPECT_EQ(reader.varint(), 0u);
    EXPECT_TRUE(reader.failed());
  }
}

TEST(StreamFormat, LevelCountsOfATetrahedron) {
  Header header;
  header.base_vertices = 4;
  header.base_triangles = 4;
  header.levels = 2;
  const auto counts = level_counts(header);
  ASSERT_EQ(counts.size(), 3u);
  EXPECT_EQ(counts[0].edges, 6u);
  EXPECT_EQ(counts[1].vertices, 10u);
  EXPECT_EQ(counts[1].edges, 24u);
  EXPECT_EQ(counts[2].vertices, 34u);
  EXPECT_EQ(counts[2].triangles, 64u);
}

}  // namespace
}  // namespace nacre::codec
