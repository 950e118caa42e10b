// SPDX-License-Identifier: GPL-3.0-or-later
//
// Read me first: the soup becomes a manifold by deciding, for every side of every face, which
// single other face it joins (or none). All later topology follows from these joins alone: a vertex
// whose faces fall into several fans of joined faces becomes several vertices. So no case of
// non-manifold input needs a rule of its own.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <string>
#include <tuple>

#include "remesh/adjacency.h"
#include "remesh/remesh.h"

namespace nacre::remesh {
namespace {

constexpr std::size_t kFirstIds = 8;

/// Counts changes of one kind and remembers where the first ones were.
class Counter {
 public:
  explicit Counter(std::string kind) { action_.kind = std::move(kind); }
  void add(std::size_t id) {
    if (action_.first_ids.size() < kFirstIds) action_.first_ids.push_back(id);
    ++action_.count;
  }
  void append_to(CleanReport& report) const {
    if (action_.count > 0) report.actions.push_back(action_);
  }

 private:
  CleanAction action_;
};

struct Side {
  std::uint32_t face, side;
};

class Cleaner {
 public:
  explicit Cleaner(const Scan& scan) : scan_(scan) {}

  CleanScan run() {
    weld();
    drop_faces();
    // Splitting vertices can leave two joined pairs on one edge between the same two vertices; such
    // an edge is no manifold by index, so its later faces go and the joins are made anew.
    for (bool again = true; again;) {
      join_sides();
      orient();
      split_vertices();
      again = drop_faces_on_crowded_edges();
    }
    return finish();
  }

 private:
  void weld() {
    const auto& p = scan_.positions;
    std::vector<std::uint32_t> order(p.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](std::uint32_t v) { return std::tuple(p[v][0], p[v][1], p[v][2], v); };
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
    std::vector<std::uint32_t> target(p.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
      const bool same = i > 0 && p[order[i]] == p[order[i - 1]];
      target[order[i]] = same ? target[order[i - 1]] : order[i];
    }
    std::vector<char> used(p.size(), 0);
    for (const Triangle& t : scan_.triangles)
      for (const std::uint32_t v : t) used[v] = 1;
    for (std::uint32_t v = 0; v < p.size(); ++v) {
      if (!used[v])
        isolated_.add(v);
      else if (target[v] != v)
        welded_.add(v);
    }
    triangles_.reserve(scan_.triangles.size());
    for (const Triangle& t : scan_.triangles)
      triangles_.push_back({target[t[0]], target[t[1]], target[t[2]]});
  }

  void drop_faces() {
    struct Key {
      Triangle sorted;
      std::uint32_t face;
    };
    std::vector<Key> keys;
    std::vector<char> drop(triangles_.size(), 0);
    for (std::uint32_t f = 0; f < triangles_.size(); ++f) {
      Triangle t = triangles_[f];
      if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
        drop[f] = 1;
        degenerate_.add(f);
        continue;
      }
      std::sort(t.begin(), t.end());
      keys.push_back({t, f});
    }
    std::sort(keys.begin(), keys.end(), [](const Key& a, const Key& b) {
      return std::tie(a.sorted, a.face) < std::tie(b.sorted, b.face);
    });
    std::vector<std::uint32_t> duplicates;
    for (std::size_t i = 1; i < keys.size(); ++i)
      if (keys[i].sorted == keys[i - 1].sorted) duplicates.push_back(keys[i].face);
    std::sort(duplicates.begin(), duplicates.end());
    for (const std::uint32_t f : duplicates) {
      drop[f] = 1;
      duplicate_.add(f);
    }
    source_.resize(triangles_.size());
    std::iota(source_.begin(), source_.end(), 0u);
    remove(drop);
    corners_ = triangles_;
  }

  void remove(const std::vector<char>& drop) {
    std::size_t kept = 0;
    for (std::size_t f = 0; f < triangles_.size(); ++f) {
      if (drop[f]) continue;
      triangles_[kept] = triangles_[f];
      if (!corners_.empty()) corners_[kept] = corners_[f];
      source_[kept++] = source_[f];
    }
    triangles_.resize(kept);
    if (!corners_.empty()) corners_.resize(kept);
    source_.resize(kept);
  }

