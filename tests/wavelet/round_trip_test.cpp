// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "support/shapes.h"
#include "wavelet/wavelet.h"

namespace nacre::wavelet {
namespace {
TEST(Smoke, RoundTrip) {
  for (auto tr : {Transform::kButterfly, Transform::kLoop}) {
    const Scan base = shapes::grid(3, 4);
    const Topology topology = *Topology::build(base.triangles, 20, 4);
    std::vector<Vec3> p(topology.vertex_count());
    std::uint64_t s = 1;
    for (auto& v : p)
      for (int c = 0; c < 3; ++c) {
        s = s * 6364136223846793005u + 1442695040888963407u;
        v[c] = double(s >> 11) * 0x1p-53;
      }
    const auto pyr = analyze(topology, p, tr);
    ASSERT_TRUE(pyr);
    const auto q = synthesize(topology, *pyr, tr);
    ASSERT_TRUE(q);
    double worst = 0;
    for (size_t i = 0; i < p.size(); ++i) worst = std::max(worst, (p[i] - (*q)[i]).norm());
    EXPECT_LT(worst, 1e-12);
    std::printf("%g\n", worst);
  }
  for (double e : regular_gains(7).energy) std::printf("%.6f\n", e);
}
}  // namespace
}  // namespace nacre::wavelet
