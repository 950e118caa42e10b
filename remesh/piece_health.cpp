// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/piece_health.h"

#include "base/parallel.h"
#include "remesh/adjacency.h"
#include "remesh/clean_steps.h"

namespace nacre::remesh {
namespace {

/// So many distances each way say how a piece came out.
constexpr std::size_t kLeastSamples = 16;

/// The connected component of each base triangle, and how many there are.
std::vector<std::uint32_t> components(const BaseMesh& base, std::uint32_t& count) {
  std::vector<std::uint32_t> component(base.triangles.size(), kNone), waiting;
  count = 0;
  for (std::uint32_t seed = 0; seed < component.size(); ++seed) {
    if (component[seed] != kNone) continue;
    component[seed] = count;
    waiting.assign(1, seed);
    while (!waiting.empty()) {
      const std::uint32_t f = waiting.back();
      waiting.pop_back();
      for (const std::uint32_t next : base.neighbors[f]) {
        if (next == kNone || component[next] != kNone) continue;
        component[next] = count;
        waiting.push_back(next);
      }
    }
    ++count;
  }
  return component;
}

struct Sample {
  std::uint32_t index, base_face;
};

/// Of `count` things on base triangles face_of(i), of which every step-th was measured: more for
/// components that have fewer than kLeastSamples.
template <class FaceOf>
std::vector<Sample> more_samples(const std::vector<std::uint32_t>& component,
                                 std::uint32_t components, std::size_t count, std::size_t step,
                                 const FaceOf& face_of) {
  std::vector<std::size_t> all(components, 0), measured(components, 0), seen(components, 0);
  for (std::size_t i = 0; i < count; ++i) ++all[component[face_of(i)]];
  for (std::size_t i = 0; i < count; i += step) ++measured[component[face_of(i)]];
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t face = face_of(i), c = component[face];
    if (measured[c] >= std::min(kLeastSamples, all[c])) continue;
    if (seen[c]++ % std::max<std::size_t>(1, all[c] / kLeastSamples) == 0 && i % step != 0)
      samples.push_back({static_cast<std::uint32_t>(i), face});
  }
  return samples;
}

double distance(const LineTree& tree, const Scan& to, const Vec3& p) {
  return (position_of(tree.nearest(p), to.triangles, to.positions) - p).norm();
}

}  // namespace

void Health::operator+=(const Health& o) {
  missed += o.missed;
  strayed += o.strayed;
  triangles += o.triangles;
  folds += o.folds;
  levels = std::max(levels, o.levels);
  is_finite = is_finite && o.is_finite;
}

double Distances::rms() const {
  double sum = 0;
  for (const double d : at) sum += d * d;
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(at.size(), 1)));
}

std::vector<Health> health_of(const Tried& tried, const Distances& missed,
                              const Distances& strayed) {
  const auto& point = tried.map.point;
  const auto& fine = tried.fine;
  std::vector<Health> health(tried.map.base.triangles.size());
  for (std::size_t f = 0; f < health.size(); ++f) {
    health[f].folds = tried.folds[f];
    health[f].levels = tried.levels;
    for (int level = 1; level <= tried.levels; ++level)
      health[f].triangles += std::size_t{1} << (2 * level);
  }
  const auto vertex_face = [&](std::size_t v) { return point[v].face; };
  const auto fine_face = [&](std::size_t t) {
    return static_cast<std::uint32_t>(t >> (2 * tried.levels));
  };
  for (std::size_t i = 0; i < missed.at.size(); ++i)
    health[vertex_face(i * missed.step)].missed.add(missed.at[i]);
  for (std::size_t i = 0; i < strayed.at.size(); ++i)
    health[fine_face(i * strayed.step)].strayed.add(strayed.at[i]);

  std::uint32_t count = 0;
  const std::vector<std::uint32_t> component = components(tried.map.base, count);
  if (count < 2) return health;
  const auto vertices = more_samples(component, count, point.size(), missed.step, vertex_face);
  const auto centroids =
      more_samples(component, count, fine.triangles.size(), strayed.step, fine_face);
  std::vector<double> at(vertices.size() + centroids.size());
  parallel_for_each_index(at.size(), [&](std::size_t i) {
    if (i < vertices.size()) {
      at[i] = tried.fine_tree.distance(tried.scan.positions[vertices[i].index]);
      return;
    }
    const Triangle& t = fine.triangles[centroids[i - vertices.size()].index];
    const Vec3 middle = (fine.positions[t[0]] + fine.positions[t[1]] + fine.positions[t[2]]) / 3;
    at[i] = distance(tried.tree, tried.scan, middle);
  });
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (i < vertices.size())
      health[vertices[i].base_face].missed.add(at[i]);
    else
      health[centroids[i - vertices.size()].base_face].strayed.add(at[i]);
  }
  return health;
}

std::vector<PieceSurface> piece_surfaces(const CleanScan& cleaned) {
  const auto& [positions, triangles, origin] = cleaned.scan;
  std::vector<PieceSurface> surfaces(cleaned.pieces.size());
  std::vector<double> length(surfaces.size(), 0);
  std::vector<Vec3> normal(triangles.size());
  for (std::size_t f = 0; f < triangles.size(); ++f) {
    const Triangle& t = triangles[f];
    normal[f] = (positions[t[1]] - positions[t[0]]).cross(positions[t[2]] - positions[t[0]]);
    surfaces[cleaned.piece[f]].size += normal[f].norm() / 2;
    normal[f].normalize();  // zero stays so
  }
  const auto neighbors = side_neighbors(triangles, static_cast<std::uint32_t>(positions.size()));
  for (std::uint32_t f = 0; f < triangles.size(); ++f) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t other = neighbors[f][k];
      if (other == kNone || other < f) continue;
      if (normal[f].isZero(0) || normal[other].isZero(0)) continue;
      const double side =
          (positions[triangles[f][(k + 1) % 3]] - positions[triangles[f][k]]).norm();
      surfaces[cleaned.piece[f]].roughness += side * (1 - normal[f].dot(normal[other]));
      length[cleaned.piece[f]] += side;
    }
  }
  const std::vector<double> extents = piece_extents(cleaned);
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    surfaces[i].size = std::min(surfaces[i].size, extents[i] * extents[i]);
    if (length[i] > 0) surfaces[i].roughness /= length[i];
  }
  return surfaces;
}

}  // namespace nacre::remesh
