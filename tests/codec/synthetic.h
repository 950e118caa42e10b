// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "base/semi_regular_mesh.h"
#include "support/shapes.h"
#include "wavelet/wavelet.h"

namespace nacre::synthetic {

/// A small generator whose sequence is the same everywhere.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed * 2 + 1) {}
  std::uint32_t bits() {
    state_ = state_ * 6364136223846793005ull + 1442695040888963407ull;
    std::uint64_t x = state_ ^ (state_ >> 22);
    return static_cast<std::uint32_t>(x >> 29);
  }
  std::uint32_t below(std::uint32_t n) {
    return static_cast<std::uint32_t>((std::uint64_t{bits()} * n) >> 32);
  }
  double uniform() { return bits() * 0x1p-32; }
  double laplace() {
    const double u = uniform() - 0.5;
    return -std::copysign(1.0, u) * std::log(1 - 2 * std::abs(u) + 1e-12);
  }

 private:
  std::uint64_t state_;
};

/// A sphere-like base whose vertices have valence 3 to 11.
inline Scan irregular_base() {
  Scan scan = shapes::sphere(2);
  const std::vector<Triangle> faces = std::move(scan.triangles);
  scan.triangles.clear();
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto [a, b, c] = faces[f];
    if (f % 5 != 0) {
      scan.triangles.push_back(faces[f]);
      continue;
    }
    const auto m = static_cast<std::uint32_t>(scan.positions.size());
    const Vec3 centre = scan.positions[a] + scan.positions[b] + scan.positions[c];
    scan.positions.push_back(centre / centre.norm());
    scan.triangles.insert(scan.triangles.end(), {{a, b, m}, {b, c, m}, {c, a, m}});
  }
  return scan;
}

struct Shape {
  int levels = 4;
  std::uint64_t seed = 1;
  double amplitude = 0.03;   ///< of the details of band 0
  double decay = 0.3;        ///< of the amplitude from band to band
  double tangential = 0.01;  ///< share of details that are full vectors
};

/// What a remesher makes: a base subdivided by the butterfly with mostly normal details that are a
/// smooth function of place plus noise, strong in some places and weak in others.
inline SemiRegularMesh normal_mesh(const Scan& base, const Shape& shape = {}) {
  SemiRegularMesh mesh;
  mesh.base_triangles = base.triangles;
  mesh.base_vertex_count = static_cast<std::uint32_t>(base.positions.size());
  mesh.level_count = shape.levels;
  mesh.positions = base.positions;
  const Topology topology =
      *Topology::build(mesh.base_triangles, mesh.base_vertex_count, shape.levels);
  Random random(shape.seed);
  double amplitude = shape.amplitude;
  for (int j = 0; j < shape.levels; ++j, amplitude *= shape.decay) {
    const LevelPrediction prediction = wavelet::predict(topology, j, mesh.positions);
    for (std::size_t i = 0; i < prediction.points.size(); ++i) {
      const Vec3& p = prediction.points[i];
      const Frame& frame = prediction.frames[i];
      const double activity = 0.15 + std::pow(std::sin(2 * p[0] + 3 * p[1]), 4);
      const double wave = std::sin(7 * p[0]) * std::cos(5 * p[1] - 3 * p[2]);
      const double normal = amplitude * activity * (0.5 * wave + random.laplace());
      Vec3 detail = normal * frame.normal;
      if (random.uniform() < shape.tangential) {
        detail += amplitude * activity *
                  (random.laplace() * frame.tangent1 + random.laplace() * frame.tangent2);
      }
      mesh.positions.push_back(p + detail);
    }
  }
  return mesh;
}

}  // namespace nacre::synthetic
