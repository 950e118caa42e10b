// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "app/goal_search.h"
#include "app/remesh_stage.h"

/// The mesh and the file for a goal: what for_size() proposes, and others where it does not do.
namespace nacre::app {

/// Settings for the first mesh to try: what the user asks for, or what the goal does.
[[nodiscard]] RemeshSettings first_settings(const EncodeCommand& command, const InputFacts& input);

/// How near the scan a simplified mesh without levels would be, PSNR in dB, where the goal is a
/// size and such a mesh may serve it; none: nobody knows. It asks for nothing of what is made of
/// the scan, so that it may be found beside the remeshing.
[[nodiscard]] std::optional<double> early_simplified_psnr(const EncodeCommand& command,
                                                          const Prepared& prepared,
                                                          const Reference& reference,
                                                          Console& console);

/// Codes the mesh that `prepared` has. If the user has set nothing about the mesh, and the goal
/// cannot be reached with this one, others are tried and `prepared` gets the one that was taken:
///   - the base mesh alone is too large: smaller and smaller ones;
///   - a shape of flats and creases: a simplified mesh without levels;
///   - too coarse for the goal: one of more base vertices and triangles;
///   - too near the scan for any semi-regular mesh, or so large a file that it may not pay: the
///     scan's own triangles, as a base mesh without levels.
/// `simplified_psnr` is what early_simplified_psnr() says, or none: found when it is asked for.
///
/// Errors   kGoalUnreachable with the nearest that can be had and how; others as code_for_goal().
[[nodiscard]] Result<Coded> code_scan(const EncodeCommand& command, Prepared& prepared,
                                      const Reference& reference,
                                      std::optional<double> simplified_psnr, StageClock& clock,
                                      Console& console);

}  // namespace nacre::app
