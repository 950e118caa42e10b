// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/npy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "app/sha256.h"

namespace nacre::app::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// A file by hand, as numpy 1.24 writes it.
Bytes file(const std::string& header, const Bytes& data) {
  std::string padded = header;
  while ((10 + padded.size() + 1) % 64 != 0) padded += ' ';
  padded += '\n';
  Bytes out = {0x93, 'N', 'U', 'M', 'P', 'Y', 1, 0};
  out.push_back(static_cast<std::uint8_t>(padded.size()));
  out.push_back(static_cast<std::uint8_t>(padded.size() >> 8));
  out.insert(out.end(), padded.begin(), padded.end());
  out.insert(out.end(), data.begin(), data.end());
  return out;
}

TEST(Npy, WritesWhatNumpyWrites) {
  const std::vector<std::uint8_t> numbers = {7, 8, 9};
  EXPECT_EQ(to_npy(std::span<const std::uint8_t>(numbers)),
            file("{'descr': '|u1', 'fortran_order': False, 'shape': (3,), }", {7, 8, 9}));
  const std::vector<Triangle> triangles = {{1, 2, 256}};
  EXPECT_EQ(to_npy(std::span<const Triangle>(triangles)),
            file("{'descr': '<u4', 'fortran_order': False, 'shape': (1, 3), }",
                 {1, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0, 0}));
}

TEST(Npy, ReadsBackToTheBit) {
  const std::vector<Vec3> points = {{0.1, -2e300, 5e-324}, {1 / 3.0, -0.0, 7}};
  const auto back = from_npy<Vec3>(to_npy(std::span<const Vec3>(points)));
  ASSERT_TRUE(back.has_value()) << back.error().message;
  EXPECT_EQ(*back, points);
  EXPECT_TRUE(std::signbit((*back)[1][1]));
  const auto none = from_npy<double>(to_npy(std::span<const double>()));
  ASSERT_TRUE(none.has_value());
  EXPECT_TRUE(none->empty());
}

TEST(Npy, SaysWhatItExpected) {
  const std::vector<double> numbers = {1, 2, 3};
  const auto read = from_npy<Vec3>(to_npy(std::span<const double>(numbers)));
  ASSERT_FALSE(read.has_value());
  EXPECT_EQ(read.error().code, ErrorCode::kUnreadableFile);
  EXPECT_EQ(read.error().message, "holds (3,) of <f8; expected (n, 3) of <f8");
  EXPECT_FALSE(
      from_npy<double>(file("{'descr': '<f8', 'fortran_order': True, 'shape': (0,), }", {}))
          .has_value());
  EXPECT_FALSE(
      from_npy<double>(file("{'descr': '>f8', 'fortran_order': False, 'shape': (0,), }", {}))
          .has_value());
}

TEST(Npy, RejectsEveryTruncation) {
  const std::vector<Vec3> points = {{1, 2, 3}, {4, 5, 6}};
  const Bytes whole = to_npy(std::span<const Vec3>(points));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    ASSERT_FALSE(from_npy<Vec3>(cut).has_value()) << size;
  }
  Bytes longer = whole;
  longer.push_back(0);
  EXPECT_FALSE(from_npy<Vec3>(longer).has_value());
}

TEST(Npy, RejectsHostileShapes) {
  for (const char* shape :
       {"(18446744073709551615, 3)", "(6148914691236517206, 3)", "(1, 18446744073709551615)",
        "(1, 2, 3)", "()", "(", "(1", "(-1,)", "(1, 0)", "(99999999999999999999999,)"}) {
    const Bytes hostile =
        file(std::string("{'descr': '<f8', 'fortran_order': False, 'shape': ") + shape + ", }",
             Bytes(24));
    EXPECT_FALSE(read_npy(hostile).has_value()) << shape;
  }
}

TEST(Sha256, AgreesWithTheStandard) {  // FIPS 180-4 and its examples
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256(std::string(1'000'000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

}  // namespace
}  // namespace nacre::app::test
