// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/folds.h"

#include <utility>

#include "base/parallel.h"

namespace nacre::app {
namespace {

Vec3 face_normal(const Scan& mesh, const Triangle& t) {
  const Vec3& a = mesh.positions[t[0]];
  return cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a);
}

Vec3 unit(const Vec3& v) {
  const double length = norm(v);
  return length > 0 ? Vec3(v / length) : Vec3::Zero();
}

}  // namespace

FoldCheck::FoldCheck(metric::Surface surface, const Scan& oriented)
    : surface_(std::move(surface)), normals_(oriented.triangles.size()), origin_(oriented.origin) {
  parallel_for_each_index(normals_.size(), [&](std::size_t f) {
    normals_[f] = unit(face_normal(oriented, oriented.triangles[f]));
  });
}

Result<FoldCheck> FoldCheck::build(const Scan& oriented) {
  Result<metric::Surface> surface = metric::Surface::build(oriented);
  if (!surface) return surface.error();
  return FoldCheck(std::move(*surface), oriented);
}

FoldCheck::Outcome FoldCheck::check(const Scan& mesh) const {
  const Vec3 shift = mesh.origin - origin_;
  const auto normal_under = [&](const metric::Surface::Nearest& nearest) {
    return nearest.triangle == kNone ? Vec3(Vec3::Zero()) : normals_[nearest.triangle];
  };
  std::vector<Vec3> under_vertex(mesh.positions.size());
  parallel_for_each_index(under_vertex.size(), [&](std::size_t v) {
    under_vertex[v] = normal_under(surface_.nearest(mesh.positions[v] + shift));
  });
  const std::size_t count = mesh.triangles.size();
  Outcome out;
  out.folded.resize(count);
  out.distance.resize(count);
  std::vector<std::uint8_t> opposed(count);
  parallel_for_each_index(count, [&](std::size_t f) {
    const Triangle& t = mesh.triangles[f];
    const Vec3 centroid =
        (mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]) / 3 + shift;
    const metric::Surface::Nearest nearest = surface_.nearest(centroid);
    const Vec3 n = face_normal(mesh, t);
    const Vec3 corners = under_vertex[t[0]] + under_vertex[t[1]] + under_vertex[t[2]];
    out.distance[f] = nearest.distance;
    opposed[f] = dot(n, normal_under(nearest)) < 0;
    out.folded[f] = opposed[f] != 0 && dot(n, corners) < 0;
  });
  for (std::size_t f = 0; f < count; ++f) {
    out.folds += out.folded[f];
    out.opposed += opposed[f];
  }
  return out;
}

}  // namespace nacre::app
