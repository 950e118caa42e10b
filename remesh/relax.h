// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "base/run_context.h"
#include "base/scan.h"
#include "remesh/base_domain.h"

namespace nacre::remesh {

struct RelaxOptions {
  int rounds = 8;  ///< each ends with a new stretch weighting
  int sweeps = 4;  ///< Gauss-Seidel sweeps in a round
};

/// Smooths the map across the borders of the base triangles: every interior scan vertex moves to
/// the weighted mean of its neighbours in a chart that has them all. Base corners stay where they
/// are in the domain, so the scan slides under them. Boundary vertices are spread by arc length.
/// Ends with untangle().
///
/// Returns  how many scan triangles lie upside down in the domain, for want of anything better.
///
/// Weights  mean-value, divided by the square root of the neighbour's area stretch after each
/// round. Ensures  the same result at any thread count. Source   [KhodakovskyEtAl2003],
/// [Floater2003], [YoshizawaEtAl2004]; README.md.
std::size_t relax(const Scan& scan, Parameterisation& parameterisation, const RelaxOptions& options,
                  const RunContext& context = {});

}  // namespace nacre::remesh
