// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "base/topology.h"

namespace nacre {

/// A base mesh split 1→4 `level_count` times, with a position for every vertex of the finest level.
///
/// Vertices are ordered by level (see Topology), so a coarser mesh is a prefix of `positions`.
/// Several components are several groups of base triangles. Positions are in model units, relative
/// to `origin`, which keeps geo-referenced coordinates exact.
struct SemiRegularMesh {
  std::vector<Triangle> base_triangles;
  std::uint32_t base_vertex_count = 0;
  int level_count = 0;
  std::vector<Vec3> positions;
  Vec3 origin = Vec3::Zero();
};

/// The wavelet coefficients of a semi-regular mesh: the base positions and one band per level.
struct Pyramid {
  std::vector<Vec3> base_positions;
  /// bands[j][i] is the detail (normal, tangent 1, tangent 2) of vertex level(j).vertex_count + i.
  std::vector<std::vector<Vec3>> bands;
};

/// What a coarse level says of the vertices that the next level adds: where they should be, and the
/// frame in which their detail is measured. Entry i belongs to the midpoint of edge i.
struct LevelPrediction {
  std::vector<Vec3> points;
  std::vector<Frame> frames;
};

/// Points and frames made when they are asked for.
struct MidpointsAtNeed {
  MidpointsAtNeed() = default;
  MidpointsAtNeed(const MidpointsAtNeed&) = delete;
  MidpointsAtNeed& operator=(const MidpointsAtNeed&) = delete;
  virtual ~MidpointsAtNeed() = default;
  [[nodiscard]] virtual Vec3 point(std::uint32_t edge) const = 0;
  [[nodiscard]] virtual Frame frame(std::uint32_t edge) const = 0;
};

/// The same with frames made when they are asked for: a frame is three times as large as a point.
/// Or with both made so, and no positions.
struct PredictedLevel {
  using FrameAt = Frame (*)(const LevelTopology& coarse, std::span<const Vec3> positions,
                            std::uint32_t edge);

  const LevelTopology* coarse = nullptr;
  std::vector<Vec3> positions;  ///< of level + 1: the coarse vertices, then the edges' midpoints
  FrameAt frame_at = nullptr;
  std::shared_ptr<const MidpointsAtNeed> at_need = nullptr;

  [[nodiscard]] std::size_t size() const { return coarse->edges.size(); }
  /// Both of the midpoint of edge e.
  [[nodiscard]] Vec3 point(std::size_t e) const {
    return at_need ? at_need->point(static_cast<std::uint32_t>(e))
                   : positions[coarse->vertex_count + e];
  }
  [[nodiscard]] Frame frame(std::size_t e) const {
    return at_need ? at_need->frame(static_cast<std::uint32_t>(e))
                   : frame_at(*coarse, positions, static_cast<std::uint32_t>(e));
  }
};

/// Predicts band `level` from the positions of level `level`. `wavelet/` provides them; `remesh/`
/// takes one, so that it pierces along exactly the normals in which the details are coded. The
/// topology and the coarse positions have to outlive what is returned.
using LevelPredictor =
    std::function<PredictedLevel(const Topology&, int level, std::span<const Vec3> coarse)>;

}  // namespace nacre
