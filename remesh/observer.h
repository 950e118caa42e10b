// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "base/scan.h"
#include "base/semi_regular_mesh.h"
#include "remesh/base_domain.h"

namespace nacre::remesh {

struct CleanScan;

/// How the vertices of a normal mesh stand to where the coder predicts them.
enum class DetailKind : std::uint8_t {
  kNormal = 0,    ///< straight above; base vertices, which are not predicted, count as such
  kBoundary = 1,  ///< on a boundary curve of the scan, off the line
  kVector = 2,    ///< aside: no hit of the line was acceptable
};

/// Told what a run of the remesher makes on its way: what the result is built from, not the trials
/// that were given up. All members are optional, cost nothing when empty, and are called one at a
/// time, in the order in which they stand here. The arguments live until the call returns.
struct Observer {
  /// Once, after cleaning.
  std::function<void(const CleanScan& cleaned)> cleaned;
  /// The base mesh that was chosen and the map of `scan` onto it: the cleaned scan, or a part of
  /// it, perhaps with more vertices. Once for each part that has a base mesh of its own.
  std::function<void(const Scan& scan, const Parameterisation& map)> base;
  /// Once, at the end: all levels (a coarser one is a prefix), and a DetailKind per vertex.
  std::function<void(const SemiRegularMesh& mesh, std::span<const std::uint8_t> kind)> normal_mesh;
};

}  // namespace nacre::remesh
