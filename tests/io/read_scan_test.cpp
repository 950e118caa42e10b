// SPDX-License-Identifier: GPL-3.0-or-later
#include <array>
#include <cmath>

#include "io/io_test_support.h"
#include "io/soup.h"
#include "support/corpus.h"
#include "support/shapes.h"

namespace nacre::io {
namespace {

TEST(ReadScan, FilesThatAreNoMesh) {
  const TemporaryFolder folder;
  expect_unreadable(read_scan(folder / "none.ply"), 0, "none.ply: no such file");
  expect_unreadable(read_scan(folder.path()), 0, "is a folder");
  expect_unreadable(read_as("empty.ply", ""), 0, "the file is empty");
  expect_unreadable(read_as("blank.obj", "\n\n"), 0, "no vertices and no faces");
  expect_unreadable(read_as("a.gz", "\x1F\x8B\x08 and so on"), 0, "unpack it");
  expect_unreadable(read_as("a.glb", "glTF\x02"), 0, "convert it to PLY");
  expect_unreadable(read_as("a.txt", "some text"), 0,
                    "unknown format; expected PLY, OBJ, OFF or STL");
  // What stands in the file must not break the message's line.
  expect_unreadable(read_as("a.ply", "\x1B[31m \x01\n\n"), 1, "found '?[31m ?'");
}

double area_of(const Scan& scan, std::span<const Triangle> triangles, const Vec3& normal) {
  double area = 0.0;
  for (const Triangle& t : triangles) {
    const Vec3& a = scan.positions[t[0]];
    const double part =
        dot(cross(scan.positions[t[1]] - a, scan.positions[t[2]] - a), normal) / 2.0;
    EXPECT_GE(part, 0.0) << "a triangle is turned over";
    area += part;
  }
  return area;
}

TEST(Triangulate, ConcavePolygonsAreCoveredWithoutOverlap) {
  // A comb of five teeth, a star, and a spiral: areas by the shoelace formula, all tilted.
  std::vector<std::vector<std::array<double, 2>>> outlines(3);
  for (int i = 0; i < 5; ++i) {
    outlines[0].push_back({2.0 * i, 5.0});
    outlines[0].push_back({2.0 * i + 1.0, 0.5});
  }
  outlines[0].insert(outlines[0].end(), {{10.0, 5.0}, {10.0, 0.0}, {0.0, 0.0}});
  for (int i = 0; i < 20; ++i) {
    const double r = i % 2 == 0 ? 1.0 : 0.2;
    outlines[1].push_back({r * std::cos(0.1 * i * M_PI), r * std::sin(0.1 * i * M_PI)});
  }
  for (int i = 0; i <= 30; ++i)
    outlines[2].push_back({(2 + 0.1 * i) * std::cos(0.4 * i), (2 + 0.1 * i) * std::sin(0.4 * i)});
  for (int i = 30; i >= 0; --i)
    outlines[2].push_back(
        {(1.8 + 0.1 * i) * std::cos(0.4 * i), (1.8 + 0.1 * i) * std::sin(0.4 * i)});
  for (auto& outline : outlines) {
    Scan scan;
    std::vector<std::uint32_t> corners;
    double expected = 0.0;
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const auto &p = outline[i], &q = outline[(i + 1) % outline.size()];
      expected += (p[0] * q[1] - p[1] * q[0]) / 2.0;
      scan.positions.emplace_back(p[0], 0.6 * p[1], 0.8 * p[1]);
      corners.push_back(static_cast<std::uint32_t>(i));
    }
    const Vec3 normal = Vec3(0, -0.8, 0.6) * (expected < 0 ? -1.0 : 1.0);
    std::vector<Triangle> triangles(corners.size() - 2);
    triangulate_polygon(corners, scan.positions, triangles);
    EXPECT_NEAR(area_of(scan, triangles, normal), std::abs(expected), 1e-12 * std::abs(expected));
  }
}

TEST(Triangulate, DegeneratePolygonsStillGiveTriangles) {
  const std::vector<Vec3> line = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}};
  for (const std::vector<std::uint32_t>& corners :
       {std::vector<std::uint32_t>{0, 1, 2, 3, 4}, {0, 0, 0, 0}, {0, 1, 0, 1, 2}}) {
    std::vector<Triangle> triangles(corners.size() - 2, Triangle{9, 9, 9});
    triangulate_polygon(corners, line, triangles);
    for (const Triangle& t : triangles) {
      for (const std::uint32_t v : t) EXPECT_LT(v, 5u);
    }
  }
}

TEST(ReadScan, HugePolygonIsCutInTime) {
  std::string text, face = "f";
  const int n = 200000;
  for (int i = 0; i < n; ++i) {
    const double angle = 2.0 * M_PI * i / n;
    text += "v " + std::to_string(std::cos(angle)) + " ";
    text += std::to_string(std::sin(angle)) + " 0\n";
    face += ' ';
    face += std::to_string(i + 1);
  }
  const auto read = read_as("a.obj", text + face + "\n");
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_EQ((*read).scan.triangles.size(), static_cast<std::size_t>(n - 2));
}

