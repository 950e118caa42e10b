// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "base/run_context.h"
#include "base/semi_regular_mesh.h"
#include "remesh/base_domain.h"
#include "remesh/piece_health.h"
#include "remesh/pierce.h"

namespace nacre::remesh {

/// A semi-regular mesh's error falls with this power of its base's size: 8 dB a level on healthy
/// ones.
inline constexpr double kErrorPerSize = 0.66;

/// How many vertices a base mesh shall have: `vertices`, or where that is 0 as many as
/// SimplifyOptions::rms_error asks for, from `least` to `most` (0: no bound). A trial that ends
/// with more than `useful` (0: no bound) is given up at once.
struct BaseSize {
  int vertices = 0, least = 0, most = 0, useful = 0;
  /// Half the settings, one repair; so it is anyway from 2,000 vertices on.
  bool few_trials = false;
  /// One setting and no repair.
  bool one_trial = false;
};

struct BaseChoice {
  Parameterisation map;
  /// Per base triangle, of the trial that was chosen: on the proxy, where the scan itself was not
  /// looked at.
  std::vector<Health> health;
  std::shared_ptr<const LineTree> tree;  ///< of the scan, which it refers to
};

/// Simplifies with several settings, relaxes and pierces each to a low level, and returns the map
/// whose normal mesh is closest to the scan, both ways, for its number of base vertices. No setting
/// is best everywhere, and one bad base edge costs more than all the settings together.
///
/// `levels` is what the mesh will have, 0 when that follows from the base: trials go no further.
/// Errors   kCancelled; kNoConvergence: no trial was useful.
[[nodiscard]] Result<BaseChoice> choose_base(const Scan& scan, const BaseSize& size, int levels,
                                             const LevelPredictor& predict,
                                             const RunContext& context = {});

}  // namespace nacre::remesh
