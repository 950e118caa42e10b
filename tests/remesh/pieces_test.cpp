// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <array>
#include <cmath>
#include <set>

#include "codec/codec.h"
#include "codec/decode.h"
#include "metric/metric.h"
#include "remesh/kept_pieces.h"
#include "remesh/piece_health.h"
#include "remesh_checks.h"
#include "support/broken_shapes.h"
#include "support/random.h"

namespace nacre::remesh {
namespace {

using testing::expect_healthy;
using testing::options_of;

Scan scaled(Scan scan, double by) {
  for (Vec3& p : scan.positions) p *= by;
  return scan;
}

/// A ball whose vertices lie up to `edges` of its edge lengths from where they should.
Scan tangled_ball(int levels, double edges) {
  Scan scan = shapes::sphere(levels);
  TestRandom random(3);
  for (Vec3& p : scan.positions) p += edges * 1.5 / (1 << levels) * random.point();
  return scan;
}

/// `count` pieces of 4 to 20 triangles all about the unit ball.
Scan specks(int count) {
  Scan all;
  TestRandom random(9);
  const std::array<Scan, 4> shape = {shapes::tetrahedron(), shapes::octahedron(),
                                     shapes::icosahedron(), shapes::grid(2, 2)};
  for (int i = 0; i < count; ++i) {
    Scan speck = scaled(shape[static_cast<std::size_t>(i) % 4], 0.02 + 0.02 * random.unit());
    for (Vec3& p : speck.positions) p += 0.004 * random.point();
    all = shapes::joined(all, shapes::moved(speck, 2.2 * random.direction()));
  }
  return all;
}

/// The healthy piece comes first, so that its base triangles do: they and their children alone.
Scan first_piece(const Remesh& out) {
  const std::size_t base = out.pieces[0].base_triangles;
  const TriangleMesh fine = testing::level_of(out.mesh, out.mesh.level_count);
  const std::size_t count = base << (2 * out.mesh.level_count);
  return shapes::only(fine, [&](std::size_t f) { return f < count; });
}

double error_of(const Scan& scan, const Scan& mesh) {
  const auto distance = metric::compare(scan, mesh, {.samples = 20'000});
  return std::max(distance->a_to_b.rms, distance->b_to_a.rms);
}

/// A base of the size that the remesher chooses; these are the bounds of what is healthy then.
constexpr double kMostError = 1e-3, kMostHealthyError = 2e-4;

TEST(Pieces, ATangledOneIsItsOwnBaseAndHarmsNoOther) {
  const Scan smooth = shapes::bumpy_sphere(4);
  const Scan ball = scaled(tangled_ball(3, 1.5), 0.5);
  const Scan scan = shapes::joined(smooth, shapes::moved(ball, {3, 0, 0}));
  const auto out = remesh(scan, options_of(0, 0));
  ASSERT_TRUE(out.has_value());
  expect_healthy(*out);
  ASSERT_EQ(out->pieces.size(), 2u);
  EXPECT_EQ(out->pieces[0].fallback, "");
  EXPECT_FALSE(out->pieces[0].is_own_base);
  EXPECT_LT(error_of(smooth, first_piece(*out)), kMostHealthyError);
  EXPECT_TRUE(out->pieces[1].is_own_base);
  EXPECT_TRUE(out->pieces[1].fallback.starts_with("its own triangles are the base: "))
      << out->pieces[1].fallback;
  EXPECT_EQ(out->pieces[1].base_triangles, ball.triangles.size());
  EXPECT_EQ(out->pieces[1].base_vertices, ball.positions.size());
  EXPECT_LT(testing::final_error(scan, *out), kMostHealthyError);
}

TEST(Pieces, SpecksComeOutAsTheyAre) {
  const Scan scan = shapes::joined(shapes::bumpy_sphere(5), specks(12));
  const auto out = remesh(scan, options_of(0, 0));
  ASSERT_TRUE(out.has_value());
  expect_healthy(*out);
  ASSERT_EQ(out->pieces.size(), 13u);
  EXPECT_EQ(out->pieces[0].fallback, "");
  for (const PieceReport& piece : out->pieces) {
    EXPECT_EQ(piece.is_own_base, piece.fallback.starts_with("its own triangles"));
    if (piece.is_own_base) {
      EXPECT_EQ(piece.base_triangles, piece.triangles);
    }
  }
  EXPECT_LT(testing::final_error(scan, *out), kMostError);
}

TEST(Pieces, NeedlesAreHealthy) {
  const Scan needles = shapes::with_needles(shapes::sphere(3), 2, 1e-4);
  const Scan scan = shapes::joined(shapes::bumpy_sphere(4), shapes::moved(needles, {4, 0, 0}));
  const auto out = remesh(scan, options_of(120, 3));
  ASSERT_TRUE(out.has_value());
  expect_healthy(*out);
  for (const PieceReport& piece : out->pieces) EXPECT_EQ(piece.fallback, "");
  EXPECT_LT(testing::final_error(scan, *out), 0.01);
}

TEST(Pieces, APredictionThatIsNoNumberStopsNothing) {
  const Scan scan =
      shapes::joined(shapes::bumpy_sphere(3), shapes::moved(shapes::sphere(3), {4, 0, 0}));
  Options options = options_of(40, 1);
  options.predict = [](const Topology& topology, int level, std::span<const Vec3> coarse) {
    PredictedLevel prediction = wavelet::predict_level(topology, level, coarse);
    for (std::size_t v = topology.level(level).vertex_count; v < prediction.positions.size(); ++v)
      if (prediction.positions[v][0] >= 2) prediction.positions[v] = Vec3::Constant(std::nan(""));
    prediction.frame_at = [](const LevelTopology& level_, std::span<const Vec3> p,
                             std::uint32_t e) {
      Frame frame{Vec3::UnitZ(), Vec3::UnitX(), Vec3::UnitY()};
      frame.normal += p[level_.vertex_count + e] - p[level_.vertex_count + e];  // no number
      return frame;
    };
    return prediction;
  };
  const auto out = remesh(scan, options);
  ASSERT_TRUE(out.has_value()) << out.error().message;
  expect_healthy(*out);
}

/// A bumpy ball of 2,048 triangles and beside it a tangled one of 512.
Scan ball_and_tangle() {
  return shapes::joined(shapes::bumpy_sphere(4), shapes::moved(tangled_ball(3, 2.5), {4, 0, 0}));
}

Options quick_options(int base_vertices, int levels) {
  Options options = options_of(base_vertices, levels);
  options.few_trials = true;
  return options;
}

TEST(Pieces, OfASmallBaseATangledOneTakesNothingAway) {
  const Scan smooth = shapes::bumpy_sphere(5);
  const Scan scan = shapes::joined(smooth, shapes::moved(tangled_ball(4, 1.5), {4, 0, 0}));
  const auto out = remesh(scan, quick_options(120, 3));
  ASSERT_TRUE(out.has_value());
  expect_healthy(*out);
  ASSERT_EQ(out->pieces.size(), 2u);
  EXPECT_EQ(out->pieces[0].fallback, "");
  EXPECT_EQ(out->pieces[0].base_vertices, 120u);
  EXPECT_TRUE(out->pieces[1].is_own_base) << out->pieces[1].fallback;
  EXPECT_LT(error_of(smooth, first_piece(*out)), kMostError);
  EXPECT_LT(testing::final_error(scan, *out), kMostError);
}

TEST(Pieces, AKeptOneIsTheSameAtAnyThreadCountAndInTheFile) {
  std::vector<Remesh> runs;
  for (const std::size_t threads : {1u, 2u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    auto out = remesh(ball_and_tangle(), quick_options(120, 3));
    ASSERT_TRUE(out.has_value());
    runs.push_back(std::move(*out));
  }
  EXPECT_EQ(runs[0].mesh.base_triangles, runs[1].mesh.base_triangles);
  EXPECT_EQ(runs[0].mesh.positions, runs[1].mesh.positions);
  ASSERT_EQ(runs[0].pieces.size(), 2u);
  EXPECT_TRUE(runs[0].pieces[1].is_own_base);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(runs[0].pieces[i].fallback, runs[1].pieces[i].fallback);
    EXPECT_EQ(runs[0].pieces[i].base_triangles, runs[1].pieces[i].base_triangles);
  }

  codec::EncodeOptions coding;
  coding.target_bytes = 4000;
  const auto encoded = codec::encode(runs[0].mesh, coding);
  ASSERT_TRUE(encoded.has_value()) << encoded.error().message;
  EXPECT_LE(encoded->bytes.size(), 4000u);
  const auto decoded = codec::decode(encoded->bytes);
  ASSERT_TRUE(decoded.has_value()) << decoded.error().message;
  const ManifoldFacts facts = manifold_facts(decoded->base_triangles, decoded->base_vertex_count);
  EXPECT_EQ(facts.defect, "");
  EXPECT_EQ(facts.pieces, 2u);
  EXPECT_EQ(facts.closed_pieces, 2u);
  EXPECT_EQ(facts.genus, 0);
  EXPECT_EQ(decoded->base_triangles.size(), runs[0].mesh.base_triangles.size());
  EXPECT_LT(error_of(testing::level_of(runs[0].mesh, 3), testing::level_of(*decoded, 3)), 0.01);
}

TEST(Pieces, HandlesBesideAHealthyOneStay) {
  const Scan smooth = shapes::bumpy_sphere(4);
  const Scan plate = scaled(shapes::split(shapes::plate(6), 1), 0.3);
  const Scan scan = shapes::joined(smooth, shapes::moved(plate, {3, 0, 0}));
  const auto out = remesh(scan, quick_options(150, 3));
  ASSERT_TRUE(out.has_value());
  expect_healthy(*out);
  ASSERT_EQ(out->pieces.size(), 2u);
  EXPECT_EQ(out->pieces[0].genus, 0);
  EXPECT_EQ(out->pieces[1].genus, 6);
  EXPECT_EQ(out->pieces[0].fallback, "");
  EXPECT_LT(testing::final_error(scan, *out), 5 * kMostError);
}

TEST(PieceSurfaces, OfShapesThatAreKnown) {
  const Scan flat = shapes::grid(4, 3), ball = shapes::sphere(4), corners = shapes::octahedron();
  const Scan tangle = tangled_ball(4, 1.5);
  Scan all = shapes::joined(flat, shapes::moved(ball, {20, 0, 0}));
  all = shapes::joined(all, shapes::moved(corners, {40, 0, 0}));
  all = shapes::joined(all, shapes::moved(tangle, {60, 0, 0}));
  const auto cleaned = clean(all, RepairPolicy::kSafe, 0);
  ASSERT_TRUE(cleaned.has_value());
  const auto surfaces = piece_surfaces(*cleaned);
  ASSERT_EQ(surfaces.size(), 4u);
  EXPECT_DOUBLE_EQ(surfaces[0].size, 12);
  EXPECT_EQ(surfaces[0].roughness, 0);
  EXPECT_NEAR(surfaces[1].size, 12, 1e-9);  // of the box; the area is 4 pi
  EXPECT_LT(surfaces[1].roughness, 0.01);
  EXPECT_NEAR(surfaces[2].size, 4 * std::sqrt(3), 1e-12);
  EXPECT_NEAR(surfaces[2].roughness, 2.0 / 3, 1e-12);
  EXPECT_GT(surfaces[3].roughness, 0.9);
  EXPECT_FALSE(surfaces[1].is_tangled());
  EXPECT_TRUE(surfaces[3].is_tangled());
}

TEST(KeptPieces, JoinedAreAsIfMadeTogether) {
  const Scan a = shapes::torus(4, 3), b = shapes::grid(2, 3);
  for (const int levels : {0, 1, 3}) {
    const auto parts = joined(*kept_as_it_is(a, levels), *kept_as_it_is(b, levels));
    const auto whole = kept_as_it_is(shapes::joined(a, b), levels);
    ASSERT_TRUE(parts.has_value());
    EXPECT_EQ(parts->mesh.base_triangles, whole->mesh.base_triangles);
    EXPECT_EQ(parts->mesh.base_vertex_count, whole->mesh.base_vertex_count);
    EXPECT_EQ(parts->mesh.positions, whole->mesh.positions);
    EXPECT_EQ(parts->kind, whole->kind);
    EXPECT_EQ(parts->folds, whole->folds);
    ASSERT_EQ(parts->bands.size(), whole->bands.size());
    for (std::size_t j = 0; j < parts->bands.size(); ++j)
      EXPECT_EQ(parts->bands[j].vertices, whole->bands[j].vertices);
  }
}

TEST(KeptPieces, ArePartedOrRefused) {
  const Scan a = shapes::torus(4, 3), b = shapes::octahedron();
  const Scan both = shapes::joined(a, b);
  const Parameterisation map = identity(both);
  const auto apart = part_kept(both, map, b.triangles.size());
  ASSERT_TRUE(apart.has_value());
  EXPECT_EQ(apart->scan.triangles, a.triangles);
  EXPECT_EQ(apart->kept.triangles, b.triangles);
  EXPECT_EQ(apart->kept.positions, b.positions);
  EXPECT_EQ(apart->map.base.triangles, a.triangles);
  for (const std::size_t triangles : {std::size_t{1}, std::size_t{9}, both.triangles.size() + 1}) {
    const auto wrong = part_kept(both, map, triangles);
    ASSERT_FALSE(wrong.has_value()) << triangles;
    EXPECT_EQ(wrong.error().code, ErrorCode::kBadInput);
  }
}

}  // namespace
}  // namespace nacre::remesh