  /// Direction from the edge (a, b) to the third corner of a face, perpendicular to the edge.
  [[nodiscard]] Vec3 away_from_edge(const Side& s) const {
    const Triangle& t = triangles_[s.face];
    const Vec3& a = scan_.positions[t[s.side]];
    const Vec3 edge = (scan_.positions[t[(s.side + 1) % 3]] - a).stableNormalized();
    const Vec3 to = scan_.positions[t[(s.side + 2) % 3]] - a;
    return (to - to.dot(edge) * edge).stableNormalized();
  }

  /// Joins each side to one other: the only one there is, or on crowded edges one of its own sheet,
  /// or the one that continues it flattest.
  void join_sides() {
    std::vector<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> sides;
    sides.reserve(3 * triangles_.size());
    for (std::uint32_t f = 0; f < triangles_.size(); ++f) {
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t a = triangles_[f][k], b = triangles_[f][(k + 1) % 3];
        sides.emplace_back(std::min(a, b), std::max(a, b), 3 * f + k);
      }
    }
    std::sort(sides.begin(), sides.end());
    partner_.assign(3 * triangles_.size(), kNone);
    std::vector<std::vector<std::uint32_t>> crowded;
    for (std::size_t i = 0; i < sides.size();) {
      std::size_t end = i + 1;
      const auto same = [&](std::size_t k) {
        return std::get<0>(sides[k]) == std::get<0>(sides[i]) &&
               std::get<1>(sides[k]) == std::get<1>(sides[i]);
      };
      while (end < sides.size() && same(end)) ++end;
      std::vector<std::uint32_t> group;
      for (std::size_t k = i; k < end; ++k) group.push_back(std::get<2>(sides[k]));
      if (group.size() == 2) join(group[0], group[1]);
      if (group.size() > 2) {
        if (!counted_edges_) crowded_edges_.add(source_[group[0] / 3]);
        crowded.push_back(std::move(group));
      }
      i = end;
    }
    counted_edges_ = true;
    if (!crowded.empty()) join_crowded(crowded);
  }

  /// Faces that hang together around an end of an edge are one sheet, and are joined before others:
  /// a fin does not open the closed surface that it stands on, nor do two solids that touch in an
  /// edge open each other.
  void join_crowded(const std::vector<std::vector<std::uint32_t>>& crowded) {
    std::vector<std::uint32_t> fan(3 * triangles_.size());  // of each corner: union-find
    std::iota(fan.begin(), fan.end(), 0u);
    const auto root = [&](std::uint32_t c) {
      while (fan[c] != c) c = fan[c] = fan[fan[c]];
      return c;
    };
    const auto corner = [&](std::uint32_t face, std::uint32_t vertex) {
      return 3 * face + corner_of(triangles_[face], vertex);
    };
    // Around both ends, then around either: the other may lie on a second crowded edge.
    for (const std::array<bool, 2> look_at :
         {std::array{true, true}, {true, false}, {false, true}}) {
      for (std::uint32_t s = 0; s < partner_.size(); ++s) {
        if (partner_[s] == kNone) continue;
        for (const std::uint32_t k : {s % 3, (s + 1) % 3}) {
          const std::uint32_t v = triangles_[s / 3][k];
          fan[root(corner(s / 3, v))] = root(corner(partner_[s] / 3, v));
        }
      }
      for (const auto& group : crowded) {
        const Triangle& t = triangles_[group[0] / 3];
        const std::uint32_t a = t[group[0] % 3], b = t[(group[0] + 1) % 3];
        std::map<std::array<std::uint32_t, 2>, std::vector<std::uint32_t>> sheets;
        for (const std::uint32_t s : group) {
          const std::uint32_t around_a = look_at[0] ? root(corner(s / 3, a)) : kNone;
          const std::uint32_t around_b = look_at[1] ? root(corner(s / 3, b)) : kNone;
          sheets[{around_a, around_b}].push_back(s);
        }
        for (const auto& [fans, sheet] : sheets) join_flattest(sheet);
      }
    }
    for (const auto& group : crowded) join_flattest(group);
  }

  void join(std::uint32_t a, std::uint32_t b) {
    partner_[a] = b;
    partner_[b] = a;
  }

