// SPDX-License-Identifier: GPL-3.0-or-later
//
// Read me first: what the input's numbering joins stays joined, so a manifold stays as it is even
// where it touches itself. Other sides in one place are joined when nothing speaks against it. What
// was cut before is not joined again, since the joins that are left would be the same.
#include <array>
#include <map>
#include <numeric>
#include <tuple>

#include "remesh/adjacency.h"
#include "remesh/clean_steps.h"
#include "remesh/side_groups.h"

namespace nacre::remesh {
namespace {

using Sides = std::vector<std::uint32_t>;

/// Connected parts, and for each face whether it must be turned to agree with its part's first one.
class Winding {
 public:
  void add_part() {
    parent_.push_back(static_cast<std::uint32_t>(parent_.size()));
    odd_.push_back(0);
  }
  /// The part's representative, and whether the part is turned against it.
  std::pair<std::uint32_t, bool> find(std::uint32_t part) {
    bool odd = false;
    for (std::uint32_t p = part; parent_[p] != p; p = parent_[p]) odd ^= odd_[p] != 0;
    const bool whole = odd;
    std::uint32_t root = part;
    while (parent_[root] != root) root = parent_[root];
    while (parent_[part] != part) {  // shorten the way
      const std::uint32_t next = parent_[part];
      const bool step = odd_[part] != 0;
      parent_[part] = root;
      odd_[part] = odd;
      odd ^= step;
      part = next;
    }
    return {root, whole};
  }
  /// Says that b is turned against a, or not. False if that is known to be otherwise.
  bool relate(std::uint32_t a, std::uint32_t b, bool turned) {
    const auto [root_a, odd_a] = find(a);
    const auto [root_b, odd_b] = find(b);
    const bool odd = turned != (odd_a != odd_b);
    if (root_a == root_b) return !odd;
    const auto [low, high] = std::minmax(root_a, root_b);
    parent_[high] = low;
    odd_[high] = odd;
    return true;
  }

 private:
  std::vector<std::uint32_t> parent_;
  std::vector<char> odd_;
};

class Joiner {
 public:
  Joiner(const Soup& soup, CleanCounts& counts) : soup_(soup), counts_(counts) {}

  Joins run() {
    join_plain();
    spread();
    find_open_edges();
    if (!open_edges_.empty()) join_crowded();
    number_pieces();
    return std::move(joins_);
  }

 private:
  /// An edge of three or more sides, and those of them that have no partner yet; all are in
  /// joins_.crowded[index].
  struct OpenEdge {
    std::size_t index = 0;
    Sides sides;
    bool numbered = false;  // by the input's numbering as well
  };

  [[nodiscard]] std::uint64_t number_key(std::uint32_t side) const {
    const Triangle& t = soup_.corners[side / 3];
    const std::uint32_t a = t[side % 3], b = t[(side % 3 + 1) % 3];
    return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
  }
  /// Whether two sides in one place run the same way, so that one of the faces must be turned.
  [[nodiscard]] bool wound_alike(std::uint32_t a, std::uint32_t b) const {
    return soup_.at[a / 3][a % 3] == soup_.at[b / 3][b % 3];
  }
  void join(std::uint32_t a, std::uint32_t b) {
    joins_.partner[a] = b;
    joins_.partner[b] = a;
  }

  void join_plain() {
    joins_.partner.assign(3 * soup_.at.size(), kNone);
    by_number_.assign(joins_.partner.size(), 0);
    for_each_edge(soup_.at, static_cast<std::uint32_t>(soup_.scan.positions.size()),
                  [&](std::span<const std::uint32_t> sides) {
                    if (sides.size() == 2) {
                      join(sides[0], sides[1]);
                      by_number_[sides[0]] = by_number_[sides[1]] =
                          number_key(sides[0]) == number_key(sides[1]);
                    }
                    if (sides.size() > 2) join_by_number(sides);
                  });
  }

