// SPDX-License-Identifier: GPL-3.0-or-later
//
// Read me first: after a split every triangle is either a middle one, with three new vertices, or
// cuts an old vertex off its parent. So a middle triangle's neighbours have an old vertex at their
// far corner, and all triangles around an old vertex have a middle one on their far side. From one
// middle triangle these two steps label a whole component, or meet a contradiction. A triangle is
// the middle one or one of its neighbours is: four seeds are all there is to try.
#include "app/semi_regular.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/topology.h"
#include "remesh/adjacency.h"

namespace nacre::app {
namespace {

constexpr int kMostLevels = 12;

using remesh::side_neighbors;

std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
  const auto [low, high] = std::minmax(a, b);
  return std::uint64_t{low} << 32 | high;
}

/// Triangles of one component over vertices 0 .. vertex_count - 1.
struct Component {
  std::uint32_t vertex_count = 0;
  std::vector<Triangle> triangles;
};

/// One split, undone. Vertices of `coarse` are renumbered; `kept` has their numbers in the finer
/// mesh, as has `middle`: the new vertex on side k of each coarse triangle.
struct Undone {
  Component coarse;
  std::vector<std::uint32_t> kept;
  std::vector<Triangle> middle;
};

class Labels {
 public:
  explicit Labels(const Component& fine)
      : fine_(fine),
        neighbors_(side_neighbors(fine.triangles, fine.vertex_count)),
        first_(fine.vertex_count + 1, 0),
        around_(3 * fine.triangles.size()) {
    for (const Triangle& t : fine.triangles)
      for (const std::uint32_t v : t) ++first_[v + 1];
    for (std::size_t v = 0; v + 1 < first_.size(); ++v) first_[v + 1] += first_[v];
    std::vector<std::uint32_t> fill(first_.begin(), first_.end() - 1);
    for (std::uint32_t f = 0; f < fine.triangles.size(); ++f)
      for (const std::uint32_t v : fine.triangles[f]) around_[fill[v]++] = f;
  }

  [[nodiscard]] std::array<std::uint32_t, 4> seeds() const {
    return {0, neighbors_[0][0], neighbors_[0][1], neighbors_[0][2]};
  }
  /// The split whose middle triangles include `seed`, if there is one.
  [[nodiscard]] std::optional<Undone> undo(std::uint32_t seed);

 private:
  enum class Vertex : std::uint8_t { kUnknown, kOld, kNew };

  [[nodiscard]] std::span<const std::uint32_t> around(std::uint32_t v) const {
    return std::span(around_).subspan(first_[v], first_[v + 1] - first_[v]);
  }
  /// Labels a middle triangle and what follows at once. False: a contradiction.
  bool take_as_middle(std::uint32_t f);
  bool mark(std::uint32_t v, Vertex as) {
    if (vertex_[v] == Vertex::kUnknown) {
      vertex_[v] = as;
      if (as == Vertex::kOld) waiting_.push_back(v);
    }
    return vertex_[v] == as;
  }
  [[nodiscard]] std::uint32_t apex(std::uint32_t f, std::uint32_t across) const {
    for (std::size_t k = 0; k < 3; ++k)
      if (neighbors_[f][k] == across) return fine_.triangles[f][(k + 2) % 3];
    return kNone;
  }
  [[nodiscard]] std::optional<Undone> build() const;

