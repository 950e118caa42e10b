// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "codec/best_targets.h"
#include "codec/geometry_coder.h"
#include "entropy/detail_coder.h"

/// The geometry as --profile best codes it: each integer chosen by what it costs and what it saves.
namespace nacre::codec {

/// One choice of everything that decides the size.
struct BestSettings {
  Steps steps;        ///< the base's grid, then the bands'; kNotCoded
  double lambda = 0;  ///< squared error on the finest mesh, summed, that one bit is worth
  int ratio_quarters = 0;
  const SurfaceWeights* weights = nullptr;  ///< needed with targets
  /// What each level aims at, errors counting as `weights` say; none: the mesh, vertex by vertex.
  const Targets* targets = nullptr;
};

/// Codes level by level, each band in the frames of the decoded coarser mesh. `gains` as in
/// Part::gain: the base, then the bands.
[[nodiscard]] Result<CodedGeometry> code_best(const Prepared& prepared,
                                              const BestSettings& settings,
                                              const std::vector<double>& gains);

}  // namespace nacre::codec