  void join_by_number(std::span<const std::uint32_t> sides) {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keys;
    for (const std::uint32_t s : sides) keys.emplace_back(number_key(s), s);
    std::sort(keys.begin(), keys.end());
    std::vector<std::uint32_t> rest;
    bool numbered = false;
    for (std::size_t i = 0; i < keys.size();) {
      std::size_t end = i + 1;
      while (end < keys.size() && keys[end].first == keys[i].first) ++end;
      if (end - i == 2) {
        join(keys[i].second, keys[i + 1].second);
        by_number_[keys[i].second] = by_number_[keys[i + 1].second] = 1;
      } else {
        for (std::size_t k = i; k < end; ++k) rest.push_back(keys[k].second);
        numbered |= end - i > 2;
      }
      i = end;
    }
    if (rest.size() == 2) join(rest[0], rest[1]);
    joins_.crowded.emplace_back(sides.begin(), sides.end());
    numbered_.push_back(numbered);
  }

  /// Finds the parts that the joins make; joins that cannot agree (Möbius) are cut. Joins by number
  /// are followed first, so that a cut falls on the others where it can.
  void spread() {
    const std::size_t n = soup_.at.size();
    part_.assign(n, kNone);
    numbered_part_.assign(n, kNone);
    joins_.turned.assign(n, 0);
    Sides near, far;  // faces of the numbered part at hand; sides to go on from
    std::uint32_t part = 0, numbered = 0;
    const auto enter = [&](std::uint32_t f, bool turned) {
      part_[f] = part;
      numbered_part_[f] = numbered;
      joins_.turned[f] = turned;
      near.push_back(f);
    };
    for (std::uint32_t seed = 0; seed < n; ++seed) {
      if (part_[seed] != kNone) continue;
      far.clear();
      enter(seed, false);
      for (std::size_t next = 0; !near.empty();) {
        for (std::size_t head = 0; head < near.size(); ++head) {
          const std::uint32_t f = near[head];
          for (std::uint32_t s = 3 * f; s < 3 * f + 3; ++s) {
            const std::uint32_t other = joins_.partner[s];
            if (other == kNone) continue;
            const bool turned = (joins_.turned[f] != 0) != wound_alike(s, other);
            if (part_[other / 3] != kNone) {
              if ((joins_.turned[other / 3] != 0) != turned) cut(s, other);
            } else if (by_number_[s]) {
              enter(other / 3, turned);
            } else {
              far.push_back(s);
            }
          }
        }
        near.clear();
        ++numbered;
        for (; next < far.size() && near.empty(); ++next) {
          const std::uint32_t s = far[next], other = joins_.partner[s];
          if (other == kNone || part_[other / 3] != kNone) continue;  // its other side has seen it
          enter(other / 3, (joins_.turned[s / 3] != 0) != wound_alike(s, other));
        }
      }
      winding_.add_part();
      ++part;
    }
  }

  void cut(std::uint32_t a, std::uint32_t b) {
    // Between two faces that the numbering keeps in one piece but apart here, nothing is cut.
    if (by_number_[a] || numbered_part_[a / 3] != numbered_part_[b / 3])
      counts_.one_sided.add(std::min(soup_.source[a / 3], soup_.source[b / 3]));
    joins_.partner[a] = joins_.partner[b] = kNone;
    joins_.crowded.push_back({a, b});
  }

  /// Joins two sides if the winding of their parts allows it.
  bool try_join(std::uint32_t a, std::uint32_t b) {
    if (joins_.partner[a] != kNone || joins_.partner[b] != kNone) return false;
    const std::uint32_t f = a / 3, g = b / 3;
    const bool turned = ((joins_.turned[f] != 0) != (joins_.turned[g] != 0)) != wound_alike(a, b);
    if (!winding_.relate(part_[f], part_[g], turned)) return false;
    join(a, b);
    unite_fans(a, b);
    return true;
  }

  // ---- crowded edges

  void find_open_edges() {
    for (std::size_t i = 0; i < numbered_.size(); ++i) {
      OpenEdge edge{i, {}, numbered_[i] != 0};
      for (const std::uint32_t s : joins_.crowded[i])
        if (joins_.partner[s] == kNone) edge.sides.push_back(s);
      if (edge.sides.size() > 1) open_edges_.push_back(std::move(edge));
    }
  }

