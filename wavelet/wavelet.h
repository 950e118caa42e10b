// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "base/semi_regular_mesh.h"

/// Semi-regular mesh ↔ base positions + detail bands. See README.md.
namespace nacre::wavelet {

enum class Transform : std::uint8_t {
  kButterfly = 0,  ///< unlifted modified butterfly: interpolating, the default
  kLoop = 1,       ///< Loop subdivision: coarse vertices move too; analysis solves a sparse system
};

/// Butterfly-predicted points of band `level` and their detail frames, from the positions of level
/// `level` (size topology.level(level).vertex_count).
///
/// Frame    normal: area-weighted normal, at the predicted point, of the level + 1 mesh made of
///          `coarse` and all predicted points; tangent2: along
///          the edge, made orthogonal to it; tangent1 = tangent2 × normal, across the edge.
/// Source   [Zorin1996] modified butterfly; boundary edges use the four-point rule: README.md.
[[nodiscard]] LevelPrediction predict(const Topology& topology, int level,
                                      std::span<const Vec3> coarse);

/// The same points and frames to the bit, in a third of the memory.
[[nodiscard]] PredictedLevel predict_level(const Topology& topology, int level,
                                           std::span<const Vec3> coarse);

/// The same to the bit, each point and frame when it is asked for: next to no memory, and more
/// time if all are. Keeps references to `topology` and `coarse`.
[[nodiscard]] PredictedLevel predict_at_need(const Topology& topology, int level,
                                             std::span<const Vec3> coarse);

/// Splits a semi-regular mesh into its base positions and one detail per inserted vertex.
///
/// Shapes   positions.size() == topology.vertex_count()
/// Units    model units; a detail is (normal, tangent 1, tangent 2) in the frame of its prediction.
/// Ensures  (1) synthesize(topology, *analyze(topology, p)) == p within 1e-12 of the extent
///          (2) if all of p lies in one plane, every detail has normal component 0 (to rounding)
/// Errors   kBadInput if sizes disagree or a coordinate is not finite; `where` is the vertex.
///          kNoConvergence if Loop's even rule cannot be inverted on this mesh.
[[nodiscard]] Result<Pyramid> analyze(const Topology& topology, std::span<const Vec3> positions,
                                      Transform transform = Transform::kButterfly);

/// Inverse of analyze(), for the first `levels` bands (all of pyramid.bands if -1): positions of
/// level `levels`. Decoder: only + - * / sqrt in a fixed order, so the result is bit-identical in
/// every build.
[[nodiscard]] Result<std::vector<Vec3>> synthesize(const Topology& topology, const Pyramid& pyramid,
                                                   Transform transform = Transform::kButterfly,
                                                   int levels = -1);

/// A band's details that are not zero, by increasing edge of the band's level.
struct SparseBand {
  std::vector<std::uint32_t> edges;
  std::vector<Vec3> details;
};

/// All vertices of the level that was predicted, once its details are added: to the bit as
/// Synthesizer::next_level() has them.
[[nodiscard]] std::vector<Vec3> with_details(PredictedLevel predicted, const SparseBand& band);

/// synthesize() level by level and from sparse bands, in place. Keeps a reference to `topology`.
class Synthesizer {
 public:
  Synthesizer(const Topology& topology, Transform transform);
  ~Synthesizer();
  Synthesizer(const Synthesizer&) = delete;
  Synthesizer& operator=(const Synthesizer&) = delete;

  /// From the positions of level `level` to those of the next; `positions` grows by the band.
  void next_level(int level, const SparseBand& band, std::vector<Vec3>& positions);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// All of it, for as many levels as there are bands, 0 .. topology.level_count().
///
/// Errors   kBadInput if there are too many bands or base positions, or a coordinate is not finite.
[[nodiscard]] Result<std::vector<Vec3>> synthesize(const Topology& topology,
                                                   std::vector<Vec3> base_positions,
                                                   std::span<const SparseBand> bands,
                                                   Transform transform = Transform::kButterfly);

/// Squared error on the finest mesh per unit of squared error in a band (E in [LVQ] eq. (4),
/// w_i = a_i E_i): entry 0 is the base, entry 1 + j band j.
struct Gains {
  std::vector<double> energy;
};

/// Gains on the regular lattice: E_k of k further synthesis levels, the same for every mesh.
[[nodiscard]] Gains regular_gains(int level_count, Transform transform = Transform::kButterfly);

/// Gains measured on this topology by refining a seeded random ±1 signal in each band.
[[nodiscard]] Gains measured_gains(const Topology& topology,
                                   Transform transform = Transform::kButterfly);

}  // namespace nacre::wavelet
