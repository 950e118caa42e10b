// SPDX-License-Identifier: GPL-3.0-or-later
#include <bit>

#include "io/io_test_support.h"

namespace nacre::io {
namespace {

const std::string kVertices = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
const std::string kTriangles = "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
const std::string kXyz = "property float x\nproperty float y\nproperty float z\n";
const std::string kList = "property list uchar int vertex_indices\n";

std::string header(const std::string& format, const std::string& elements) {
  return "ply\nformat " + format + " 1.0\n" + elements + "end_header\n";
}

std::string ascii_tetrahedron() {
  return header("ascii", "element vertex 4\n" + kXyz + "element face 4\n" + kList) + kVertices +
         kTriangles;
}

std::string with(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
  return text;
}

template <class Coordinate, class Count, class Index>
std::string binary_tetrahedron(const std::string& coordinate, const std::string& count,
                               const std::string& index, bool big) {
  std::string text = header(big ? "binary_big_endian" : "binary_little_endian",
                            "element vertex 4\n" + with(kXyz, "float", coordinate) +
                                "property uchar flags\n" + "element face 4\nproperty list " +
                                count + " " + index + " vertex_index\nproperty double area\n");
  for (const Vec3& p : kCorners) {
    for (int k = 0; k < 3; ++k) append(text, static_cast<Coordinate>(p[k]), big);
    append(text, std::uint8_t{7});
  }
  for (const Triangle& t : kFaces) {
    append(text, static_cast<Count>(3), big);
    for (const std::uint32_t v : t) append(text, static_cast<Index>(v), big);
    append(text, 0.5, big);
  }
  return text;
}

TEST(ReadPly, AsciiWithEachLineEnd) {
  const std::string text = ascii_tetrahedron();
  expect_tetrahedron(read_as("a.ply", text));
  expect_tetrahedron(read_as("a.ply", with(text, "\n", "\r\n")));
  expect_tetrahedron(read_as("a.ply", with(text, "\n", "\r")));
  expect_tetrahedron(read_as("a.ply", with(text, "\n", " \t\n")));
  expect_tetrahedron(read_as("a.ply", text.substr(0, text.size() - 1)));
  expect_tetrahedron(read_as("a.ply", with(text, "0 0 0\n1", "0 0\n0 1")));  // lines mean nothing
  EXPECT_EQ((*read_as("a.ply", text)).report.format, "ply-ascii");
}

TEST(ReadPly, BinaryOfEveryTypeAndBothOrders) {
  for (const bool big : {false, true}) {
    expect_tetrahedron(read_as("a.ply", binary_tetrahedron<float, std::uint8_t, std::int32_t>(
                                            "float", "uchar", "int", big)));
    expect_tetrahedron(read_as("a.ply", binary_tetrahedron<double, std::int32_t, std::uint32_t>(
                                            "double", "int", "uint", big)));
    expect_tetrahedron(
        read_as("a.ply", binary_tetrahedron<std::int16_t, std::uint16_t, std::uint8_t>(
                             "short", "ushort", "uchar", big)));
    expect_tetrahedron(read_as("a.ply", binary_tetrahedron<std::int8_t, std::int8_t, std::int16_t>(
                                            "int8", "int8", "int16", big)));
    expect_tetrahedron(
        read_as("a.ply", binary_tetrahedron<std::uint32_t, std::uint32_t, std::int64_t>(
                             "uint32", "uint32", "int64", big)));
    expect_tetrahedron(read_as("a.ply", binary_tetrahedron<float, std::int16_t, float>(
                                            "float32", "int16", "float32", big)));
    const auto read = read_as("a.ply", binary_tetrahedron<float, std::uint8_t, std::int32_t>(
                                           "float", "uchar", "int", big));
    EXPECT_EQ((*read).report.format, big ? "ply-be" : "ply-le");
    EXPECT_EQ((*read).report.not_carried, (Names{"flags", "face area"}));
  }
}

TEST(ReadPly, BinaryBodyThatStartsWithALineEnd) {
  // Small denormals start with the bytes LF or CR.
  for (const std::uint32_t raw : {0x0Au, 0x0Du, 0x0A0Du, 0x0D0Au}) {
    for (const char* line_end : {"\n", "\r\n", "\r"}) {
      std::string text = with(
          header("binary_little_endian", "element vertex 3\n" + kXyz + "element face 1\n" + kList),
          "\n", line_end);
      for (int i = 0; i < 9; ++i) append(text, i == 0 ? raw : 0u);
      append(text, std::uint8_t{3});
      for (const std::int32_t v : {0, 1, 2}) append(text, v);
      const auto read = read_as("a.ply", text);
      ASSERT_TRUE(read.has_value()) << read.error().message;
      EXPECT_EQ((*read).scan.positions[0][0], std::bit_cast<float>(raw));
    }
  }
}

TEST(ReadPly, OddHeaders) {
  const std::string text = ascii_tetrahedron();
  expect_tetrahedron(
      read_as("a.ply", with(text, "format", "comment a b c\nobj_info num_cols 512\n\nformat")));
  expect_tetrahedron(read_as("a.ply", with(text, "property", "  property\t")));
  expect_tetrahedron(read_as("a.ply", with(text, "end_header", "comment end_header\nend_header ")));
  expect_tetrahedron(read_as("scan.txt", text));   // by content
  expect_tetrahedron(read_as("wrong.obj", text));  // content wins
  // Other elements around, lists anywhere, faces first.
  const std::string other = "element camera 2\nproperty float a\nproperty list int short b\n";
  const auto around = read_as(
      "a.ply", header("ascii", other + "element face 4\nproperty list uchar float uv\n" + kList +
                                   "element vertex 4\nproperty list uchar uchar tags\n" + kXyz +
                                   "element nothing 0\nproperty int a\nelement void 3\n") +
                   "0.5 3 1 2 3\n0.5 0\n" +
                   with(with(kTriangles, "3 0", "2 .5 .5 3 0"), "3 1", "0 3 1") +
                   "2 1 2 0 0 0\n0 1 0 0\n0 0 1 0\n1 9 0 0 1\n");
  expect_tetrahedron(around);
  EXPECT_EQ((*around).report.not_carried,
            (Names{"element camera", "face uv", "tags", "element void"}));
}

TEST(ReadPly, Strips) {
  const std::string head =
      header("ascii", "element vertex 4\n" + kXyz +
                          "element tristrips 1\nproperty list int int vertex_indices\n");
  const auto read = read_as("a.ply", head + kVertices + "9 0 1 2 3 -1 0 3 3 2\n");
  ASSERT_TRUE(read.has_value()) << read.error().message;
  // The second strip's repeated vertex makes no face, but counts for the winding.
  EXPECT_EQ((*read).scan.triangles, (std::vector<Triangle>{{0, 1, 2}, {2, 1, 3}}));
  const auto joined = read_as("a.ply", head + kVertices + "6 0 1 2 2 1 3\n");
  ASSERT_TRUE(joined.has_value());
  EXPECT_EQ((*joined).scan.triangles, (std::vector<Triangle>{{0, 1, 2}, {1, 2, 3}}));
}

TEST(ReadPly, PolygonsAndFacesTooSmall) {
  const auto read =
      read_as("a.ply", header("ascii", "element vertex 4\n" + kXyz + "element face 4\n" + kList) +
                           "0 0 0\n2 0 0\n2 1 0\n0 1 0\n" + "2 0 1\n4 0 1 2 3\n0\n3 0 1 2\n");
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_EQ((*read).scan.triangles, (std::vector<Triangle>{{3, 0, 1}, {1, 2, 3}, {0, 1, 2}}));
  EXPECT_EQ((*read).report.polygons_triangulated, 1u);
  EXPECT_EQ((*read).report.faces_skipped, 2u);
}

TEST(ReadPly, NumbersInEveryShape) {
  const std::string head = header(
      "ascii", "element vertex 3\n" + with(kXyz, "float", "double") + "element face 1\n" + kList);
  const auto read = read_as(
      "a.ply", head + "+1.5 -2e3 .25\n1e-400 -0 5.\n0.1 1E+2 123456789.123456789\n3 0 1 2\n");
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_EQ((*read).scan.positions,
            (std::vector<Vec3>{{1.5, -2000, 0.25}, {0, -0.0, 5}, {0.1, 100, 123456789.123456789}}));
  for (const char* bad : {"1,5", "1.5f", "--1", "+-1", "nan", "inf", "-inf", "-1.#IND", "1e400",
                          "0x10", "1e31", "1e99999999999999999999", "e5"}) {
    expect_unreadable(read_as("a.ply", head + "0 0 0\n1 " + bad + " 0\n0 1 0\n3 0 1 2\n"), 11,
                      "y of vertex 1");
  }
}

TEST(ReadPly, ErrorsNameThePlace) {
  const std::string text = ascii_tetrahedron();
  expect_unreadable(read_as("a.ply", "hello, this is no mesh\n"), 1,
                    "expected 'ply', found 'hello");
  expect_unreadable(read_as("a.ply", with(text, "3 1 2 3", "3 1 2 4")), 17,
                    "face 3 names vertex '4'");
  expect_unreadable(read_as("a.ply", with(text, "3 1 2 3", "3 1 2 -1")), 17, "names vertex '-1'");
  expect_unreadable(read_as("a.ply", with(text, "3 1 2 3", "3 1 2 1.5")), 17, "names vertex '1.5'");
  expect_unreadable(read_as("a.ply", with(text, "3 1 2 3", "-3 1 2 3")), 17, "has length '-3'");
  expect_unreadable(read_as("a.ply", with(text, "3 1 2 3", "900 1 2 3")), 17, "has length '900'");
  expect_unreadable(read_as("a.ply", with(text, "3 1 2 3\n", "3 1 2\n")), 18, "cut short");
  expect_unreadable(read_as("a.ply", with(text, "format ascii 1.0\n", "")), 9, "no format line");
  expect_unreadable(read_as("a.ply", with(text, "ascii", "octal")), 2, "found 'octal'");
  expect_unreadable(read_as("a.ply", with(text, "float z", "float w")), 10, "no number 'z'");
  expect_unreadable(read_as("a.ply", with(text, "float z", "list int float z")), 10,
                    "no number 'z'");
  expect_unreadable(read_as("a.ply", with(text, "float z", "float y")), 6, "a second property 'y'");
  expect_unreadable(read_as("a.ply", with(text, "element face 4", "element vertex 4")), 7,
                    "a second element");
  expect_unreadable(read_as("a.ply", with(text, "float x", "quad x")), 4, "found 'quad'");
  expect_unreadable(read_as("a.ply", with(text, "list uchar", "list float")), 8, "list's length");
  expect_unreadable(read_as("a.ply", with(text, "vertex_indices", "corners")), 13,
                    "no list vertex_indices");
  expect_unreadable(read_as("a.ply", with(text, "end_header", "endheader")), 9,
                    "found 'endheader'");
  expect_unreadable(read_as("a.ply", with(text, "vertex 4", "vertex -4")), 3,
                    "found 'vertex' and '-4'");
  expect_unreadable(read_as("a.ply", with(text, "face 4", "face 4000000000")), 13,
                    "promises 4000000000");
  expect_unreadable(read_as("a.ply", with(text, "vertex 4", "vertex 9223372036854775807")), 10,
                    "2^32");
  expect_unreadable(read_as("a.ply", "ply\nformat ascii 1.0\n"), 3, "no end_header");
  expect_unreadable(read_as("a.ply", header("ascii", "element vertex 4\n" + kXyz) + kVertices), 0,
                    "4 vertices and no faces, a point cloud");
  expect_unreadable(
      read_as("a.ply",
              header("ascii", "element vertex 4\n" + kXyz + "element face 0\n") + kVertices),
      0, "a point cloud");
  expect_unreadable(read_as("a.ply", header("ascii", "")), 0, "no vertices and no faces");
}

TEST(ReadPly, BinaryErrorsNameTheByte) {
  const std::string text =
      binary_tetrahedron<float, std::uint8_t, std::int32_t>("float", "uchar", "int", false);
  const std::size_t body = text.find("end_header\n") + 11;
  std::string bad = text;
  bad.replace(body + 13 + 4, 4, "\x00\x00\xC0\x7F", 4);
  expect_unreadable(read_as("a.ply", bad), body + 17, "finite number for y of vertex 1, found nan");
  const std::size_t faces = body + 4 * 13, face = 1 + 12 + 8;
  bad = text;
  bad[faces + 2 * face + 1 + 8] = 4;
  expect_unreadable(read_as("a.ply", bad), faces + 2 * face + 9, "face 2 names vertex 4");
  expect_unreadable(read_as("a.ply", text.substr(0, text.size() - 3)), text.size() - 8,
                    "area of face 3 of 4");
  expect_unreadable(read_as("a.ply", with(text, "face 4", "face 5000")), faces + 3,
                    "promises 5000");
}

}  // namespace
}  // namespace nacre::io
