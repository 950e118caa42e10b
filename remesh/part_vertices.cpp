// SPDX-License-Identifier: GPL-3.0-or-later
#include <map>

#include "remesh/clean_steps.h"

namespace nacre::remesh {
namespace {

class Parter {
 public:
  Parter(Soup& soup, Joins& joins, CleanCounts& counts)
      : soup_(soup), joins_(joins), partner_(joins.partner), counts_(counts) {}

  CleanScan run() {
    out_.scan.origin = soup_.scan.origin;
    number_fans();
    count_changes();
    out_.piece = joins_.piece;
    const std::size_t fans = out_.scan.positions.size();
    part_edges();
    if (out_.scan.positions.size() > fans) renumber();
    return std::move(out_);
  }

 private:
  void number_fans() {
    auto& triangles = out_.scan.triangles;
    triangles.assign(soup_.at.size(), Triangle{kNone, kNone, kNone});
    for (std::uint32_t f = 0; f < triangles.size(); ++f) {
      for (std::uint32_t k = 0; k < 3; ++k) {
        if (triangles[f][k] != kNone) continue;
        const auto id = static_cast<std::uint32_t>(out_.scan.positions.size());
        out_.scan.positions.push_back(soup_.scan.positions[soup_.at[f][k]]);
        walk_fan(f, k, id);
      }
    }
  }

  void walk_fan(std::uint32_t face, std::uint32_t corner, std::uint32_t id) {
    auto& triangles = out_.scan.triangles;
    // Both ways round from the first face; in a closed fan the first way meets itself.
    for (const std::uint32_t leave : {2u, 0u}) {
      std::uint32_t f = face, c = corner;
      while (true) {
        triangles[f][c] = id;
        const std::uint32_t across = partner_[3 * f + (c + leave) % 3];
        if (across == kNone) break;
        f = across / 3;
        // Entering over side s: the vertex is its start when leaving over our side 2, else its end.
        c = leave == 2 ? across % 3 : (across % 3 + 1) % 3;
        if (f == face && c == corner) return;
        if (triangles[f][c] == id) return;
      }
    }
  }

  /// What joining and parting came to: a vertex of the input is welded if its faces went to that of
  /// a lower one, and parted if they went to several.
  void count_changes() {
    const auto& triangles = out_.scan.triangles;
    std::vector<std::uint32_t> lowest(out_.scan.positions.size(), kNone);
    std::vector<std::uint32_t> first(soup_.place.size(), kNone);  // of the input: its first new one
    std::vector<std::pair<std::uint32_t, std::uint32_t>> further;
    for (std::size_t f = 0; f < triangles.size(); ++f) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t id = triangles[f][k], v = soup_.corners[f][k];
        lowest[id] = std::min(lowest[id], v);
        if (first[v] == kNone) first[v] = id;
        if (first[v] != id) further.emplace_back(v, id);
      }
    }
    std::sort(further.begin(), further.end());
    further.erase(std::unique(further.begin(), further.end()), further.end());
    for (const auto& [v, id] : further) counts_.parted.add(v);
    std::vector<char> keeps(first.size(), 0), used(first.size(), 0);
    for (const std::uint32_t v : lowest) keeps[v] = 1;
    for (const Triangle& t : soup_.scan.triangles)
      for (const std::uint32_t v : t) used[v] = 1;
    for (std::uint32_t v = 0; v < keeps.size(); ++v)
      if (used[v] && !keeps[v] && (first[v] != kNone || soup_.place[v] != v)) counts_.welded.add(v);
  }

  void part_edges() {
    for (const auto& sides : joins_.crowded)
      for (const std::uint32_t s : sides) sides_[ends_of(s)].push_back(s);
    for (const auto& [ends, sides] : sides_) to_do_.push_back(ends);
    for (std::size_t i = 0; i < to_do_.size(); ++i) part_edge(sides_[to_do_[i]]);
  }

  /// Of the joined pairs and single sides that have both end vertices in common, all but one get a
  /// vertex in the middle of the edge.
  void part_edge(std::vector<std::uint32_t> same) {
    // Joined pairs first, so that one of them keeps the edge.
    std::sort(same.begin(), same.end(), [&](std::uint32_t x, std::uint32_t y) {
      return std::pair(partner_[x] == kNone, x) < std::pair(partner_[y] == kNone, y);
    });
    same.erase(std::unique(same.begin(), same.end()), same.end());
    std::vector<std::uint32_t> to_split;
    for (const std::uint32_t s : same)
      if (s != same[0] && s != partner_[same[0]] && (partner_[s] == kNone || s < partner_[s]))
        to_split.push_back(s);
    for (const std::uint32_t s : to_split) split(s);
  }

