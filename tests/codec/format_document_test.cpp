// SPDX-License-Identifier: GPL-3.0-or-later
//
// The worked examples of docs/FORMAT.md are what this build makes and reads.
#include <gtest/gtest.h>

#include <cmath>

#include "codec/codec.h"
#include "codec/edit_stream.h"
#include "format_examples.h"
#include "synthetic.h"

namespace nacre::codec {
namespace {

/// The document's example: a tetrahedron split once, its midpoints pushed outward, each a little
/// further than the one before, and the first aside as well.
SemiRegularMesh pushed_tetrahedron() {
  const Scan base = shapes::tetrahedron();
  SemiRegularMesh mesh{base.triangles, 4, 1, base.positions, Vec3::Zero()};
  const Topology topology = *Topology::build(mesh.base_triangles, 4, 1);
  for (const Edge& e : topology.level(0).edges) {
    const Vec3 middle = 0.5 * (base.positions[e.vertex[0]] + base.positions[e.vertex[1]]);
    const auto i = static_cast<double>(mesh.positions.size() - 4);
    mesh.positions.push_back((1.25 + 0.0625 * i) * middle + Vec3(0, i == 0 ? 0.25 : 0, 0));
  }
  return mesh;
}

std::string hex(const std::vector<std::uint8_t>& bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    constexpr char kDigits[] = "0123456789ABCDEF";
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
    text += ' ';
  }
  return text;
}

TEST(FormatDocument, ExampleIsWhatTheEncoderMakes) {
  const auto streams = format_examples::streams();
  const auto encoded = encode(pushed_tetrahedron(), {.target_bytes = 52, .base_bits = 6});
  ASSERT_TRUE(encoded.has_value()) << encoded.error().message;
  ASSERT_EQ(streams.size(), 1u) << hex(encoded->bytes);
  EXPECT_EQ(hex(streams[0]), hex(encoded->bytes));
}

TEST(FormatDocument, ExampleDecodesToThePositionsGiven) {
  const auto streams = format_examples::streams();
  ASSERT_EQ(streams.size(), 1u);
  const auto mesh = decode(streams[0]);
  ASSERT_TRUE(mesh.has_value()) << mesh.error().message;
  const auto expected = format_examples::positions();
  ASSERT_EQ(mesh->positions.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(mesh->positions[i], Vec3(expected[i][0], expected[i][1], expected[i][2]))
        << std::hexfloat << mesh->positions[i].transpose();
  }
}

// The header of the example with a table of levels 0 and 1 and a certified error.
TEST(FormatDocument, ExampleOfALevelTableIsWhatIsWritten) {
  const auto streams = format_examples::streams();
  const auto headers = format_examples::streams("table");
  const LevelTable table = {std::sqrt(12.0), {{21.37, 0.25}, {38.5, 0.0301}}};
  const auto with_table = with_quality(streams.at(0), table, 0.0301);
  ASSERT_TRUE(with_table.has_value()) << with_table.error().message;
  const StreamInfo info = *inspect(*with_table);
  std::vector<std::uint8_t> header = *with_table;
  header.resize(info.bytes_header);
  ASSERT_EQ(headers.size(), 1u) << hex(header);
  EXPECT_EQ(hex(headers[0]), hex(header));
}

}  // namespace
}  // namespace nacre::codec
