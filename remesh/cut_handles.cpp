// SPDX-License-Identifier: GPL-3.0-or-later
//
// A handle shows as a loop that does not part the surface. A tree of shortest paths and, among the
// edges that it leaves, a tree over the faces leave 2 genus edges over; each closes a loop through
// the first tree, and no set of these loops parts the surface [EricksonWhittlesey2005]. The tree
// over the faces takes the edges with long loops first, so that short ones are left, and tiny
// handles come with loops that are not much longer than the way around or through them
// [GuskovWood2001]. Such a loop is cut along and both sides are closed.
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <queue>

#include "remesh/adjacency.h"
#include "remesh/fill_loops.h"
#include "remesh/side_groups.h"

namespace nacre::remesh {
namespace {

/// A tiny handle has a loop of at most so many edges and at most this share of its piece's extent.
constexpr std::size_t kMostEdges = 48;
constexpr double kHandle = 0.01;
/// Handles show by loops up to this many times as large, from which theirs are found.
constexpr double kSearched = 5;
/// A loop of some extent is hardly longer than this many times it.
constexpr double kLengthPerExtent = 4;
constexpr int kMostRounds = 16;

constexpr double kLong = std::numeric_limits<double>::infinity();

using Loop = std::vector<std::uint32_t>;  // vertices in order

double extent_of(const Scan& scan, const Loop& loop) {
  Box box;
  for (const std::uint32_t v : loop) box.add(scan.positions[v]);
  return box.extent();
}

/// A surface to look for handles in, with what counts as short in each of its pieces.
struct Searched {
  const Scan& scan;
  const std::vector<std::uint32_t>& piece;
  const std::vector<std::uint32_t>& partner;
  const std::vector<double>& longest;  // per piece
};

class HandleFinder {
 public:
  /// Paths start at `root`, and at the lowest vertex of other pieces.
  HandleFinder(const Searched& searched, std::uint32_t root)
      : scan_(searched.scan),
        piece_(searched.piece),
        partner_(searched.partner),
        longest_(searched.longest),
        root_(root) {}

  /// Loops that do not part the surface, not even together, shortest first.
  std::vector<Loop> loops() {
    grow_paths();
    std::vector<std::pair<double, std::uint32_t>> found = edges_left();
    std::sort(found.begin(), found.end());
    std::vector<Loop> loops;
    for (const auto& [length, side] : found) {
      Loop loop = loop_of(side);
      if (loop.size() >= 3) loops.push_back(std::move(loop));
    }
    return loops;
  }

 private:
  [[nodiscard]] std::uint32_t start(std::uint32_t s) const { return scan_.triangles[s / 3][s % 3]; }
  [[nodiscard]] std::uint32_t end(std::uint32_t s) const {
    return scan_.triangles[s / 3][(s % 3 + 1) % 3];
  }
  [[nodiscard]] double length(std::uint32_t s) const {
    return (scan_.positions[end(s)] - scan_.positions[start(s)]).norm();
  }

  /// Shortest paths from one vertex of every piece: previous_ is the side that leads to a vertex,
  /// either way along it.
  void grow_paths() {
    const std::size_t n = scan_.positions.size();
    std::vector<std::uint32_t> first(n + 1, 0), around(partner_.size());
    for (const Triangle& t : scan_.triangles)
      for (const std::uint32_t v : t) ++first[v + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<std::uint32_t> fill(first.begin(), first.end() - 1);
    for (std::uint32_t c = 0; c < around.size(); ++c) around[fill[start(c)]++] = c;

    distance_.assign(n, kLong);
    parent_.assign(n, kNone);
    parent_side_.assign(n, kNone);
    using Entry = std::pair<double, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t root = i == 0 ? root_ : (i == root_ ? 0 : i);
      if (distance_[root] < kLong) continue;
      distance_[root] = 0;
      queue.emplace(0.0, root);
      while (!queue.empty()) {
        const auto [d, v] = queue.top();
        queue.pop();
        if (d > distance_[v]) continue;
        for (std::uint32_t k = first[v]; k < first[v + 1]; ++k) {
          const std::uint32_t c = around[k];
          // The two sides of the face at this corner.
          for (const std::uint32_t s : {c, c - c % 3 + (c % 3 + 2) % 3}) {
            const std::uint32_t w = start(s) == v ? end(s) : start(s);
            const double further = d + length(s);
            if (further >= distance_[w]) continue;
            distance_[w] = further;
            parent_[w] = v;
            parent_side_[w] = s;
            queue.emplace(further, w);
          }
        }
      }
    }
  }