  void join_crowded() {
    start_fans();
    find_sealed();
    for (const OpenEdge& edge : open_edges_) {
      const Sides sides = sealed_of(edge);
      if (sides.size() == 2) try_join(sides[0], sides[1]);
    }
    for (const bool only_sealed : {true, false}) {
      // Faces that hang together around both ends of an edge, then around either (the other may lie
      // on a second crowded edge), then anywhere, are one sheet: a fin does not open the surface
      // that it stands on, nor do two solids that touch in an edge open each other.
      for (const std::array<bool, 2> look_at :
           {std::array{true, true}, {true, false}, {false, true}, {false, false}})
        join_sheets(only_sealed, look_at);
      join_alike(only_sealed);
    }
    for (const OpenEdge& edge : open_edges_) join_flattest(edge.sides);
    for (const OpenEdge& edge : open_edges_) {
      const bool joined = std::any_of(edge.sides.begin(), edge.sides.end(),
                                      [&](std::uint32_t s) { return joins_.partner[s] != kNone; });
      if (!joined && !edge.numbered) continue;
      const auto& all = joins_.crowded[edge.index];
      std::uint32_t first = kNone;
      for (const std::uint32_t s : all) first = std::min(first, soup_.source[s / 3]);
      counts_.crowded.add(first);
    }
  }

  [[nodiscard]] Sides sealed_of(const OpenEdge& edge) const {
    Sides sides;
    for (const std::uint32_t s : edge.sides)
      if (sealed_[part_[s / 3]] && joins_.partner[s] == kNone) sides.push_back(s);
    return sides;
  }

  /// A part is sealed if it has no boundary but crowded edges, and at each of these another sealed
  /// part (or itself again) to go on: only such parts can make a closed surface, all others can be
  /// cut off it.
  void find_sealed() {
    std::uint32_t parts = 0;
    for (const std::uint32_t p : part_) parts = std::max(parts, p + 1);
    sealed_.assign(parts, 1);
    std::vector<char> open(joins_.partner.size(), 0);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> edges_of;  // part, open edge
    std::vector<std::size_t> left(open_edges_.size());              // sealed sides there
    for (std::uint32_t e = 0; e < open_edges_.size(); ++e) {
      left[e] = open_edges_[e].sides.size();
      for (const std::uint32_t s : open_edges_[e].sides) {
        open[s] = 1;
        edges_of.emplace_back(part_[s / 3], e);
      }
    }
    std::sort(edges_of.begin(), edges_of.end());
    Sides queue;
    const auto unseal = [&](std::uint32_t part) {
      if (sealed_[part]) queue.push_back(part);
      sealed_[part] = 0;
    };
    for (std::uint32_t s = 0; s < open.size(); ++s)
      if (joins_.partner[s] == kNone && !open[s]) unseal(part_[s / 3]);
    for (std::size_t head = 0; head < queue.size(); ++head) {
      const std::uint32_t part = queue[head];
      for (auto it = std::lower_bound(edges_of.begin(), edges_of.end(), std::pair(part, 0u));
           it != edges_of.end() && it->first == part; ++it) {
        if (--left[it->second] != 1) continue;
        for (const std::uint32_t s : open_edges_[it->second].sides) unseal(part_[s / 3]);
      }
    }
  }

  /// Union-find over the corners around the ends of open edges.
  void start_fans() {
    fan_.resize(joins_.partner.size());
    std::iota(fan_.begin(), fan_.end(), 0u);
    std::vector<char> near(soup_.scan.positions.size(), 0);
    for (const OpenEdge& edge : open_edges_)
      for (const std::uint32_t k : {0u, 1u})
        near[soup_.at[edge.sides[0] / 3][(edge.sides[0] % 3 + k) % 3]] = 1;
    for (std::uint32_t s = 0; s < joins_.partner.size(); ++s) {
      const Triangle& t = soup_.at[s / 3];
      if (joins_.partner[s] != kNone && (near[t[s % 3]] || near[t[(s % 3 + 1) % 3]]))
        unite_fans(s, joins_.partner[s]);
    }
  }
  std::uint32_t fan(std::uint32_t corner) {
    while (fan_[corner] != corner) corner = fan_[corner] = fan_[fan_[corner]];
    return corner;
  }
  void unite_fans(std::uint32_t a, std::uint32_t b) {
    for (const std::uint32_t k : {a % 3, (a + 1) % 3}) {
      const std::uint32_t corner = 3 * (b / 3) + corner_of(soup_.at[b / 3], soup_.at[a / 3][k]);
      fan_[fan(3 * (a / 3) + k)] = fan(corner);
    }
  }

