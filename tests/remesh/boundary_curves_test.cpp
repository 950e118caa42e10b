// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/boundary_curves.h"

#include <gtest/gtest.h>

#include "map_checks.h"
#include "remesh/relax.h"
#include "support/random.h"

namespace nacre::remesh {
namespace {

struct Mapped {
  Scan scan;
  Parameterisation map;
};

Mapped mapped(const Scan& scan) {
  SimplifyOptions options;
  options.base_vertices = 24;
  Mapped out{scan, *simplify(scan, options)};
  relax(out.scan, out.map, {});
  return out;
}

Vec3 at(const Mapped& m, const BoundaryCurves::Hit& hit) {
  return position_of(hit.point, m.scan.triangles, m.scan.positions);
}

/// Calls visit(face, side) for every boundary side of the base.
template <class Visit>
void for_boundary_sides(const BaseMesh& base, const Visit& visit) {
  for (std::uint32_t f = 0; f < base.triangles.size(); ++f)
    for (std::uint32_t k = 0; k < 3; ++k)
      if (base.neighbors[f][k] == kNone) visit(f, k);
}

std::vector<Mapped> open_scans() {
  std::vector<Mapped> out;
  for (const Scan& scan :
       {shapes::hemisphere(4), shapes::grid(16, 12), shapes::holed_grid(16, 5, 11)})
    out.push_back(mapped(scan));
  return out;
}

TEST(BoundaryCurves, AddressTheBoundaryByArcLength) {
  for (const Mapped& m : open_scans()) {
    const SurfaceMap map(m.scan, m.map);
    const BoundaryCurves curves(map, m.map);
    std::size_t sides = 0;
    for_boundary_sides(m.map.base, [&](std::uint32_t f, std::uint32_t k) {
      ++sides;
      // A plane that meets nothing: the middle of the range comes back.
      for (const double from : {0.0, 0.25, 0.5}) {
        const auto hit = curves.pierce(f, k, from, from + 0.5, {0, 0, 1e9}, {0, 0, 1});
        EXPECT_EQ(hit.parameter, from + 0.25);
        ASSERT_TRUE(testing::is_valid(hit.point, m.scan.triangles.size()));
        const DomainPoint q = map.to_domain(hit.point);
        EXPECT_EQ(q.face, f);
        EXPECT_NEAR(q.weight[(k + 1) % 3], hit.parameter, 1e-9);
        EXPECT_NEAR(q.weight[(k + 2) % 3], 0, 1e-12);
      }
    });
    EXPECT_GE(sides, 3u);
  }
}

TEST(BoundaryCurves, MeetThePlaneWherePossible) {
  TestRandom random(31);
  for (const Mapped& m : open_scans()) {
    const SurfaceMap map(m.scan, m.map);
    const BoundaryCurves curves(map, m.map);
    std::size_t met = 0, tried = 0;
    for_boundary_sides(m.map.base, [&](std::uint32_t f, std::uint32_t k) {
      for (int i = 0; i < 20; ++i) {
        double from = random.unit(), to = random.unit();
        if (from > to) std::swap(from, to);
        const Vec3 through =
            at(m, curves.pierce(f, k, from, to, {0, 0, 1e9}, {0, 0, 1})) + 0.02 * random.point();
        const Vec3 direction = random.direction();
        const auto hit = curves.pierce(f, k, from, to, through, direction);
        ++tried;
        EXPECT_GE(hit.parameter, from + 0.2 * (to - from) - 1e-12);
        EXPECT_LE(hit.parameter, to - 0.2 * (to - from) + 1e-12);
        ASSERT_TRUE(testing::is_valid(hit.point, m.scan.triangles.size()));
        const DomainPoint q = map.to_domain(hit.point);
        EXPECT_NEAR(q.weight[(k + 1) % 3], hit.parameter, 1e-9);
        const double off = std::abs((at(m, hit) - through).dot(direction));
        if (off < 1e-9) {
          ++met;
        } else {
          EXPECT_EQ(hit.parameter, (from + to) / 2);
        }
      }
    });
    EXPECT_GT(met, tried / 10);
  }
}

}  // namespace
}  // namespace nacre::remesh
