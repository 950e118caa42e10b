// SPDX-License-Identifier: GPL-3.0-or-later
//
// CGAL's readers as an independent opinion on well-formed files: the same points and faces, in
// order.
#include <CGAL/IO/polygon_soup_io.h>
#include <CGAL/Simple_cartesian.h>

#include "io/io_test_support.h"
#include "support/corpus.h"

namespace nacre::io {
namespace {

using Point = CGAL::Simple_cartesian<double>::Point_3;

class AgainstCgal : public testing::TestWithParam<const char*> {};

TEST_P(AgainstCgal, SamePointsAndFaces) {
  NACRE_SKIP_WITHOUT(GetParam());
  const std::string file = corpus::mesh(GetParam()).string();
  std::vector<Point> points;
  std::vector<std::vector<std::size_t>> faces;
  ASSERT_TRUE(CGAL::IO::read_polygon_soup(file, points, faces));
  const auto read = read_scan(file);
  ASSERT_TRUE(read.has_value()) << read.error().message;
  const Scan& scan = (*read).scan;
  ASSERT_EQ(scan.positions.size(), points.size());
  // CGAL rounds the decimals of a float property to floats; nacre keeps them as doubles.
  const bool rounded = (*read).report.format == "ply-ascii";
  std::size_t different = 0;
  for (std::size_t v = 0; v < points.size(); ++v) {
    for (int k = 0; k < 3; ++k) {
      const double ours = scan.positions[v][k], theirs = points[v][k];
      const bool same =
          rounded ? static_cast<float>(ours) == static_cast<float>(theirs) : ours == theirs;
      different += same ? 0 : 1;
    }
  }
  EXPECT_EQ(different, 0u);
  ASSERT_EQ(scan.triangles.size(), faces.size());
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const Triangle& t = scan.triangles[f];
    ASSERT_EQ(faces[f], (std::vector<std::size_t>{t[0], t[1], t[2]})) << "face " << f;
  }
}

INSTANTIATE_TEST_SUITE_P(Meshes, AgainstCgal,
                         testing::Values("horse.ply", "bunny.ply", "rockerarm.ply", "rangemap.ply",
                                         "laurana.ply", "elephant.off", "doll_face.obj",
                                         "fandisk.obj"),
                         [](const auto& mesh) {
                           std::string name = mesh.param;
                           std::replace(name.begin(), name.end(), '.', '_');
                           return name;
                         });

}  // namespace
}  // namespace nacre::io
