// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/io_test_support.h"

namespace nacre::io {
namespace {

std::string binary_stl(std::string head, std::uint16_t attribute = 0) {
  head.resize(80, ' ');
  append(head, static_cast<std::uint32_t>(kFaces.size()));
  for (const Triangle& t : kFaces) {
    for (int k = 0; k < 3; ++k) append(head, 0.0f);
    for (const std::uint32_t v : t) {
      for (int k = 0; k < 3; ++k) append(head, static_cast<float>(kCorners[v][k]));
    }
    append(head, attribute);
  }
  return head;
}

std::string ascii_facet(const Triangle& t) {
  std::string text = "  facet normal 0 0 1\n    outer loop\n";
  for (const std::uint32_t v : t) {
    text += "      vertex";
    for (int k = 0; k < 3; ++k) text += kCorners[v][k] == 0.0 ? " 0.0" : " 1.0e+00";
    text += "\n";
  }
  return text + "    endloop\n  endfacet\n";
}

std::string ascii_stl() {
  std::string text = "solid facet of a crystal\n";
  for (const Triangle& t : kFaces) text += ascii_facet(t);
  return text + "endsolid facet of a crystal\n";
}

void expect_tetrahedron_soup(const Result<ReadResult>& result) {
  ASSERT_TRUE(result.has_value()) << result.error().message;
  const Scan& scan = (*result).scan;
  ASSERT_EQ(scan.triangles.size(), 4u);
  ASSERT_EQ(scan.positions.size(), 12u);
  for (std::size_t f = 0; f < 4; ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(scan.positions[scan.triangles[f][k]], kCorners[kFaces[f][k]]);
    }
  }
}

TEST(ReadStl, Binary) {
  const auto read = read_as("a.stl", binary_stl("made by hand"));
  expect_tetrahedron_soup(read);
  EXPECT_EQ((*read).report.format, "stl-binary");
  EXPECT_EQ((*read).report.not_carried, Names{"facet normals"});
  expect_tetrahedron_soup(read_as("a.stl", binary_stl("solid but binary")));
  expect_tetrahedron_soup(read_as("a.bin", binary_stl("known by its size")));
  expect_tetrahedron_soup(read_as("a.stl", binary_stl(std::string(80, '\0'))));
  EXPECT_EQ((*read_as("a.stl", binary_stl("colour", 0x7FFF))).report.not_carried,
            (Names{"facet normals", "facet attributes"}));
  const auto longer = read_as("a.stl", binary_stl("x") + "more");
  expect_tetrahedron_soup(longer);
  EXPECT_EQ((*longer).report.not_carried, (Names{"facet normals", "bytes after the last facet"}));
}

TEST(ReadStl, Ascii) {
  const auto read = read_as("a.stl", ascii_stl());
  expect_tetrahedron_soup(read);
  EXPECT_EQ((*read).report.format, "stl-ascii");
  std::string upper = ascii_stl();
  for (char& c : upper) c = static_cast<char>(std::toupper(c));
  expect_tetrahedron_soup(read_as("A.STL", upper));
  expect_tetrahedron_soup(read_as("a.txt", ascii_stl()));
  std::string odd = "solid\n" + ascii_facet(kFaces[0]) + ascii_facet(kFaces[1]) +
                    "endsolid\nsolid two\n" + ascii_facet(kFaces[2]) + ascii_facet(kFaces[3]) +
                    "endsolid two";
  odd.replace(odd.find("0 0 1"), 5, "nan -1.#IND nan");
  expect_tetrahedron_soup(read_as("a.stl", odd));
}

TEST(ReadStl, ErrorsNameThePlace) {
  const std::string binary = binary_stl("x");
  expect_unreadable(read_as("a.stl", binary.substr(0, 200)), 200,
                    "promises 4 facets, 284 bytes in all");
  std::string bad = binary;
  bad.replace(84 + 50 + 12 + 16, 4, "\x00\x00\x80\xFF", 4);
  expect_unreadable(read_as("a.stl", bad), 84 + 50 + 12 + 16,
                    "y of corner 1 of facet 1, found -inf");
  bad = binary.substr(0, 84);
  bad.replace(80, 4, std::string(4, '\0'));
  expect_unreadable(read_as("a.stl", bad), 0, "no vertices and no faces");

  const std::string text = ascii_stl();
  const auto with = [&](const char* from, const char* to) {
    std::string changed = text;
    return changed.replace(changed.find(from), std::strlen(from), to);
  };
  expect_unreadable(read_as("a.stl", with("vertex", "vertebra")), 4, "found 'vertebra'");
  expect_unreadable(read_as("a.stl", with("vertex 0.0", "vertex nan")), 4,
                    "x of corner 0 in facet 0, found 'nan'");
  expect_unreadable(read_as("a.stl", with("endloop", "endlop")), 7, "found 'endlop'");
  expect_unreadable(read_as("a.stl", with("outer", "inner")), 3, "expected 'outer' in facet 0");
  expect_unreadable(read_as("a.stl", text.substr(0, text.find("endloop"))), 7, "end of the file");
  expect_unreadable(read_as("a.stl", "a letter\n"), 1, "found 'a'");
  expect_unreadable(read_as("a.stl", "solid x\nendsolid x\n"), 0, "no vertices and no faces");
}

}  // namespace
}  // namespace nacre::io