  void join_flattest(const std::vector<std::uint32_t>& group) {
    struct Pair {
      double cosine;  // -1: the two faces continue each other in a plane
      std::uint32_t a, b;
    };
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < group.size(); ++i) {
      const Vec3 x = away_from_edge({group[i] / 3, group[i] % 3});
      for (std::size_t k = i + 1; k < group.size(); ++k)
        pairs.push_back({x.dot(away_from_edge({group[k] / 3, group[k] % 3})), group[i], group[k]});
    }
    std::sort(pairs.begin(), pairs.end(), [](const Pair& x, const Pair& y) {
      return std::tie(x.cosine, x.a, x.b) < std::tie(y.cosine, y.a, y.b);
    });
    for (const Pair& p : pairs)
      if (partner_[p.a] == kNone && partner_[p.b] == kNone) join(p.a, p.b);
  }

  /// Whether two joined sides run the same way, so that one of the faces must be turned.
  [[nodiscard]] bool wound_alike(std::uint32_t a, std::uint32_t b) const {
    return triangles_[a / 3][a % 3] == triangles_[b / 3][b % 3];
  }

  /// Turns faces so that joined ones agree; joins that cannot agree (Möbius) are cut.
  void orient() {
    const std::size_t n = triangles_.size();
    constexpr std::uint32_t kUnseen = kNone;
    piece_.assign(n, kUnseen);
    std::vector<char> turned(n, 0);
    std::vector<std::uint32_t> queue;
    piece_count_ = 0;
    for (std::uint32_t seed = 0; seed < n; ++seed) {
      if (piece_[seed] != kUnseen) continue;
      queue.assign(1, seed);
      piece_[seed] = piece_count_;
      for (std::size_t head = 0; head < queue.size(); ++head) {
        const std::uint32_t f = queue[head];
        for (std::uint32_t k = 0; k < 3; ++k) {
          const std::uint32_t other = partner_[3 * f + k];
          if (other == kNone) continue;
          const bool turn = (turned[f] != 0) != wound_alike(3 * f + k, other);
          if (piece_[other / 3] == kUnseen) {
            piece_[other / 3] = piece_count_;
            turned[other / 3] = turn;
            queue.push_back(other / 3);
          } else if ((turned[other / 3] != 0) != turn) {
            partner_[3 * f + k] = partner_[other] = kNone;
            one_sided_.add(source_[f]);
          }
        }
      }
      choose_side(queue, turned);
      ++piece_count_;
    }
    for (std::uint32_t f = 0; f < n; ++f) {
      if (!turned[f]) continue;
      flip(f);
    }
  }

  /// A closed piece faces outward; an open one keeps the winding that most of its faces have.
  void choose_side(const std::vector<std::uint32_t>& piece, std::vector<char>& turned) {
    bool closed = true;
    double volume = 0;
    std::size_t turned_count = 0;
    const Vec3 reference = scan_.positions[triangles_[piece[0]][0]];
    for (const std::uint32_t f : piece) {
      for (std::uint32_t k = 0; k < 3; ++k) closed &= partner_[3 * f + k] != kNone;
      const Triangle& t = triangles_[f];
      const double v =
          (scan_.positions[t[0]] - reference)
              .dot((scan_.positions[t[1]] - reference).cross(scan_.positions[t[2]] - reference));
      volume += turned[f] ? -v : v;
      turned_count += turned[f] != 0;
    }
    const bool other_side = closed ? volume < 0 : 2 * turned_count > piece.size();
    if (other_side)
      for (const std::uint32_t f : piece) turned[f] = !turned[f];
    const std::size_t flipped = other_side ? piece.size() - turned_count : turned_count;
    if (flipped == piece.size()) {
      inside_out_.add(source_[piece[0]]);
    } else {
      for (const std::uint32_t f : piece)
        if (turned[f]) reoriented_.add(source_[f]);
    }
  }

  /// Turns a face over: corners 1 and 2 change places, so sides 0 and 2 do.
  void flip(std::uint32_t f) {
    std::swap(triangles_[f][1], triangles_[f][2]);
    std::swap(corners_[f][1], corners_[f][2]);
    const std::uint32_t p0 = partner_[3 * f], p2 = partner_[3 * f + 2];
    partner_[3 * f] = p2;
    partner_[3 * f + 2] = p0;
    if (p2 != kNone) partner_[p2] = 3 * f;
    if (p0 != kNone) partner_[p0] = 3 * f + 2;
  }

  /// Gives every fan of joined faces a vertex of its own; corners_ holds the new vertex ids.
  void split_vertices() {
    corner_vertex_.assign(3 * triangles_.size(), kNone);
    position_of_.clear();
    std::vector<char> met(scan_.positions.size(), 0);
    Counter split("split non-manifold vertices");
    for (std::uint32_t f = 0; f < triangles_.size(); ++f) {
      for (std::uint32_t k = 0; k < 3; ++k) {
        if (corner_vertex_[3 * f + k] != kNone) continue;
        const auto id = static_cast<std::uint32_t>(position_of_.size());
        position_of_.push_back(triangles_[f][k]);
        if (met[triangles_[f][k]]) split.add(triangles_[f][k]);
        met[triangles_[f][k]] = 1;
        walk_fan(f, k, id);
      }
    }
    split_ = split;
    for (std::uint32_t f = 0; f < triangles_.size(); ++f)
      for (std::uint32_t k = 0; k < 3; ++k) corners_[f][k] = corner_vertex_[3 * f + k];
  }

  void walk_fan(std::uint32_t face, std::uint32_t corner, std::uint32_t id) {
    // Both ways round from the first face; in a closed fan the first way meets itself.
    for (const std::uint32_t leave : {2u, 0u}) {
      std::uint32_t f = face, c = corner;
      while (true) {
        corner_vertex_[3 * f + c] = id;
        const std::uint32_t across = partner_[3 * f + (c + leave) % 3];
        if (across == kNone) break;
        f = across / 3;
        // Entering over side s: the vertex is its start when leaving over our side 2, else its end.
        c = leave == 2 ? across % 3 : (across % 3 + 1) % 3;
        if (f == face && c == corner) return;
        if (corner_vertex_[3 * f + c] == id) return;
      }
    }
  }

  /// Edges that, by vertex ids, still have more than two faces or two of one direction.
  bool drop_faces_on_crowded_edges() {
    std::vector<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> sides;
    for (std::uint32_t f = 0; f < corners_.size(); ++f) {
      for (std::uint32_t k = 0; k < 3; ++k)
        sides.emplace_back(corners_[f][k], corners_[f][(k + 1) % 3], f);
    }
    std::sort(sides.begin(), sides.end());
    std::vector<char> drop(triangles_.size(), 0);
    bool any = false;
    const auto doom = [&](std::uint32_t f) {
      if (!drop[f]) on_crowded_.add(source_[f]);
      drop[f] = 1;
      any = true;
    };
    for (std::size_t i = 1; i < sides.size(); ++i) {
      if (std::get<0>(sides[i]) == std::get<0>(sides[i - 1]) &&
          std::get<1>(sides[i]) == std::get<1>(sides[i - 1]))
        doom(std::get<2>(sides[i]));
    }
    // Two faces on one edge that are not joined: a slit between the same two vertices.
    for (std::uint32_t s = 0; s < partner_.size(); ++s) {
      if (partner_[s] != kNone) continue;
      const auto reverse = std::tuple(corners_[s / 3][(s % 3 + 1) % 3], corners_[s / 3][s % 3], 0u);
      const auto it = std::lower_bound(sides.begin(), sides.end(), reverse);
      if (it != sides.end() && std::get<0>(*it) == std::get<0>(reverse) &&
          std::get<1>(*it) == std::get<1>(reverse) && !drop[std::get<2>(*it)])
        doom(s / 3);
    }
    if (any) remove(drop);
    return any;
  }

  CleanScan finish() {
    CleanScan out;
    out.scan.origin = scan_.origin;
    out.scan.triangles = corners_;
    for (const std::uint32_t v : position_of_) out.scan.positions.push_back(scan_.positions[v]);
    out.piece = piece_;
    CleanReport& r = out.report;
    for (const Counter* c : {&welded_, &isolated_, &degenerate_, &duplicate_, &crowded_edges_,
                             &on_crowded_, &one_sided_, &split_, &reoriented_, &inside_out_})
      c->append_to(r);
    count_topology(out);
    return out;
  }

  void count_topology(CleanScan& out) const {
    CleanReport& r = out.report;
    r.vertices = out.scan.positions.size();
    r.triangles = out.scan.triangles.size();
    r.pieces = piece_count_;
    std::vector<long> euler(piece_count_, 0), loops(piece_count_, 0);
    std::vector<std::uint32_t> next(out.scan.positions.size(), kNone);  // along the boundary
    std::vector<std::uint32_t> piece_of(out.scan.positions.size(), 0);
    for (std::uint32_t f = 0; f < corners_.size(); ++f) {
      long& chi = euler[piece_[f]];
      chi += 2;  // two for the face, less one for each whole edge, counted from halves: 2χ
      for (std::uint32_t k = 0; k < 3; ++k) {
        const bool border = partner_[3 * f + k] == kNone;
        chi -= border ? 2 : 1;
        if (border) next[corners_[f][k]] = corners_[f][(k + 1) % 3];
        piece_of[corners_[f][k]] = piece_[f];
      }
    }
    for (const std::uint32_t p : piece_of) euler[p] += 2;
    std::vector<char> seen(next.size(), 0);
    for (std::uint32_t v = 0; v < next.size(); ++v) {
      if (next[v] == kNone || seen[v]) continue;
      ++loops[piece_of[v]];
      for (std::uint32_t w = v; !seen[w]; w = next[w]) seen[w] = 1;
    }
    out.pieces.resize(piece_count_);
    for (const std::uint32_t p : piece_) ++out.pieces[p].triangles;
    for (std::size_t p = 0; p < piece_count_; ++p) {
      PieceReport& piece = out.pieces[p];
      piece.boundary_loops = static_cast<std::size_t>(loops[p]);
      piece.genus = static_cast<int>((2 - loops[p] - euler[p] / 2) / 2);
      r.closed_pieces += loops[p] == 0;
      r.boundary_loops += piece.boundary_loops;
      r.genus += piece.genus;
    }
  }

  const Scan& scan_;
  std::vector<Triangle> triangles_;     // by welded vertex
  std::vector<Triangle> corners_;       // by split vertex
  std::vector<std::uint32_t> source_;   // input face of each
  std::vector<std::uint32_t> partner_;  // per side 3f + k: the side it joins
  std::vector<std::uint32_t> piece_, corner_vertex_, position_of_;
  std::uint32_t piece_count_ = 0;
  bool counted_edges_ = false;
  Counter welded_{"welded vertices"}, isolated_{"dropped isolated vertices"},
      degenerate_{"dropped degenerate faces"}, duplicate_{"dropped duplicate faces"},
      crowded_edges_{"cut edges of three or more faces"},
      on_crowded_{"dropped faces on non-manifold edges"}, one_sided_{"cut one-sided edges"},
      split_{"split non-manifold vertices"}, reoriented_{"reoriented faces"},
      inside_out_{"turned pieces inside out"};
};