  const Component& fine_;
  std::vector<Triangle> neighbors_;
  std::vector<std::uint32_t> first_, around_;  // triangles around each vertex
  std::vector<std::uint32_t> parent_;          // per triangle: its middle one, itself if it is that
  std::vector<Vertex> vertex_;
  std::vector<std::uint32_t> waiting_;  // old vertices whose triangles are still to be looked at
};

bool Labels::take_as_middle(std::uint32_t f) {
  if (f == kNone) return false;
  if (parent_[f] == f) return true;
  if (parent_[f] != kNone) return false;
  parent_[f] = f;
  for (std::size_t k = 0; k < 3; ++k) {
    if (!mark(fine_.triangles[f][k], Vertex::kNew)) return false;
    const std::uint32_t corner = neighbors_[f][k];
    if (corner == kNone || parent_[corner] != kNone) return false;
    parent_[corner] = f;
    const std::uint32_t old = apex(corner, f);
    if (old == kNone || !mark(old, Vertex::kOld)) return false;
  }
  return true;
}

std::optional<Undone> Labels::undo(std::uint32_t seed) {
  if (fine_.triangles.size() % 4 != 0) return std::nullopt;
  parent_.assign(fine_.triangles.size(), kNone);
  vertex_.assign(fine_.vertex_count, Vertex::kUnknown);
  waiting_.clear();
  if (!take_as_middle(seed)) return std::nullopt;
  while (!waiting_.empty()) {
    const std::uint32_t v = waiting_.back();
    waiting_.pop_back();
    for (const std::uint32_t f : around(v)) {
      const Triangle& t = fine_.triangles[f];
      const std::size_t k = remesh::corner_of(t, v);
      if (!take_as_middle(neighbors_[f][(k + 1) % 3])) return std::nullopt;
    }
  }
  return build();
}

std::optional<Undone> Labels::build() const {
  Undone out;
  std::vector<std::uint32_t> coarse_id(fine_.vertex_count, kNone);
  for (std::uint32_t v = 0; v < fine_.vertex_count; ++v) {
    if (vertex_[v] == Vertex::kUnknown) return std::nullopt;
    if (vertex_[v] == Vertex::kNew) continue;
    coarse_id[v] = static_cast<std::uint32_t>(out.kept.size());
    out.kept.push_back(v);
  }
  std::unordered_map<std::uint64_t, std::uint32_t> middle_of;
  std::vector<char> used(fine_.vertex_count, 0);
  for (std::uint32_t f = 0; f < fine_.triangles.size(); ++f) {
    if (parent_[f] == kNone) return std::nullopt;
    if (parent_[f] != f) continue;
    const Triangle& m = fine_.triangles[f];
    Triangle corner{};  // corner k is cut off by the side that ends at the middle of side k
    for (std::size_t k = 0; k < 3; ++k) corner[k] = coarse_id[apex(neighbors_[f][(k + 2) % 3], f)];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [at, is_new] =
          middle_of.try_emplace(edge_key(corner[k], corner[(k + 1) % 3]), m[k]);
      if (at->second != m[k] || (is_new && std::exchange(used[m[k]], 1) != 0)) return std::nullopt;
    }
    out.coarse.triangles.push_back(corner);
    out.middle.push_back(m);
  }
  if (out.coarse.triangles.size() * 4 != fine_.triangles.size()) return std::nullopt;
  out.coarse.vertex_count = static_cast<std::uint32_t>(out.kept.size());
  // Two sides between the same two vertices make no base mesh that can be numbered.
  if (!Topology::build(out.coarse.triangles, out.coarse.vertex_count, 0)) return std::nullopt;
  return out;
}

/// The longest chain of splits that can be undone, finest first, at most `most`. Where a mesh is
/// regular all over (a torus) several choices are possible, each for a quarter of the next cost.
std::vector<Undone> undo_all(const Component& fine, int most) {
  std::vector<Undone> best;
  if (most == 0 || fine.triangles.size() < 4) return best;
  Labels labels(fine);
  for (const std::uint32_t seed : labels.seeds()) {
    std::optional<Undone> undone = labels.undo(seed);
    if (!undone) continue;
    std::vector<Undone> chain = undo_all(undone->coarse, most - 1);
    if (!best.empty() && chain.size() < best.size()) continue;
    chain.insert(chain.begin(), std::move(*undone));
    best = std::move(chain);
    if (static_cast<int>(best.size()) == most) break;
  }
  return best;
}

/// A component of the mesh, and the mesh's numbers of its vertices.
struct Part {
  Component component;
  std::vector<std::uint32_t> vertex;
  std::vector<Undone> chain;
};

std::vector<Part> components_of(std::span<const Triangle> triangles, std::uint32_t vertex_count) {
  const auto neighbors = side_neighbors(triangles, vertex_count);
  std::vector<char> seen(triangles.size(), 0);
  std::vector<std::uint32_t> local(vertex_count, kNone), stack;
  std::vector<Part> parts;
  for (std::uint32_t seed = 0; seed < triangles.size(); ++seed) {
    if (seen[seed]) continue;
    Part part;
    std::vector<std::uint32_t> faces;
    stack.assign(1, seed);
    seen[seed] = 1;
    while (!stack.empty()) {
      const std::uint32_t f = stack.back();
      stack.pop_back();
      faces.push_back(f);
      for (const std::uint32_t next : neighbors[f]) {
        if (next == kNone || seen[next]) continue;
        seen[next] = 1;
        stack.push_back(next);
      }
    }
    std::ranges::sort(faces);
    for (const std::uint32_t f : faces)
      for (const std::uint32_t v : triangles[f]) part.vertex.push_back(v);
    std::ranges::sort(part.vertex);
    part.vertex.erase(std::ranges::unique(part.vertex).begin(), part.vertex.end());
    for (std::uint32_t i = 0; i < part.vertex.size(); ++i) local[part.vertex[i]] = i;
    part.component.vertex_count = static_cast<std::uint32_t>(part.vertex.size());
    for (const std::uint32_t f : faces) {
      const Triangle& t = triangles[f];
      part.component.triangles.push_back({local[t[0]], local[t[1]], local[t[2]]});
    }
    parts.push_back(std::move(part));
  }
  return parts;
}

/// Which vertex of the mesh lies in the middle of each side, for all levels and parts, with the
/// base meshes of all parts.
struct Assembled {
  SemiRegularMesh mesh;             ///< without positions
  std::vector<std::uint32_t> base;  ///< the mesh's number of each base vertex
  std::vector<std::unordered_map<std::uint64_t, std::uint32_t>> middle;  ///< per level
};

