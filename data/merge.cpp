// SPDX-License-Identifier: GPL-3.0-or-later
#include "data/merge.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <unordered_map>

#include "base/parallel.h"

namespace nacre::data {
namespace {

constexpr int kPinholeNeighbours = 10;  // of 26: across a flat edge of what was seen there are nine
constexpr double kBand = 2.5;           // voxels on each side of the surface that a view speaks for

struct Grid {
  int n = 0;  // corners per axis
  double step = 0, radius = 0;
  std::vector<float> distance, weight;

  [[nodiscard]] std::size_t at(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * n + y) * n + x;
  }
  [[nodiscard]] Vec3 point(std::size_t corner) const {
    const auto m = static_cast<std::size_t>(n);
    const std::size_t x = corner % m, y = corner / m % m, z = corner / (m * m);
    return Vec3(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)) * step -
           Vec3::Constant(radius);
  }
};

Grid integrate(std::span<const RangeView> views, double radius, int voxels) {
  Grid grid;
  grid.n = voxels + 1;
  grid.radius = radius;
  grid.step = 2 * radius / voxels;
  const auto count = static_cast<std::size_t>(grid.n) * grid.n * grid.n;
  grid.distance.assign(count, 0);
  grid.weight.assign(count, 0);
  const double band = kBand * grid.step;
  parallel_for_each_index(count, [&](std::size_t i) {
    const Vec3 p = grid.point(i);
    double sum = 0, weights = 0;
    for (const RangeView& view : views) {
      RangeView::Sample s{};
      if (!view.sample(p, s)) continue;
      const double d = (dot(p, view.toward) - s.height) * s.facing;
      if (!(std::abs(d) < band)) continue;
      const double w = s.facing * s.facing * (1 - 0.9 * std::abs(d) / band);
      sum += w * d;
      weights += w;
    }
    if (weights > 0) grid.distance[i] = static_cast<float>(sum / weights);
    grid.weight[i] = static_cast<float>(weights);
  });
  return grid;
}

/// Gives an unseen corner the mean of its neighbours when enough of them are seen.
void close_pinholes(Grid& grid) {
  const Grid before = grid;
  const auto n = static_cast<std::size_t>(grid.n);
  parallel_for_each_index(n * n * n, [&](std::size_t i) {
    const std::size_t x = i % n, y = i / n % n, z = i / (n * n);
    const auto inner = [&](std::size_t c) { return c > 0 && c + 1 < n; };
    if (before.weight[i] > 0 || !inner(x) || !inner(y) || !inner(z)) return;
    double sum = 0;
    int seen = 0;
    for (std::size_t k = 0; k < 27; ++k) {
      const std::size_t j = (z + k / 9 - 1) * n * n + (y + k / 3 % 3 - 1) * n + (x + k % 3 - 1);
      if (!(before.weight[j] > 0)) continue;
      sum += before.distance[j];
      ++seen;
    }
    if (seen < kPinholeNeighbours) return;
    grid.distance[i] = static_cast<float>(sum / seen);
    grid.weight[i] = 1e-3F;
  });
}

/// Marching tetrahedra: each cell is cut into the six tetrahedra around its main diagonal, which
/// agree between neighbours, so the surface is a manifold wherever it is closed.
class Extraction {
 public:
  explicit Extraction(const Grid& grid) : grid_(grid) {}

  Scan run() {
    static constexpr int kPaths[6][2] = {{1, 3}, {3, 2}, {2, 6}, {6, 4}, {4, 5}, {5, 1}};
    for (int z = 0; z + 1 < grid_.n; ++z)
      for (int y = 0; y + 1 < grid_.n; ++y)
        for (int x = 0; x + 1 < grid_.n; ++x) {
          std::array<std::size_t, 8> c{};
          for (int k = 0; k < 8; ++k)
            c[k] = grid_.at(x + (k & 1), y + ((k >> 1) & 1), z + (k >> 2));
          for (const auto& path : kPaths) tetrahedron({c[0], c[path[0]], c[path[1]], c[7]});
        }
    return std::move(scan_);
  }

 private:
  [[nodiscard]] bool inside(std::size_t corner) const { return grid_.distance[corner] < 0; }

