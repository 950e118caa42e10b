// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/snap_base.h"

#include <gtest/gtest.h>

#include <cmath>

#include "codec/codec.h"
#include "synthetic.h"

namespace nacre::codec {
namespace {

Prepared prepared_mesh(const Scan& base) {
  // Smooth, so that descent finds what is nearest.
  const synthetic::Shape smooth{.amplitude = 0.002, .tangential = 0};
  return *prepare(synthetic::normal_mesh(base, smooth), wavelet::Transform::kButterfly);
}

TEST(SnapBase, PutsTheBaseOnTheGridNearerThanRoundingDoes) {
  const Prepared prepared = prepared_mesh(shapes::sphere(2));
  const SurfaceWeights weights = surface_weights(prepared);
  const double step = 0.03;
  const Prepared snapped = snap_base(prepared, weights, step);
  double by_snapping = 0, by_rounding = 0;
  for (std::uint32_t v = 0; v < prepared.topology.level(0).vertex_count; ++v) {
    const Vec3 &p = prepared.positions[v], &q = snapped.positions[v];
    Vec3 rounded;
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(q[k], std::round(q[k] / step) * step);
      rounded[k] = std::round(p[k] / step) * step;
    }
    EXPECT_LT((q - p).norm(), 2 * step);
    EXPECT_EQ(q, snapped.pyramid.base_positions[v]);
    by_snapping += foot_on_surface(prepared, weights, q, v).squared_distance;
    by_rounding += foot_on_surface(prepared, weights, rounded, v).squared_distance;
  }
  EXPECT_LT(by_snapping, by_rounding / 5);
}

TEST(SnapBase, FinerVerticesStayOnTheSurface) {
  const Prepared prepared = prepared_mesh(shapes::sphere(2));
  const SurfaceWeights weights = surface_weights(prepared);
  const Prepared snapped = snap_base(prepared, weights, 0.03);
  const std::uint32_t base = prepared.topology.level(0).vertex_count;
  double moved = 0;
  for (std::uint32_t v = base; v < prepared.positions.size(); ++v) {
    EXPECT_LT(foot_on_surface(prepared, weights, snapped.positions[v], v).squared_distance, 1e-20);
    moved += (snapped.positions[v] - prepared.positions[v]).norm();
  }
  EXPECT_GT(moved / static_cast<double>(prepared.positions.size()), 0.003);
  // Vectors are those of the new positions.
  EXPECT_EQ(snapped.vectors.size(), prepared.vectors.size());
  EXPECT_EQ(snapped.vectors, detail_vectors(prepared.topology, snapped.positions));
}

TEST(SnapBase, BoundariesAreRounded) {
  const Prepared prepared = prepared_mesh(shapes::grid(6, 5));
  const double step = 0.0625;
  const Prepared snapped = snap_base(prepared, surface_weights(prepared), step);
  for (const Edge& e : prepared.topology.level(0).edges) {
    if (!e.is_boundary()) continue;
    for (const std::uint32_t v : e.vertex)
      for (int k = 0; k < 3; ++k)
        EXPECT_EQ(snapped.positions[v][k], std::round(prepared.positions[v][k] / step) * step);
  }
}

TEST(EncodeAtAStep, SmallerStepsMakeLargerAndBetterFiles) {
  const SemiRegularMesh mesh = synthetic::normal_mesh(synthetic::irregular_base());
  const Prepared prepared = *prepare(mesh, wavelet::Transform::kButterfly);
  const SurfaceWeights weights = surface_weights(prepared);
  EncodeOptions options;
  options.profile = Profile::kBest;
  std::size_t bytes = 0;
  double error = 1;
  for (const double step : {0.1, 0.03, 0.01, 0.003}) {
    options.step = step;
    const auto encoded = encode(mesh, options);
    ASSERT_TRUE(encoded.has_value()) << encoded.error().message;
    EXPECT_GT(encoded->bytes.size(), bytes) << step;
    const auto decoded = decode(encoded->bytes);
    ASSERT_TRUE(decoded.has_value());
    // Of the surface: with targets, vertices are free to drift along it.
    const double left = surface_error(prepared, weights, decoded->positions);
    EXPECT_LT(left, error) << step;
    bytes = encoded->bytes.size();
    error = left;
  }
}

TEST(EncodeAtAStep, IsForProfileBestAndInsteadOfASize) {
  const SemiRegularMesh mesh = synthetic::normal_mesh(shapes::octahedron());
  const auto refused = [&](Profile profile, double step, std::size_t bytes) {
    EncodeOptions options;
    options.profile = profile;
    options.step = step;
    options.target_bytes = bytes;
    const auto encoded = encode(mesh, options);
    return !encoded && encoded.error().code == ErrorCode::kBadInput;
  };
  EXPECT_TRUE(refused(Profile::kBest, 0, 0));
  EXPECT_TRUE(refused(Profile::kBest, 0.01, 1000));
  EXPECT_TRUE(refused(Profile::kBest, -1, 0));
  EXPECT_TRUE(refused(Profile::kBest, std::nan(""), 0));
  EXPECT_TRUE(refused(Profile::kPaper, 0.01, 0));
  EXPECT_FALSE(refused(Profile::kBest, 0.01, 0));
}

}  // namespace
}  // namespace nacre::codec
