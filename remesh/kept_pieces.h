// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "remesh/pierce.h"

/// Pieces that are their own base mesh: nothing is mapped, nothing is pierced.
namespace nacre::remesh {

/// The scan as its own base mesh: new vertices are the middles of edges, which is exact.
[[nodiscard]] Result<Pierced> kept_as_it_is(const Scan& scan, int levels);

/// The identity, for who wants to look at it.
[[nodiscard]] Parameterisation identity(const Scan& scan);

/// Two meshes of as many levels as one, the second one's base triangles and vertices last.
[[nodiscard]] Result<Pierced> joined(const Pierced& a, const Pierced& b);

/// What the last `triangles` base triangles, which are scan triangles too, are cut off from.
struct KeptApart {
  Scan scan, kept;
  Parameterisation map;  ///< of `scan`
};
/// Errors   kBadInput: these triangles are not the last of both, with vertices of their own.
[[nodiscard]] Result<KeptApart> part_kept(const Scan& scan, const Parameterisation& map,
                                          std::size_t triangles);

}  // namespace nacre::remesh
