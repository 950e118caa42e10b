// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>

/// Points, triangles, and the few vector operations whose evaluation order is part of the format.
namespace nacre {

using Vec3 = Eigen::Vector3d;
using Triangle = std::array<std::uint32_t, 3>;

/// "No vertex / edge / face here."
inline constexpr std::uint32_t kNone = 0xFFFFFFFFu;

// The decoder's positions are bit-identical in every build because every sum below has one stated
// order; Eigen's own reductions do not promise theirs.

/// (a.x b.x + a.y b.y) + a.z b.z
inline double dot(const Vec3& a, const Vec3& b) {
  return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}

inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline double norm(const Vec3& a) { return std::sqrt(dot(a, a)); }

/// Orthonormal frame of a predicted point; a detail is (normal, tangent1, tangent2) in it.
struct Frame {
  Vec3 normal;
  Vec3 tangent1;
  Vec3 tangent2;
};

/// A vector's components in a frame.
inline Vec3 to_frame(const Frame& frame, const Vec3& vector) {
  return {dot(frame.normal, vector), dot(frame.tangent1, vector), dot(frame.tangent2, vector)};
}

}  // namespace nacre