  [[nodiscard]] bool in_paths(std::uint32_t side) const {
    const auto is = [&](std::uint32_t v) {
      const std::uint32_t s = parent_side_[v];
      return s != kNone && (s == side || s == partner_[side]);
    };
    return is(start(side)) || is(end(side));
  }

  /// Length of the loop that a side closes; kLong if it is beyond what is looked for.
  [[nodiscard]] double loop_length(std::uint32_t side) const {
    const double most = longest_[piece_[side / 3]];
    std::uint32_t u = start(side), v = end(side);
    const double from = distance_[u] + distance_[v] + length(side);
    for (std::size_t steps = 0; u != v; ++steps) {
      std::uint32_t& farther = distance_[u] > distance_[v] ? u : v;
      if (steps == kMostEdges || parent_[farther] == kNone) return kLong;
      farther = parent_[farther];
      if (from - distance_[u] - distance_[v] > most) return kLong;
    }
    return from - 2 * distance_[u];
  }

  [[nodiscard]] Loop loop_of(std::uint32_t side) const {
    Loop down = {start(side)}, up = {end(side)};
    while (down.back() != up.back()) {
      auto& farther = distance_[down.back()] > distance_[up.back()] ? down : up;
      farther.push_back(parent_[farther.back()]);
    }
    down.pop_back();
    down.insert(down.end(), up.rbegin(), up.rend());
    return down;
  }

  /// Sides that neither tree takes and that close a short loop. Boundary loops count as faces.
  std::vector<std::pair<double, std::uint32_t>> edges_left() {
    const auto rims = boundary_loops(partner_);
    std::vector<std::uint32_t> rim(partner_.size(), kNone);
    for (std::uint32_t i = 0; i < rims.size(); ++i)
      for (const std::uint32_t s : rims[i]) rim[s] = i;
    const auto faces = static_cast<std::uint32_t>(scan_.triangles.size());
    std::vector<std::uint32_t> tree(faces + rims.size());
    std::iota(tree.begin(), tree.end(), 0u);
    const auto root = [&](std::uint32_t f) {
      while (tree[f] != f) f = tree[f] = tree[tree[f]];
      return f;
    };
    const auto join = [&](std::uint32_t s) {
      const std::uint32_t a = root(s / 3),
                          b = root(partner_[s] == kNone ? faces + rim[s] : partner_[s] / 3);
      tree[a] = b;
      return a != b;
    };
    std::vector<std::pair<double, std::uint32_t>> near, left;
    for (std::uint32_t s = 0; s < partner_.size(); ++s) {
      if ((partner_[s] != kNone && partner_[s] < s) || in_paths(s)) continue;
      const double loop = loop_length(s);
      if (loop < kLong)
        near.emplace_back(loop, s);
      else
        join(s);
    }
    std::sort(near.begin(), near.end(), std::greater<>());
    for (const auto& [loop, s] : near)
      if (!join(s)) left.emplace_back(loop, s);
    return left;
  }

