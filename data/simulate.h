// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>

#include "base/result.h"
#include "base/scan.h"

/// A range scanner, its operator and the merging software, simulated. See README.md.
namespace nacre::data {

/// What is scanned: a signed distance bound, negative inside, in a ball around the origin.
struct Target {
  std::function<double(const Vec3&)> distance;
  double lipschitz = 1;
  double radius = 1;
};

/// Lengths are shares of Target::radius.
struct SimulationOptions {
  int turntable_views = 10;      ///< alternately from above and below; two more look down steeply
  int view_pixels = 500;         ///< range image width and height, 32 .. 4096; cost: its square
  int voxels = 270;              ///< merging grid cells per axis, 16 .. 512; cost: its cube
  std::size_t faces = 90'000;    ///< what the merged mesh is simplified to, > 100
  double depth_noise = 0.0016;   ///< standard deviation of a range value
  double registration = 0.0012;  ///< standard deviation of a view's position error, per axis
  double rotation_deg = 0.10;    ///< standard deviation of a view's turn, per axis
  int pinhole_rounds = 2;        ///< how often unseen voxels among seen ones are filled in
  int dark_spots = 6;            ///< patches of the surface that no view can see
  int dust = 6;                  ///< specks in the air, each seen by one view
  std::size_t smallest_island = 16;  ///< components with fewer faces are dropped
  double unit = 40;                  ///< the written length of one unit of the target (mm)
  std::uint64_t seed = 2006;
};

/// Scans `target` from all around, merges the range images, simplifies and jitters the mesh.
///
/// Ensures  the same options give the same scan at any thread count.
/// Errors   kBadInput for an option out of range or when no view sees anything.
[[nodiscard]] Result<Scan> simulate_scan(const Target& target,
                                         const SimulationOptions& options = {});

}  // namespace nacre::data
