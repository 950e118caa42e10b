// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "base/geometry.h"

namespace nacre {

/// A triangle soup as read from a file: nothing about it is promised but that every index is in
/// range and every coordinate finite. Positions are in model units, relative to `origin`: the
/// readers move far-away (geo-referenced) scans near zero so that no precision is lost later.
struct Scan {
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
  Vec3 origin = Vec3::Zero();
};

/// A triangle mesh to be written; same shape as a scan.
using TriangleMesh = Scan;

}  // namespace nacre