  using Ends = std::pair<std::uint32_t, std::uint32_t>;
  [[nodiscard]] Ends ends_of(std::uint32_t side) const {
    return std::minmax({end_of(side, 0), end_of(side, 1)});
  }
  /// In the order of the triangles, as the fans were.
  void renumber() {
    std::vector<std::uint32_t> id(out_.scan.positions.size(), kNone);
    std::vector<Vec3> positions;
    for (Triangle& t : out_.scan.triangles) {
      for (std::uint32_t& v : t) {
        if (id[v] == kNone) {
          id[v] = static_cast<std::uint32_t>(positions.size());
          positions.push_back(out_.scan.positions[v]);
        }
        v = id[v];
      }
    }
    out_.scan.positions = std::move(positions);
  }

  [[nodiscard]] std::uint32_t end_of(std::uint32_t side, std::uint32_t end) const {
    return out_.scan.triangles[side / 3][(side % 3 + end) % 3];
  }

  void split(std::uint32_t side) {
    const auto middle = static_cast<std::uint32_t>(out_.scan.positions.size());
    const auto& p = out_.scan.positions;
    const Vec3 position = (p[end_of(side, 0)] + p[end_of(side, 1)]) / 2;
    out_.scan.positions.push_back(position);
    counts_.doubled.add(soup_.source[side / 3]);
    const std::uint32_t other = partner_[side];
    const std::uint32_t second = cut_face(side, middle);
    if (other == kNone) return;
    const std::uint32_t other_second = cut_face(other, middle);
    join(side, other_second);
    join(other, second);
  }

  void join(std::uint32_t a, std::uint32_t b) {
    partner_[a] = b;
    partner_[b] = a;
  }

  /// Cuts a face from a vertex on its side to the opposite corner; the face keeps the first half of
  /// the side. Returns the side of the new face that is the second half.
  std::uint32_t cut_face(std::uint32_t side, std::uint32_t middle) {
    auto& triangles = out_.scan.triangles;
    const std::uint32_t f = side / 3, k = side % 3, next = (k + 1) % 3, last = (k + 2) % 3;
    const auto g = static_cast<std::uint32_t>(triangles.size());
    Triangle second = triangles[f];
    second[k] = middle;
    triangles[f][next] = middle;
    triangles.push_back(second);
    out_.piece.push_back(out_.piece[f]);
    soup_.source.push_back(soup_.source[f]);
    partner_.resize(partner_.size() + 3, kNone);
    const std::uint32_t outer = partner_[3 * f + next];
    if (outer != kNone) join(3 * g + next, outer);
    const auto known = sides_.find(ends_of(3 * g + next));
    if (known != sides_.end())
      std::replace(known->second.begin(), known->second.end(), 3 * f + next, 3 * g + next);
    join(3 * f + next, 3 * g + last);
    // The two faces of a pair may have their third vertex in common, and so their cuts as well.
    const Ends cut = ends_of(3 * f + next);
    sides_[cut].insert(sides_[cut].end(), {3 * f + next, 3 * g + last});
    to_do_.push_back(cut);
    return 3 * g + k;
  }

  Soup& soup_;
  Joins& joins_;
  std::vector<std::uint32_t>& partner_;
  CleanCounts& counts_;
  CleanScan out_;
  std::map<Ends, std::vector<std::uint32_t>> sides_;  // of edges that may have too many
  std::vector<Ends> to_do_;
};

}  // namespace

CleanScan part_vertices(Soup& soup, Joins& joins, CleanCounts& counts) {
  return Parter(soup, joins, counts).run();
}

void count_topology(CleanScan& cleaned, std::uint32_t piece_count,
                    std::span<const std::uint32_t> partner) {
  const auto& triangles = cleaned.scan.triangles;
  std::vector<long> euler(piece_count, 0), loops(piece_count, 0);
  std::vector<std::uint32_t> next(cleaned.scan.positions.size(), kNone);  // along the boundary
  std::vector<std::uint32_t> piece_of(cleaned.scan.positions.size(), 0);
  for (std::uint32_t f = 0; f < triangles.size(); ++f) {
    long& chi = euler[cleaned.piece[f]];
    chi += 2;  // two for the face, less one for each whole edge, counted from halves: 2χ
    for (std::uint32_t k = 0; k < 3; ++k) {
      const bool border = partner[3 * f + k] == kNone;
      chi -= border ? 2 : 1;
      if (border) next[triangles[f][k]] = triangles[f][(k + 1) % 3];
      piece_of[triangles[f][k]] = cleaned.piece[f];
    }
  }
  for (const std::uint32_t p : piece_of) euler[p] += 2;
  std::vector<char> seen(next.size(), 0);
  for (std::uint32_t v = 0; v < next.size(); ++v) {
    if (next[v] == kNone || seen[v]) continue;
    ++loops[piece_of[v]];
    for (std::uint32_t w = v; !seen[w]; w = next[w]) seen[w] = 1;
  }
  cleaned.pieces.assign(piece_count, {});
  for (const std::uint32_t p : cleaned.piece) ++cleaned.pieces[p].triangles;
  for (std::size_t p = 0; p < piece_count; ++p) {
    cleaned.pieces[p].boundary_loops = static_cast<std::size_t>(loops[p]);
    cleaned.pieces[p].genus = static_cast<int>((2 - loops[p] - euler[p] / 2) / 2);
  }
}

}  // namespace nacre::remesh
