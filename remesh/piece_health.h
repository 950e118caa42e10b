// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "remesh/mesh_tree.h"
#include "remesh/pierce.h"
#include "remesh/remesh.h"

namespace nacre::remesh {

/// Distances, as far as they are asked for again.
struct Tally {
  double squared = 0, farthest = 0;
  std::size_t count = 0;

  void add(double distance) {
    squared += distance * distance;
    farthest = std::max(farthest, distance);
    ++count;
  }
  void operator+=(const Tally& o) {
    squared += o.squared;
    farthest = std::max(farthest, o.farthest);
    count += o.count;
  }
  [[nodiscard]] double rms() const {
    return count > 0 ? std::sqrt(squared / static_cast<double>(count)) : 0;
  }
};

/// How the trial mesh of a base came out, over one base triangle or over several.
struct Health {
  Tally missed;                          ///< of the scan's vertices from the mesh
  Tally strayed;                         ///< of the mesh from the scan
  std::size_t triangles = 0, folds = 0;  ///< of all levels but the base
  int levels = 0;                        ///< of the trial mesh
  bool is_finite = true;

  void operator+=(const Health& o);
  [[nodiscard]] double error() const { return std::max(missed.rms(), strayed.rms()); }
};

/// A mesh that was tried, and both surfaces for distances.
struct Tried {
  const Scan& scan;
  const LineTree& tree;
  const Parameterisation& map;
  const Scan& fine;  ///< the finest level's triangles, those of each base triangle together
  const MeshTree& fine_tree;
  int levels;
  const std::vector<std::uint32_t>& folds;  ///< per base triangle, of all levels
};

/// Distances from every so-manyth vertex.
struct Distances {
  std::size_t step = 1;
  std::vector<double> at;  ///< of vertex i * step

  [[nodiscard]] double rms() const;
};

/// Per base triangle. What `missed` (from the scan's vertices) and `strayed` (from the fine
/// triangles' centroids) have too few of for a piece is measured as well.
[[nodiscard]] std::vector<Health> health_of(const Tried& tried, const Distances& missed,
                                            const Distances& strayed);

/// What a piece of the scan is like before anything is done to it.
struct PieceSurface {
  double size = 0;  ///< its area, but no more than its extent squared: a ball has about as much
  /// Mean of 1 - cos of the angle between neighbouring triangles, over the length of their edges:
  /// 0 is flat, 1 is as if normals were drawn at random.
  double roughness = 0;

  /// Its triangles tell nothing of a surface that fewer of them could follow.
  [[nodiscard]] bool is_tangled() const { return roughness > kTangled; }
  /// Balls with noise of 1.5, 1, 0.7, 0.5 and 0.3 edges have 1.07, 0.87, 0.58, 0.32 and 0.11; scans
  /// up to 0.07, a drill's thread 0.32.
  static constexpr double kTangled = 0.5;
};

/// Per piece.
[[nodiscard]] std::vector<PieceSurface> piece_surfaces(const CleanScan& cleaned);

}  // namespace nacre::remesh
