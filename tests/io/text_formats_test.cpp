// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/io_test_support.h"

namespace nacre::io {
namespace {

const std::string kObjVertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
const std::string kObj = kObjVertices + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
const std::string kOffBody = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

std::string with(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
  return text;
}

TEST(ReadObj, FacesInEveryForm) {
  const auto plain = read_as("a.obj", kObj);
  expect_tetrahedron(plain);
  EXPECT_EQ((*plain).report.format, "obj");
  EXPECT_EQ((*plain).report.not_carried, Names{});
  const std::string head = "mtllib a.mtl\nvt 0 0\nvn 0 0 1\n" + kObjVertices;
  const auto dressed = read_as(
      "a.obj", head +
                   "g one\nusemtl m\nf 1/1 3/1 2/1\ng two\ns off\nf 1//1 2//1 4//1\n"
                   "o three\nf 1/1/1 4/1/1 3/1/1\nf 2 3/1 4//1\nl 1 2\np 1\nshadow_obj x\n");
  expect_tetrahedron(dressed);
  EXPECT_EQ((*dressed).report.not_carried,
            (Names{"mtllib", "vt", "vn", "g", "usemtl", "face texture or normal indices", "s", "o",
                   "l", "p", "unknown statement 'shadow_obj'"}));
  expect_tetrahedron(
      read_as("a.obj", kObjVertices + "f -4 -2 -3\nf -4 -3 -1\nf -4 -1 -2\nf -3 -2 -1\n"));
  // Relative numbers count back from the vertices read so far.
  expect_tetrahedron(read_as("a.obj",
                             "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -1 -2\nv 0 0 1\n"
                             "f -4 -3 -1\nf -4 -1 -2\nf -3 -2 -1\n"));
  // Absolute ones may run ahead.
  expect_tetrahedron(read_as("a.obj", "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n" + kObjVertices));
}

TEST(ReadObj, LinesInEveryForm) {
  expect_tetrahedron(read_as("a.obj", with(kObj, "\n", "\r\n")));
  expect_tetrahedron(read_as("a.obj", with(kObj, "\n", "\r")));
  expect_tetrahedron(
      read_as("a.obj", "\xEF\xBB\xBF# made by hand\n\n" + with(kObj, "\n", "  # end\n")));
  expect_tetrahedron(read_as("a.obj", with(with(kObj, "f 1 3", "f 1 \\\n 3"), "v ", "v \\\r\n\t")));
  expect_tetrahedron(read_as("a.txt", kObj));
  const auto colored = read_as("a.obj", with(kObj, "v 0 0 1", "v 0 0 1 0.5 0.5 0.5"));
  expect_tetrahedron(colored);
  EXPECT_EQ((*colored).report.not_carried, Names{"vertex colour"});
  const auto weighted = read_as("a.obj", with(kObj, "v 0 0 1", "v 0 0 1 1.0"));
  expect_tetrahedron(weighted);
  EXPECT_EQ((*weighted).report.not_carried, Names{"vertex weight"});
}

TEST(ReadObj, PolygonsAreCutAlongShortDiagonals) {
  const auto read =
      read_as("a.obj", "v 0 0 0\nv 2 0 0\nv 2.5 1 0\nv 0 1 0\nf 1 2 3 4\nf 1 2\nf 1 2 3\n");
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_EQ((*read).scan.triangles, (std::vector<Triangle>{{3, 0, 1}, {1, 2, 3}, {0, 1, 2}}));
  EXPECT_EQ((*read).report.polygons_triangulated, 1u);
  EXPECT_EQ((*read).report.faces_skipped, 1u);
}

TEST(ReadObj, ErrorsNameThePlace) {
  expect_unreadable(read_as("a.obj", kObj + "f 1 2 5\n"), 9,
                    "face 5 names vertex 5, but there are 4");
  expect_unreadable(read_as("a.obj", kObj + "f 1 2 0\n"), 9, "face 5 names vertex 0");
  expect_unreadable(read_as("a.obj", kObj + "f 1 2 -5\n"), 9, "face 5 names vertex -5");
  expect_unreadable(read_as("a.obj", kObj + "f 1 2 99999999999\n"), 9, "names vertex 99999999999");
  expect_unreadable(read_as("a.obj", kObj + "f 1 2 9999999999999999999999\n"), 9, "found '99999");
  expect_unreadable(read_as("a.obj", kObj + "f 1 2 x/3\n"), 9, "found 'x/3'");
  expect_unreadable(read_as("a.obj", kObj + "v 1 2\n"), 9,
                    "z of vertex 5, found the end of the line");
  expect_unreadable(read_as("a.obj", kObj + "v 1 nan 2\n"), 9, "y of vertex 5, found 'nan'");
  expect_unreadable(read_as("a.obj", kObjVertices), 0, "4 vertices and no faces, a point cloud");
  expect_unreadable(read_as("a.obj", kObjVertices + "f 1 2\n"), 0,
                    "none of 1 faces has three corners");
  expect_unreadable(read_as("a.obj", "Dear reader,\nthis is a letter.\n"), 0,
                    "no vertices and no faces");
}

TEST(ReadOff, HeadersInEveryForm) {
  const auto plain = read_as("a.off", "OFF\n4 4 6\n" + kOffBody);
  expect_tetrahedron(plain);
  EXPECT_EQ((*plain).report.format, "off");
  EXPECT_EQ((*plain).report.not_carried, Names{});
  expect_tetrahedron(read_as("a.off", "OFF 4 4 6\n" + kOffBody));
  expect_tetrahedron(read_as("a.off", "OFF\n4 4\n" + kOffBody));  // without the edge count
  expect_tetrahedron(read_as("a.off", "OFF\r\n\r\n4 4 0\r\n\r\n" + with(kOffBody, "\n", "\r\n")));
  expect_tetrahedron(
      read_as("a.off", "# a\nOFF # b\n# c\n4 4 6 # d\n\n" + with(kOffBody, "\n", " # e\n#f\n")));
  expect_tetrahedron(read_as("a.off", "4 4 6\n" + kOffBody));  // the keyword is optional
  expect_tetrahedron(read_as("a.dat", "OFF\n4 4 6\n" + kOffBody));
  expect_tetrahedron(read_as("a.off", "OFF\n4 4 6\n" + kOffBody.substr(0, kOffBody.size() - 1)));
}

TEST(ReadOff, ColoursNormalsAndTextureCoordinatesArePassedOver) {
  const std::string body =
      "0 0 0 9 9\n1 0 0 9\n0 1 0\n0 0 1 9 9 9 9\n"
      "3 0 2 1 255 0 0\n3 0 1 3 0.5 0.5 0.5 1\n3 0 3 2 7\n3 1 2 3\n";
  const std::vector<std::pair<std::string, Names>> headers = {
      {"COFF", {"vertex colour", "face colour"}},
      {"NOFF", {"vertex normal", "face colour"}},
      {"STOFF", {"texture coordinates", "face colour"}},
      {"STCNOFF", {"texture coordinates", "vertex colour", "vertex normal", "face colour"}},
      {"OFF", {"values after x y z", "face colour"}}};
  for (const auto& [keyword, names] : headers) {
    const auto read = read_as("a.off", keyword + "\n4 4 6\n" + body);
    expect_tetrahedron(read);
    EXPECT_EQ((*read).report.not_carried, names) << keyword;
  }
}

TEST(ReadOff, Polygons) {
  const auto read =
      read_as("a.off", "OFF 4 2 0\n0 0 0\n2 0 0\n2 1 0\n0 1 0\n4 3 2 1 0 1 0 0\n2 0 1\n");
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_EQ((*read).scan.triangles, (std::vector<Triangle>{{0, 3, 2}, {2, 1, 0}}));
  EXPECT_EQ((*read).report.faces_skipped, 1u);
}

TEST(ReadOff, ErrorsNameThePlace) {
  const std::string text = "OFF\n4 4 6\n" + kOffBody;
  expect_unreadable(read_as("a.off", with(text, "3 1 2 3", "3 1 2 4")), 10,
                    "face 3 names vertex 4");
  expect_unreadable(read_as("a.off", with(text, "3 1 2 3", "3 1 2 -1")), 10,
                    "face 3 names vertex -1");
  expect_unreadable(read_as("a.off", with(text, "3 1 2 3", "3 1 2")), 11,
                    "corner 3 of the 3 of face 3 of 4");
  expect_unreadable(read_as("a.off", with(text, "3 1 2 3", "x 1 2 3")), 10, "found 'x'");
  expect_unreadable(read_as("a.off", with(text, "0 1 0\n", "0 inf 0\n")), 5,
                    "y of vertex 2 of 4, found 'inf'");
  expect_unreadable(read_as("a.off", with(text, "4 4 6", "4 9 6")), 11,
                    "face 4 of 9, found the end");
  expect_unreadable(read_as("a.off", with(text, "4 4 6", "4 4000000000 6")), 3,
                    "4000000000 faces, but only");
  expect_unreadable(read_as("a.off", with(text, "4 4 6", "-4 4 6")), 2, "vertex count");
  expect_unreadable(read_as("a.off", with(text, "OFF", "4OFF")), 1, "found '4OFF'");
  expect_unreadable(read_as("a.off", with(text, "OFF", "OFF BINARY")), 1, "binary OFF");
  expect_unreadable(read_as("a.off", "no mesh at all\n"), 1,
                    "vertex count of an OFF file, found 'no'");
  expect_unreadable(read_as("a.off", "OFF\n4 0 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n"), 0,
                    "a point cloud");
}

}  // namespace
}  // namespace nacre::io