Assembled assemble(const std::vector<Part>& parts, int levels) {
  Assembled out;
  out.mesh.level_count = levels;
  out.middle.resize(static_cast<std::size_t>(levels));
  for (const Part& part : parts) {
    std::vector<std::uint32_t> number = part.vertex;  // of the current level's vertices
    const Component* coarse = &part.component;
    for (int i = 0; i < levels; ++i) {
      const Undone& undone = part.chain[static_cast<std::size_t>(i)];
      std::vector<std::uint32_t> kept;
      for (const std::uint32_t v : undone.kept) kept.push_back(number[v]);
      auto& middle = out.middle[static_cast<std::size_t>(levels - 1 - i)];
      for (std::size_t f = 0; f < undone.middle.size(); ++f) {
        const Triangle& t = undone.coarse.triangles[f];
        for (std::size_t k = 0; k < 3; ++k)
          middle[edge_key(kept[t[k]], kept[t[(k + 1) % 3]])] = number[undone.middle[f][k]];
      }
      number = std::move(kept);
      coarse = &undone.coarse;
    }
    const auto offset = static_cast<std::uint32_t>(out.base.size());
    for (const Triangle& t : coarse->triangles)
      out.mesh.base_triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
    out.base.insert(out.base.end(), number.begin(), number.end());
  }
  out.mesh.base_vertex_count = static_cast<std::uint32_t>(out.base.size());
  return out;
}

Error refused(std::string what) { return {ErrorCode::kGeometryRefused, std::move(what)}; }

Result<SemiRegularMesh> place(const Scan& scan, Assembled assembled) {
  SemiRegularMesh mesh = std::move(assembled.mesh);
  const auto topology =
      Topology::build(mesh.base_triangles, mesh.base_vertex_count, mesh.level_count);
  if (!topology) return refused(topology.error().message);
  std::vector<std::uint32_t> number = std::move(assembled.base);
  for (int level = 0; level < mesh.level_count; ++level) {
    const auto& middle = assembled.middle[static_cast<std::size_t>(level)];
    for (const Edge& e : topology->level(level).edges)
      number.push_back(middle.at(edge_key(number[e.vertex[0]], number[e.vertex[1]])));
  }
  mesh.positions.reserve(number.size());
  for (const std::uint32_t v : number) mesh.positions.push_back(scan.positions[v]);
  mesh.origin = scan.origin;
  return mesh;
}

/// One vertex for all corners in the same place.
Scan welded(const Scan& scan) {
  Scan out;
  out.origin = scan.origin;
  std::map<std::array<double, 3>, std::uint32_t> ids;
  std::vector<std::uint32_t> id;
  for (const Vec3& p : scan.positions) {
    // Adding zero makes -0 and 0 the same place.
    const auto next = static_cast<std::uint32_t>(out.positions.size());
    const auto [at, is_new] = ids.try_emplace({p[0] + 0.0, p[1] + 0.0, p[2] + 0.0}, next);
    if (is_new) out.positions.push_back(p);
    id.push_back(at->second);
  }
  for (const Triangle& t : scan.triangles) out.triangles.push_back({id[t[0]], id[t[1]], id[t[2]]});
  return out;
}

Result<SemiRegularMesh> recognise(const Scan& scan, int levels) {
  const auto vertex_count = static_cast<std::uint32_t>(scan.positions.size());
  const auto manifold = Topology::build(scan.triangles, vertex_count, 0);
  if (!manifold)
    return refused(fmt::format("is no oriented manifold ({}), so no splits can have made it",
                               manifold.error().message));
  std::vector<Part> parts = components_of(scan.triangles, vertex_count);
  std::size_t fewest = kMostLevels;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    parts[i].chain = undo_all(parts[i].component, levels > 0 ? levels : kMostLevels);
    fewest = std::min(fewest, parts[i].chain.size());
    if (parts[i].chain.empty())
      return refused(fmt::format(
          "has no subdivision connectivity: piece {} of {} ({} triangles) is not made of 1 to 4 "
          "splits; leave --semi-regular out to have it remeshed",
          i, parts.size(), parts[i].component.triangles.size()));
  }
  if (static_cast<int>(fewest) < levels)
    return refused(
        fmt::format("was split {} times, {} were asked for; leave --levels out", fewest, levels));
  return place(scan, assemble(parts, static_cast<int>(fewest)));
}

}  // namespace

Result<SemiRegularMesh> recognise_subdivision(const Scan& mesh, int levels) {
  Result<SemiRegularMesh> found = recognise(mesh, levels);
  if (found) return found;
  const Scan once = welded(mesh);
  if (once.positions.size() == mesh.positions.size()) return found;
  Result<SemiRegularMesh> again = recognise(once, levels);
  return again ? std::move(again) : std::move(found);
}

}  // namespace nacre::app
