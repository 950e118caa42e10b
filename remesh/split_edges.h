// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "remesh/remesh.h"

namespace nacre::remesh {

/// Splits edges longer than `longest` in the middle, each time all those that are the longest side
/// of every face they have, until none is left or `most_triangles` is passed (needles, which get
/// many more triangles than their area asks for; then there are at most twice as many). The surface
/// stays the same; what was one large or long triangle gets vertices inside, which simplification
/// and parameterisation need to see it.
///
/// Ensures  oriented manifolds stay so; kept vertices keep their ids; new faces know their piece.
/// Source   longest-edge bisection [Rivara1984].
void split_long_edges(CleanScan& cleaned, double longest, std::size_t most_triangles = SIZE_MAX);

/// The side of the equilateral triangles of which `count` would cover the scan, but at least a
/// thousandth of its extent; 0 for a scan without area.
[[nodiscard]] double side_for_count(const Scan& scan, double count);

/// Splits every inner edge whose two ends are on the boundary. A triangle between two boundary
/// edges would have no area where the boundary becomes one straight side of the base domain.
void split_chords(CleanScan& cleaned);

}  // namespace nacre::remesh