TEST(ReadScan, FarAwayScansKeepTheirDetail) {
  // UTM-like: a one-metre bunny-sized object seven orders of magnitude away from zero.
  const Vec3 offset(448262.123456, 5412345.654321, 117.5);
  const Scan sphere = shapes::sphere(3);
  std::string text = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                     std::to_string(sphere.positions.size() + 1) +
                     "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
                     std::to_string(sphere.triangles.size()) +
                     "\nproperty list uchar uint vertex_indices\nend_header\n";
  for (const Vec3& p : sphere.positions) {
    for (int k = 0; k < 3; ++k) append(text, p[k] + offset[k]);
  }
  for (int k = 0; k < 3; ++k) append(text, 0.0);  // a placeholder that no face uses
  for (const Triangle& t : sphere.triangles) {
    append(text, std::uint8_t{3});
    for (const std::uint32_t v : t) append(text, v);
  }
  const auto read = read_as("utm.ply", text);
  ASSERT_TRUE(read.has_value()) << read.error().message;
  const Scan& scan = (*read).scan;
  EXPECT_LT(norm(scan.origin - offset), 4.0);
  for (std::size_t v = 0; v < sphere.positions.size(); ++v) {
    for (int k = 0; k < 3; ++k) {
      const double stored = sphere.positions[v][k] + offset[k];
      EXPECT_EQ(scan.positions[v][k], stored - scan.origin[k]);
      EXPECT_EQ(scan.positions[v][k] + scan.origin[k], stored);  // nothing was rounded away
    }
  }
  // Out and in again, through every format that keeps doubles.
  for (const MeshFormat format : {MeshFormat::kPly, MeshFormat::kObj, MeshFormat::kOff}) {
    const auto bytes = serialize_mesh(scan, format);
    ASSERT_TRUE(bytes.has_value());
    const auto again = read_as(format == MeshFormat::kPly   ? "a.ply"
                               : format == MeshFormat::kObj ? "a.obj"
                                                            : "a.off",
                               *bytes);
    ASSERT_TRUE(again.has_value()) << again.error().message;
    EXPECT_EQ((*again).scan.origin, scan.origin);
    EXPECT_EQ((*again).scan.positions, scan.positions);
    EXPECT_EQ((*again).scan.triangles, scan.triangles);
  }
}

TEST(ReadScan, OriginIsZeroUnlessFar) {
  const auto origin_at = [](double distance, double size) {
    Scan scan = shapes::tetrahedron();
    for (Vec3& p : scan.positions) p = p * (size / std::sqrt(12.0)) + Vec3(distance, 0, 0);
    return choose_origin(scan);
  };
  EXPECT_TRUE(origin_at(0.0, 1.0).isZero(0.0));
  EXPECT_TRUE(origin_at(15.9, 1.0).isZero(0.0));
  EXPECT_NEAR(origin_at(16.1, 1.0)[0], 16.0, 0.51);
  EXPECT_TRUE(origin_at(159.0, 10.0).isZero(0.0));
  EXPECT_FALSE(origin_at(-161.0, 10.0).isZero(0.0));
  EXPECT_TRUE(origin_at(5.0, 0.0).isZero(0.0)) << "a point has no diagonal to be far by";
}

struct CorpusMesh {
  const char* name;
  const char* format;
  std::size_t vertices, faces;
};

class Corpus : public testing::TestWithParam<CorpusMesh> {};

TEST_P(Corpus, HasTheCountsOfItsReadme) {
  const CorpusMesh& expected = GetParam();
  NACRE_SKIP_WITHOUT(expected.name);
  const auto read = read_scan(corpus::mesh(expected.name));
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_EQ((*read).report.format, expected.format);
  EXPECT_EQ((*read).scan.positions.size(), expected.vertices);
  EXPECT_EQ((*read).scan.triangles.size(), expected.faces);
  EXPECT_EQ((*read).report.polygons_triangulated, 0u);
  EXPECT_EQ((*read).report.faces_skipped, 0u);
  EXPECT_TRUE((*read).scan.origin.isZero(0.0));
}

INSTANTIATE_TEST_SUITE_P(
    Meshes, Corpus,
    testing::Values(CorpusMesh{"horse.ply", "ply-le", 48485, 96966},
                    CorpusMesh{"venus.off", "off", 50002, 100000},
                    CorpusMesh{"igea.ply", "ply-le", 134345, 268686},
                    CorpusMesh{"elephant.off", "off", 24955, 49918},
                    CorpusMesh{"bunny.ply", "ply-ascii", 35947, 69451},
                    CorpusMesh{"bunny_res3.ply", "ply-ascii", 1889, 3851},
                    CorpusMesh{"bunny_rangescans.ply", "ply-le", 362272, 677855},
                    CorpusMesh{"dragon.ply", "ply-le", 437645, 871414},
                    CorpusMesh{"rangemap.ply", "ply-le", 62702, 120995},
                    CorpusMesh{"laurana.ply", "ply-le", 27861, 49954},
                    CorpusMesh{"rockerarm.ply", "ply-be", 40177, 80354},
                    CorpusMesh{"doll_face.obj", "obj", 15270, 29962},
                    CorpusMesh{"mask.off", "off", 31756, 62460},
                    CorpusMesh{"maneki_neko.off", "off", 62385, 124677},
                    CorpusMesh{"fandisk.obj", "obj", 6475, 12946},
                    CorpusMesh{"conrod.stl", "stl-binary", 3 * 6442, 6442},  // unwelded
                    CorpusMesh{"drill_shaft.ply", "ply-ascii", 881, 1288}),
    [](const auto& mesh) {
      std::string name = mesh.param.name;
      std::replace(name.begin(), name.end(), '.', '_');
      return name;
    });

}  // namespace
}  // namespace nacre::io