  const Scan& scan_;
  const std::vector<std::uint32_t>& piece_;
  const std::vector<std::uint32_t>& partner_;
  const std::vector<double>& longest_;
  std::uint32_t root_;
  std::vector<double> distance_;                     // per vertex, from its piece's root
  std::vector<std::uint32_t> parent_, parent_side_;  // per vertex
};

/// Gives the right side of a loop vertices of its own. The loop's sides on the left and on the
/// right, in the order of their faces, become `rims`.
void cut_along(Scan& scan, const std::vector<std::uint32_t>& partner,
               const std::vector<std::uint32_t>& loop, const std::vector<std::uint32_t>& corner_at,
               std::vector<std::vector<std::uint32_t>>& rims) {
  const std::size_t n = loop.size();
  // Side of a left face that runs from loop vertex i to the next: found by turning about vertex i.
  std::vector<std::uint32_t> left(n);
  for (std::size_t i = 0; i < n; ++i) {
    std::uint32_t side = corner_at[loop[i]];  // a side that starts at the vertex
    while (scan.triangles[side / 3][(side % 3 + 1) % 3] != loop[(i + 1) % n])
      side = partner[side - side % 3 + (side % 3 + 2) % 3];
    left[i] = side;
  }
  std::vector<std::uint32_t> right(n);
  for (std::size_t i = 0; i < n; ++i) right[i] = partner[left[i]];
  std::vector<std::pair<std::uint32_t, std::uint32_t>> renamed;  // corners of right faces
  for (std::size_t i = 0; i < n; ++i) {
    const auto copy = static_cast<std::uint32_t>(scan.positions.size());
    scan.positions.push_back(Vec3(scan.positions[loop[i]]));
    // From the right face of the side that leaves, round to that of the side that arrives.
    std::uint32_t side = right[i];  // ends at the vertex
    while (true) {
      renamed.emplace_back(side - side % 3 + (side % 3 + 1) % 3, copy);
      const std::uint32_t next = side - side % 3 + (side % 3 + 1) % 3;  // starts at the vertex
      if (next == right[(i + n - 1) % n]) break;
      side = partner[next];
    }
  }
  for (const auto& [corner, copy] : renamed) scan.triangles[corner / 3][corner % 3] = copy;
  rims.push_back(left);
  std::reverse(right.begin(), right.end());
  rims.push_back(right);
}

/// The part of a surface around a loop, as a surface of its own.
struct Patch {
  Scan scan;
  std::vector<std::uint32_t> piece, partner;
  std::vector<std::uint32_t> vertex;  // of the whole, for each of the patch
};

Patch patch_around(const Searched& whole, const Loop& loop, double radius,
                   const std::vector<std::uint32_t>& corner_at) {
  const Vec3 centre = whole.scan.positions[loop[0]];
  const auto inside = [&](std::uint32_t f) {
    for (const std::uint32_t v : whole.scan.triangles[f])
      if ((whole.scan.positions[v] - centre).norm() > radius) return false;
    return true;
  };
  std::map<std::uint32_t, std::uint32_t> id;  // of each face
  std::vector<std::uint32_t> faces;
  const auto enter = [&](std::uint32_t f) {
    if (inside(f) && id.emplace(f, static_cast<std::uint32_t>(faces.size())).second)
      faces.push_back(f);
  };
  for (const std::uint32_t v : loop) enter(corner_at[v] / 3);
  for (std::size_t head = 0; head < faces.size(); ++head)
    for (std::uint32_t s = 3 * faces[head]; s < 3 * faces[head] + 3; ++s)
      if (whole.partner[s] != kNone) enter(whole.partner[s] / 3);

  Patch patch;
  patch.piece.assign(faces.size(), 0);
  patch.scan.triangles.assign(faces.size(), Triangle{kNone, kNone, kNone});
  for (const std::uint32_t f : faces) {
    for (std::uint32_t s = 3 * f; s < 3 * f + 3; ++s) {
      const std::uint32_t other = whole.partner[s];
      const auto it = other == kNone ? id.end() : id.find(other / 3);
      patch.partner.push_back(it == id.end() ? kNone : 3 * it->second + other % 3);
    }
  }
  // Every fan its own vertex, so that the patch is a manifold even where it touches itself.
  for (std::uint32_t c = 0; c < patch.partner.size(); ++c) {
    if (patch.scan.triangles[c / 3][c % 3] != kNone) continue;
    const std::uint32_t v = whole.scan.triangles[faces[c / 3]][c % 3];
    const auto fresh = static_cast<std::uint32_t>(patch.vertex.size());
    patch.vertex.push_back(v);
    patch.scan.positions.push_back(whole.scan.positions[v]);
    std::uint32_t at = c;  // back to the first face of the fan, then along it
    while (patch.partner[at] != kNone) {
      const std::uint32_t back = patch.partner[at];
      at = back - back % 3 + (back % 3 + 1) % 3;
      if (at == c) break;
    }
    for (std::uint32_t first = at;;) {
      patch.scan.triangles[at / 3][at % 3] = fresh;
      const std::uint32_t on = patch.partner[at - at % 3 + (at % 3 + 2) % 3];
      if (on == kNone || on == first) break;
      at = on;
    }
  }
  return patch;
}

/// The loops of one round.
class LoopChooser {
 public:
  explicit LoopChooser(const CleanScan& cleaned)
      : scan_(cleaned.scan),
        piece_(cleaned.piece),
        partner_(side_partners(scan_.triangles, scan_.positions.size())),
        limit_(piece_extents(cleaned)),
        corner_at_(scan_.positions.size(), kNone),
        taken_(scan_.positions.size(), 0) {
    for (double& limit : limit_) {
      limit *= kHandle;
      longest_.push_back(kSearched * kLengthPerExtent * limit);
    }
    for (std::uint32_t c = 0; c < partner_.size(); ++c) {
      corner_at_[scan_.triangles[c / 3][c % 3]] = c;
      if (partner_[c] != kNone) continue;
      taken_[scan_.triangles[c / 3][c % 3]] = taken_[scan_.triangles[c / 3][(c % 3 + 1) % 3]] = 1;
    }
  }