  std::uint32_t crossing(std::size_t a, std::size_t b) {
    if (a > b) std::swap(a, b);
    // The seven edge directions of the cut differ in b - a, which is less than 2^40.
    const auto key = static_cast<std::uint64_t>(a) * 8 + direction(b - a);
    const auto [found, fresh] =
        ids_.try_emplace(key, static_cast<std::uint32_t>(scan_.positions.size()));
    if (fresh) {
      const double da = grid_.distance[a], db = grid_.distance[b];
      const double t = std::clamp(da / (da - db), 0.02, 0.98);  // no two crossings at one corner
      scan_.positions.push_back(grid_.point(a) * (1 - t) + grid_.point(b) * t);
    }
    return found->second;
  }

  [[nodiscard]] std::uint64_t direction(std::size_t difference) const {
    const auto n = static_cast<std::size_t>(grid_.n);
    return difference / (n * n) * 4 + difference / n % n * 2 + difference % n;
  }

  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, const Vec3& outward) {
    const auto& p = scan_.positions;
    if (dot(cross(p[b] - p[a], p[c] - p[a]), outward) < 0) std::swap(b, c);
    scan_.triangles.push_back({a, b, c});
  }

  void tetrahedron(const std::array<std::size_t, 4>& corner) {
    std::array<std::size_t, 4> in{}, out{};
    std::size_t ins = 0, outs = 0;
    for (const std::size_t c : corner) {
      if (!(grid_.weight[c] > 0)) return;  // not seen: the mesh stays open here
      if (inside(c))
        in[ins++] = c;
      else
        out[outs++] = c;
    }
    if (ins == 0 || outs == 0) return;
    Vec3 outward = Vec3::Zero();
    for (std::size_t i = 0; i < ins; ++i) outward -= grid_.point(in[i]) / static_cast<double>(ins);
    for (std::size_t i = 0; i < outs; ++i)
      outward += grid_.point(out[i]) / static_cast<double>(outs);
    if (ins == 2) {
      const std::uint32_t a = crossing(in[0], out[0]), b = crossing(in[0], out[1]),
                          c = crossing(in[1], out[1]), d = crossing(in[1], out[0]);
      triangle(a, b, c, outward);
      triangle(a, c, d, outward);
    } else {
      const std::size_t alone = ins == 1 ? in[0] : out[0];
      const auto& others = ins == 1 ? out : in;
      const std::uint32_t a = crossing(alone, others[0]), b = crossing(alone, others[1]),
                          c = crossing(alone, others[2]);
      triangle(a, b, c, outward);
    }
  }

  const Grid& grid_;
  Scan scan_;
  std::unordered_map<std::uint64_t, std::uint32_t> ids_;  // looked up only, never walked
};

/// The component of each vertex, named by its smallest vertex.
std::vector<std::uint32_t> components(const Scan& scan) {
  std::vector<std::uint32_t> parent(scan.positions.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const Triangle& t : scan.triangles) {
    for (int k = 1; k < 3; ++k) {
      const std::uint32_t a = root(t[0]), b = root(t[k]);
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  for (std::uint32_t v = 0; v < parent.size(); ++v) parent[v] = root(v);
  return parent;
}

std::vector<std::size_t> faces_of(const Scan& scan, const std::vector<std::uint32_t>& component) {
  std::vector<std::size_t> faces(scan.positions.size(), 0);
  for (const Triangle& t : scan.triangles) ++faces[component[t[0]]];
  return faces;
}

}  // namespace

Scan merge_views(std::span<const RangeView> views, const Target& target,
                 const SimulationOptions& options) {
  Grid grid = integrate(views, target.radius, options.voxels);
  for (int round = 0; round < options.pinhole_rounds; ++round) close_pinholes(grid);
  return Extraction(grid).run();
}

Scan drop_islands(const Scan& scan, std::size_t smallest_island) {
  const std::vector<std::uint32_t> component = components(scan);
  const std::vector<std::size_t> faces = faces_of(scan, component);
  std::vector<std::uint32_t> renamed(scan.positions.size(), kNone);
  Scan kept;
  kept.origin = scan.origin;
  for (Triangle t : scan.triangles) {
    if (faces[component[t[0]]] < smallest_island) continue;
    for (std::uint32_t& v : t) {
      if (renamed[v] == kNone) {
        renamed[v] = static_cast<std::uint32_t>(kept.positions.size());
        kept.positions.push_back(scan.positions[v]);
      }
      v = renamed[v];
    }
    kept.triangles.push_back(t);
  }
  return kept;
}

std::vector<std::size_t> component_sizes(const Scan& scan) {
  std::vector<std::size_t> sizes = faces_of(scan, components(scan));
  std::erase(sizes, 0U);
  std::sort(sizes.rbegin(), sizes.rend());
  return sizes;
}

}  // namespace nacre::data