  void join_sheets(bool only_sealed, const std::array<bool, 2>& look_at) {
    std::map<std::array<std::uint32_t, 2>, Sides> sheets;
    for (const OpenEdge& edge : open_edges_) {
      const std::uint32_t first = edge.sides[0], a = soup_.at[first / 3][first % 3],
                          b = soup_.at[first / 3][(first % 3 + 1) % 3];
      sheets.clear();
      for (const std::uint32_t s : only_sealed ? sealed_of(edge) : edge.sides) {
        if (joins_.partner[s] != kNone) continue;
        const auto around = [&](std::uint32_t v) {
          return fan(3 * (s / 3) + corner_of(soup_.at[s / 3], v));
        };
        if (look_at[0] || look_at[1])
          sheets[{look_at[0] ? around(a) : kNone, look_at[1] ? around(b) : kNone}].push_back(s);
        else
          sheets[{winding_.find(part_[s / 3]).first, kNone}].push_back(s);
      }
      for (const auto& [key, sheet] : sheets)
        if (sheet.size() > 1) join_flattest(sheet);
    }
  }

  /// Edges where the same different parts meet are decided as one, so that a curve of them is cut
  /// all along and not here and there.
  void join_alike(bool only_sealed) {
    struct Curve {
      std::vector<Sides> edges;  // each sorted by part
      std::vector<double> score;
    };
    std::map<Sides, Curve> curves;
    for (const OpenEdge& edge : open_edges_) {
      Sides sides = edge.sides;
      if (only_sealed) sides = sealed_of(edge);
      std::erase_if(sides, [&](std::uint32_t s) { return joins_.partner[s] != kNone; });
      if (sides.size() < 2 || sides.size() > kMostAlike) continue;
      std::sort(sides.begin(), sides.end(), [&](std::uint32_t x, std::uint32_t y) {
        return std::pair(part_[x / 3], x) < std::pair(part_[y / 3], y);
      });
      Sides parts;
      for (const std::uint32_t s : sides) parts.push_back(part_[s / 3]);
      if (std::adjacent_find(parts.begin(), parts.end()) != parts.end()) continue;
      Curve& curve = curves[parts];
      curve.score.resize(sides.size() * sides.size(), 0.0);
      const bool solids = only_sealed && sides.size() % 2 == 0;
      for (std::size_t i = 0; i < sides.size(); ++i)
        for (std::size_t k = i + 1; k < sides.size(); ++k)
          curve.score[i * sides.size() + k] +=
              length_of(sides[i]) * misfit(sides[i], sides[k], solids);
      curve.edges.push_back(std::move(sides));
    }
    for (auto& [parts, curve] : curves) {
      std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;
      for (std::size_t i = 0; i < parts.size(); ++i)
        for (std::size_t k = i + 1; k < parts.size(); ++k)
          pairs.emplace_back(curve.score[i * parts.size() + k], i, k);
      std::sort(pairs.begin(), pairs.end());
      for (const auto& [score, i, k] : pairs)
        for (const Sides& sides : curve.edges) try_join(sides[i], sides[k]);
    }
  }

  /// Lowest for the pair that is best joined: faces that continue each other, or at edges of solids
  /// those with the least solid between them.
  [[nodiscard]] double misfit(std::uint32_t a, std::uint32_t b, bool solids) const {
    const Vec3 x = away_from_edge(a), y = away_from_edge(b);
    const double cosine = x.dot(y);
    if (!solids) return cosine;
    if (wound_alike(a, b)) return 8 + cosine;  // no solid between these
    const Triangle& t = soup_.at[a / 3];
    const Vec3 along = soup_.scan.positions[t[(a % 3 + 1) % 3]] - soup_.scan.positions[t[a % 3]];
    // Face a has its inside to the right of x, seen against the edge: the angle from x to y through
    // the inside is below half a turn if y lies there.
    const bool inside = y.dot(x.cross(along)) > 0;
    return inside ? 1 - cosine : 3 + cosine;
  }