  /// Loops with no vertex in common, and none on the boundary, that do not part the surface, not
  /// even together.
  std::vector<Loop> run() {
    const Searched whole{scan_, piece_, partner_, longest_};
    std::vector<Loop> chosen, wide;
    for (Loop& loop : HandleFinder(whole, 0).loops()) {
      if (extent_of(scan_, loop) > limit_of(loop)) {
        wide.push_back(std::move(loop));
      } else if (free(loop)) {
        take(loop);
        chosen.push_back(std::move(loop));
      }
    }
    // A wide loop may belong to a handle with a narrow one across it, which paths from the wide
    // one's own vertices find. Whatever else is nearby waits for the next round, as the two might
    // be loops of one handle and part the surface together.
    for (const Loop& loop : wide) {
      const Patch patch = patch_around(whole, loop, kSearched * limit_of(loop), corner_at_);
      if (!free(patch.vertex)) continue;
      Loop narrow = narrowest_in(patch, loop, limit_of(loop));
      if (narrow.empty()) continue;
      take(patch.vertex);
      chosen.push_back(std::move(narrow));
    }
    return chosen;
  }

  [[nodiscard]] const std::vector<std::uint32_t>& partner() const { return partner_; }
  [[nodiscard]] const std::vector<std::uint32_t>& corner_at() const { return corner_at_; }

 private:
  [[nodiscard]] double limit_of(const Loop& loop) const {
    return limit_[piece_[corner_at_[loop[0]] / 3]];
  }
  [[nodiscard]] bool free(const std::vector<std::uint32_t>& vertices) const {
    return std::none_of(vertices.begin(), vertices.end(),
                        [&](std::uint32_t v) { return taken_[v] != 0; });
  }
  void take(const std::vector<std::uint32_t>& vertices) {
    for (const std::uint32_t v : vertices) taken_[v] = 1;
  }

  /// As vertices of the whole; empty if there is none within the limit.
  static Loop narrowest_in(const Patch& patch, const Loop& wide, double limit) {
    const std::vector<double> longest = {kLengthPerExtent * limit};
    const Searched searched{patch.scan, patch.piece, patch.partner, longest};
    std::vector<char> rim(patch.vertex.size(), 0);
    for (std::uint32_t s = 0; s < patch.partner.size(); ++s) {
      if (patch.partner[s] != kNone) continue;
      const Triangle& t = patch.scan.triangles[s / 3];
      rim[t[s % 3]] = rim[t[(s % 3 + 1) % 3]] = 1;
    }
    Loop best;
    double least = limit;
    for (std::uint32_t v = 0; v < patch.vertex.size(); ++v) {
      if (std::find(wide.begin(), wide.end(), patch.vertex[v]) == wide.end()) continue;
      for (const Loop& loop : HandleFinder(searched, v).loops()) {
        const double extent = extent_of(patch.scan, loop);
        if (extent >= least ||
            std::any_of(loop.begin(), loop.end(), [&](std::uint32_t w) { return rim[w] != 0; }))
          continue;
        least = extent;
        best = loop;
      }
    }
    for (std::uint32_t& v : best) v = patch.vertex[v];
    Loop sorted = best;
    std::sort(sorted.begin(), sorted.end());
    if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) return {};
    return best;
  }

  const Scan& scan_;
  const std::vector<std::uint32_t>& piece_;
  std::vector<std::uint32_t> partner_;
  std::vector<double> limit_, longest_;   // per piece
  std::vector<std::uint32_t> corner_at_;  // per vertex: 3 f + k
  std::vector<char> taken_;
};

/// One round; how many handles were cut.
std::size_t cut_round(CleanScan& cleaned, std::vector<std::uint32_t>& source, Counter& count) {
  LoopChooser chooser(cleaned);
  const auto loops = chooser.run();
  if (loops.empty()) return 0;
  std::vector<std::vector<std::uint32_t>> rims;
  for (const auto& loop : loops) {
    const double extent = extent_of(cleaned.scan, loop);
    cut_along(cleaned.scan, chooser.partner(), loop, chooser.corner_at(), rims);
    std::uint32_t first = kNone;
    for (const std::uint32_t s : rims.back()) first = std::min(first, source[s / 3]);
    count.add(first);
    count.measure(0, extent);
  }
  fill_loops(cleaned, source, rims);
  return loops.size();
}

}  // namespace

void cut_tiny_handles(CleanScan& cleaned, std::vector<std::uint32_t>& source, CleanCounts& counts) {
  for (int round = 0; round < kMostRounds; ++round)
    if (cut_round(cleaned, source, counts.handles) == 0) return;
}

}  // namespace nacre::remesh
