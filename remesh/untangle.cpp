// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/untangle.h"

#include <algorithm>
#include <array>
#include <span>

#include "base/parallel.h"
#include "remesh/adjacency.h"
#include "remesh/chart.h"
#include "remesh/indices_where.h"
#include "remesh/tips.h"

namespace nacre::remesh {
namespace {

using Vec2 = Eigen::Vector2d;
/// Rings around a turned triangle that may move, attempt by attempt.
constexpr std::array<int, 6> kRings = {1, 2, 3, 4, 6, 9};
constexpr int kSweepsPerRing = 15;
/// No more moves than this for each vertex of the scan: what is tangled all over stays so.
constexpr std::size_t kMovesPerVertex = 20;

class Untangler {
 public:
  Untangler(const Scan& scan, Parameterisation& map)
      : scan_(scan),
        point_(map.point),
        atlas_(map.base),
        fixed_(held_vertices(scan, map)),
        neighbors_(
            side_neighbors(scan.triangles, static_cast<std::uint32_t>(scan.positions.size()))),
        face_of_(
            face_of_vertex(scan.triangles, static_cast<std::uint32_t>(scan.positions.size()))) {}

  std::size_t run() {
    std::vector<std::uint32_t> turned;
    for (std::uint32_t f = 0; f < scan_.triangles.size(); ++f)
      if (is_turned(f)) turned.push_back(f);
    for (const int rings : kRings) {
      if (turned.empty()) break;
      turned = attempt(turned, rings);
    }
    return turned.size();
  }

 private:
  [[nodiscard]] bool is_turned(std::uint32_t face) const {
    const Triangle& t = scan_.triangles[face];
    const auto area = atlas_.doubled_area({point_[t[0]], point_[t[1]], point_[t[2]]});
    return !area || *area < 0;
  }

  std::vector<std::uint32_t> attempt(const std::vector<std::uint32_t>& turned, int rings) {
    const std::vector<std::uint32_t> region = around(turned, rings);
    const int sweeps = static_cast<int>(
        std::min<std::size_t>(static_cast<std::size_t>(kSweepsPerRing * rings),
                              moves_left_ / std::max<std::size_t>(region.size(), 1)));
    moves_left_ -= static_cast<std::size_t>(sweeps) * region.size();
    const Rings rings_of = rings_around(region);
    const auto groups = groups_apart(region, rings_of);
    parallel_for_each_index(
        groups.size(),
        [&](std::size_t i) {
          std::vector<std::uint32_t> faces;
          for (int sweep = 0; sweep < sweeps; ++sweep)
            for (const std::uint32_t r : groups[i]) move(region[r], rings_of.of(r), faces);
        },
        1);
    std::vector<std::uint32_t> touched;
    for (const std::uint32_t v : region) {
      collect_star(scan_.triangles, neighbors_, v, face_of_[v], star_);
      touched.insert(touched.end(), star_.faces.begin(), star_.faces.end());
    }
    touched.insert(touched.end(), turned.begin(), turned.end());
    make_unique(touched);
    std::erase_if(touched, [&](std::uint32_t f) { return !is_turned(f); });
    return touched;
  }

  /// Inner vertices within so many rings of the triangles' corners, ascending.
  [[nodiscard]] std::vector<std::uint32_t> around(const std::vector<std::uint32_t>& triangles,
                                                  int rings) {
    std::vector<std::uint32_t> region;
    for (const std::uint32_t f : triangles)
      region.insert(region.end(), scan_.triangles[f].begin(), scan_.triangles[f].end());
    for (int ring = 1; ring < rings; ++ring) {
      make_unique(region);
      const std::size_t count = region.size();
      for (std::size_t i = 0; i < count; ++i) {
        collect_star(scan_.triangles, neighbors_, region[i], face_of_[region[i]], star_);
        region.insert(region.end(), star_.ring.begin(), star_.ring.end());
      }
    }
    make_unique(region);
    std::erase_if(region, [&](std::uint32_t v) {
      collect_star(scan_.triangles, neighbors_, v, face_of_[v], star_);
      return star_.boundary || fixed_[v];
    });
    return region;
  }

  /// The vertices around each of a region's, in compressed rows.
  struct Rings {
    std::vector<std::size_t> start = {0};
    std::vector<std::uint32_t> vertices;

    [[nodiscard]] std::span<const std::uint32_t> of(std::size_t r) const {
      return std::span(vertices).subspan(start[r], start[r + 1] - start[r]);
    }
  };
  [[nodiscard]] Rings rings_around(std::span<const std::uint32_t> region) {
    Rings rings;
    for (const std::uint32_t v : region) {
      collect_star(scan_.triangles, neighbors_, v, face_of_[v], star_);
      rings.vertices.insert(rings.vertices.end(), star_.ring.begin(), star_.ring.end());
      rings.start.push_back(rings.vertices.size());
    }
    return rings;
  }

  /// The region's connected parts, as places in it, ascending: what moves in one is not seen in
  /// another, so that they can be swept side by side as if one after the other.
  [[nodiscard]] static std::vector<std::vector<std::uint32_t>> groups_apart(
      std::span<const std::uint32_t> region, const Rings& rings) {
    std::vector<std::uint32_t> group(region.size(), kNone), open;
    std::uint32_t count = 0;
    for (std::uint32_t seed = 0; seed < region.size(); ++seed) {
      if (group[seed] != kNone) continue;
      group[seed] = count;
      open.assign(1, seed);
      while (!open.empty()) {
        const std::uint32_t r = open.back();
        open.pop_back();
        for (const std::uint32_t w : rings.of(r)) {
          const auto at = std::lower_bound(region.begin(), region.end(), w) - region.begin();
          const auto next = static_cast<std::uint32_t>(at);
          if (next == region.size() || region[next] != w || group[next] != kNone) continue;
          group[next] = count;
          open.push_back(next);
        }
      }
      ++count;
    }
    std::vector<std::vector<std::uint32_t>> groups(count);
    for (std::uint32_t r = 0; r < region.size(); ++r) groups[group[r]].push_back(r);
    return groups;
  }

  /// `faces` is room to work in.
  void move(std::uint32_t v, std::span<const std::uint32_t> ring,
            std::vector<std::uint32_t>& faces) {
    faces.assign(1, point_[v].face);
    for (const std::uint32_t w : ring) faces.push_back(point_[w].face);
    const auto chart = atlas_.common_chart(faces);
    if (!chart) return;
    Vec2 sum = Vec2::Zero();
    for (const std::uint32_t w : ring) sum += *chart->map(point_[w]);
    point_[v] = chart->unmap(sum / static_cast<double>(ring.size()));
  }

  const Scan& scan_;
  std::vector<DomainPoint>& point_;
  Atlas atlas_;
  std::vector<char> fixed_;
  std::size_t moves_left_ = kMovesPerVertex * point_.size();
  std::vector<Triangle> neighbors_;
  std::vector<std::uint32_t> face_of_;
  Star star_;
};

}  // namespace

std::size_t untangle(const Scan& scan, Parameterisation& parameterisation) {
  return Untangler(scan, parameterisation).run();
}

}  // namespace nacre::remesh