  [[nodiscard]] double length_of(std::uint32_t side) const {
    const Triangle& t = soup_.at[side / 3];
    return (soup_.scan.positions[t[(side % 3 + 1) % 3]] - soup_.scan.positions[t[side % 3]]).norm();
  }

  /// Direction from the edge to the third corner of a side's face, perpendicular to the edge.
  [[nodiscard]] Vec3 away_from_edge(std::uint32_t side) const {
    const Triangle& t = soup_.at[side / 3];
    const auto& p = soup_.scan.positions;
    // From the lower end, so that both faces of an edge see the same one.
    const std::uint32_t a = std::min(t[side % 3], t[(side % 3 + 1) % 3]),
                        b = std::max(t[side % 3], t[(side % 3 + 1) % 3]);
    const Vec3 edge = (p[b] - p[a]).stableNormalized();
    const Vec3 to = p[t[(side % 3 + 2) % 3]] - p[a];
    return (to - to.dot(edge) * edge).stableNormalized();
  }

  /// Again and again while it helps: only so many sides are compared with each other at a time.
  void join_flattest(const Sides& sides) {
    for (bool again = true; again;) {
      Sides open;
      for (const std::uint32_t s : sides)
        if (joins_.partner[s] == kNone) open.push_back(s);
      again = false;
      for (std::size_t i = 0; i < open.size(); i += kMostCompared)
        again |= join_pairs(std::span(open).subspan(i, std::min(kMostCompared, open.size() - i)));
      again &= open.size() > kMostCompared;
    }
  }

  bool join_pairs(std::span<const std::uint32_t> open) {
    struct Pair {
      double cosine;  // -1: the two faces continue each other in a plane
      std::uint32_t a, b;
    };
    std::vector<Vec3> away;
    for (const std::uint32_t s : open) away.push_back(away_from_edge(s));
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < open.size(); ++i)
      for (std::size_t k = i + 1; k < open.size(); ++k)
        pairs.push_back({away[i].dot(away[k]), open[i], open[k]});
    std::sort(pairs.begin(), pairs.end(), [](const Pair& x, const Pair& y) {
      return std::tie(x.cosine, x.a, x.b) < std::tie(y.cosine, y.a, y.b);
    });
    bool any = false;
    for (const Pair& p : pairs) any |= try_join(p.a, p.b);
    return any;
  }

  void number_pieces() {
    std::vector<std::uint32_t> number;
    joins_.piece.resize(part_.size());
    for (std::size_t f = 0; f < part_.size(); ++f) {
      const auto [root, odd] = winding_.find(part_[f]);
      if (root >= number.size()) number.resize(root + 1, kNone);
      if (number[root] == kNone) number[root] = joins_.piece_count++;
      joins_.piece[f] = number[root];
      joins_.turned[f] = (joins_.turned[f] != 0) != odd;
    }
  }

  /// An edge with more faces than this is compared in parts: all pairs would be quadratic.
  static constexpr std::size_t kMostCompared = 64, kMostAlike = 8;

  const Soup& soup_;
  CleanCounts& counts_;
  Joins joins_;
  std::vector<char> by_number_;               // per side: its join is the input's own
  std::vector<std::uint32_t> part_;           // per face, before crowded edges are joined
  std::vector<std::uint32_t> numbered_part_;  // per face: joined to by the input's numbering
  std::vector<char> numbered_;  // per crowded edge: it is one by the input's numbering as well
  std::vector<OpenEdge> open_edges_;
  std::vector<char> sealed_;        // per part
  std::vector<std::uint32_t> fan_;  // per corner 3 f + k
  Winding winding_;
};

}  // namespace

Joins join_sides(const Soup& soup, CleanCounts& counts) { return Joiner(soup, counts).run(); }

}  // namespace nacre::remesh