bool has_area(const Scan& scan) {
  return std::any_of(scan.triangles.begin(), scan.triangles.end(), [&](const Triangle& t) {
    return (scan.positions[t[1]] - scan.positions[t[0]])
               .cross(scan.positions[t[2]] - scan.positions[t[0]])
               .squaredNorm() > 0;
  });
}

Result<void> check_policy(const CleanReport& report, RepairPolicy policy) {
  for (const CleanAction& action : report.actions) {
    const bool harmless =
        action.kind == "welded vertices" || action.kind == "dropped isolated vertices";
    if (policy == RepairPolicy::kSafe || (policy == RepairPolicy::kStrict && harmless)) continue;
    return Error{ErrorCode::kGeometryRefused,
                 "needs " + std::to_string(action.count) + " " + action.kind + " (first at " +
                     std::to_string(action.first_ids.front()) +
                     "), which this repair policy forbids; allow it with --repair safe",
                 action.first_ids.front()};
  }
  return {};
}

}  // namespace

Result<CleanScan> clean(const Scan& scan, RepairPolicy policy) {
  for (std::size_t v = 0; v < scan.positions.size(); ++v) {
    if (!scan.positions[v].allFinite())
      return Error{ErrorCode::kBadInput, "vertex " + std::to_string(v) + " is not finite", v};
  }
  CleanScan cleaned = Cleaner(scan).run();
  if (cleaned.scan.triangles.empty())
    return Error{ErrorCode::kGeometryRefused, "no triangle of three different corners is left", 0};
  if (!has_area(cleaned.scan))
    return Error{ErrorCode::kGeometryRefused, "no triangle has any area", 0};
  if (const auto ok = check_policy(cleaned.report, policy); !ok) return ok.error();
  return cleaned;
}

}  // namespace nacre::remesh
