// SPDX-License-Identifier: GPL-3.0-or-later
#include <array>
#include <bit>
#include <numeric>
#include <tuple>

#include "remesh/clean_steps.h"
#include "remesh/side_groups.h"

namespace nacre::remesh {
namespace {

std::uint64_t mixed(std::uint64_t x) {  // [Steele2014] SplitMix64
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}

/// Equal for equal points, and nearly always only for these.
std::uint64_t key_of(const Vec3& p) {
  std::uint64_t key = 0;
  for (int i = 0; i < 3; ++i)  // adding 0 makes one of the two zeros
    key = mixed(key * 0x9E3779B97F4A7C15u + std::bit_cast<std::uint64_t>(p[i] + 0.0) + 1);
  return key;
}

std::vector<std::uint32_t> places(const std::vector<Vec3>& p) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order(p.size());
  for (std::uint32_t v = 0; v < p.size(); ++v) order[v] = {key_of(p[v]), v};
  std::sort(order.begin(), order.end());
  std::vector<std::uint32_t> place(p.size());
  for (std::size_t i = 0; i < order.size();) {
    std::size_t end = i + 1;
    while (end < order.size() && order[end].first == order[i].first) ++end;
    const auto point = [&](const auto& entry) {
      const Vec3& q = p[entry.second];
      return std::tuple(q[0], q[1], q[2], entry.second);
    };
    if (end - i > 1)
      std::sort(order.begin() + static_cast<std::ptrdiff_t>(i),
                order.begin() + static_cast<std::ptrdiff_t>(end),
                [&](const auto& a, const auto& b) { return point(a) < point(b); });
    for (std::size_t k = i; k < end; ++k) {
      const std::uint32_t v = order[k].second;
      place[v] = k > i && p[v] == p[order[k - 1].second] ? place[order[k - 1].second] : v;
    }
    i = end;
  }
  return place;
}

Triangle sorted(Triangle t) {
  if (t[0] > t[1]) std::swap(t[0], t[1]);
  if (t[1] > t[2]) std::swap(t[1], t[2]);
  if (t[0] > t[1]) std::swap(t[0], t[1]);
  return t;
}

void remove(Soup& soup, const std::vector<char>& drop) {
  std::size_t kept = 0;
  for (std::size_t f = 0; f < soup.at.size(); ++f) {
    if (drop[f]) continue;
    soup.at[kept] = soup.at[f];
    soup.corners[kept] = soup.corners[f];
    soup.source[kept++] = soup.source[f];
  }
  soup.at.resize(kept);
  soup.corners.resize(kept);
  soup.source.resize(kept);
}

void drop_degenerate(Soup& soup, Counter& count) {
  std::vector<char> drop(soup.at.size(), 0);
  bool any = false;
  for (std::size_t f = 0; f < soup.at.size(); ++f) {
    const Triangle& t = soup.at[f];
    drop[f] = t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
    if (drop[f]) count.add(soup.source[f]);
    any |= drop[f] != 0;
  }
  if (any) remove(soup, drop);
}

/// Faces that have an earlier one on the same corners.
struct Duplicates {
  std::vector<std::uint32_t> by_number, by_place;  // not in both
};

Duplicates find_duplicates(const Soup& soup) {
  // In buckets by the lowest corner, like sides in for_each_edge().
  std::vector<std::uint32_t> start(soup.scan.positions.size() + 2, 0);
  for (const Triangle& t : soup.at) ++start[std::min({t[0], t[1], t[2]}) + 2];
  for (std::size_t v = 2; v < start.size(); ++v) start[v] += start[v - 1];
  std::vector<std::uint32_t> faces(soup.at.size());
  for (std::uint32_t f = 0; f < soup.at.size(); ++f) {
    const Triangle& t = soup.at[f];
    faces[start[std::min({t[0], t[1], t[2]}) + 1]++] = f;
  }
  Duplicates found;
  using Key = std::array<std::uint32_t, 6>;  // other two places, three vertices, face
  std::vector<Key> keys;
  for (std::size_t v = 0; v + 2 < start.size(); ++v) {
    if (start[v + 1] - start[v] < 2) continue;
    keys.clear();
    for (std::uint32_t i = start[v]; i < start[v + 1]; ++i) {
      const Triangle t = sorted(soup.at[faces[i]]), c = sorted(soup.corners[faces[i]]);
      keys.push_back({t[1], t[2], c[0], c[1], c[2], faces[i]});
    }
    std::sort(keys.begin(), keys.end());
    for (std::size_t i = 0; i < keys.size();) {
      std::size_t end = i + 1, first = i;
      while (end < keys.size() && keys[end][0] == keys[i][0] && keys[end][1] == keys[i][1]) ++end;
      for (std::size_t k = i; k < end; ++k)
        if (keys[k][5] < keys[first][5]) first = k;
      for (std::size_t k = i; k < end; ++k) {
        const bool repeats =
            k > i && std::equal(keys[k].begin() + 2, keys[k].begin() + 5, keys[k - 1].begin() + 2);
        if (repeats)
          found.by_number.push_back(keys[k][5]);
        else if (k != first)
          found.by_place.push_back(keys[k][5]);
      }
      i = end;
    }
  }
  return found;
}

/// Of the faces that `again` marks, those that may go: they reach a boundary through one another,
/// or nothing else hangs on them. Dropping the others would tear holes.
std::vector<char> without_tearing(const Soup& soup, const std::vector<char>& again) {
  const auto partner = side_partners(soup.corners, soup.scan.positions.size());
  std::vector<char> seen(again.size(), 0), drop(again.size(), 0);
  std::vector<std::uint32_t> patch;
  for (std::uint32_t seed = 0; seed < again.size(); ++seed) {
    if (!again[seed] || seen[seed]) continue;
    bool at_boundary = false, alone = true;
    patch.assign(1, seed);
    seen[seed] = 1;
    for (std::size_t head = 0; head < patch.size(); ++head) {
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t side = partner[3 * patch[head] + k];
        if (side == kNone) {
          at_boundary = true;
        } else if (!again[side / 3]) {
          alone = false;
        } else if (!seen[side / 3]) {
          seen[side / 3] = 1;
          patch.push_back(side / 3);
        }
      }
    }
    if (!at_boundary && !alone) continue;
    for (const std::uint32_t f : patch) drop[f] = 1;
  }
  return drop;
}

}  // namespace

Soup make_soup(const Scan& scan, CleanCounts& counts) {
  Soup soup{scan, places(scan.positions), scan.triangles, {}, {}};
  soup.at.reserve(scan.triangles.size());
  std::vector<char> used(scan.positions.size(), 0);
  for (const Triangle& t : scan.triangles) {
    for (const std::uint32_t v : t) used[v] = 1;
    soup.at.push_back({soup.place[t[0]], soup.place[t[1]], soup.place[t[2]]});
  }
  soup.source.resize(scan.triangles.size());
  std::iota(soup.source.begin(), soup.source.end(), 0u);
  for (std::uint32_t v = 0; v < used.size(); ++v)
    if (!used[v]) counts.isolated.add(v);
  return soup;
}

bool drop_faces(Soup& soup, CleanCounts& counts) {
  drop_degenerate(soup, counts.degenerate);
  const auto drop_duplicates = [&](const std::vector<char>& drop) {
    for (std::size_t f = 0; f < drop.size(); ++f)
      if (drop[f]) counts.duplicate.add(soup.source[f]);
    remove(soup, drop);
  };
  const auto marked = [&](const std::vector<std::uint32_t>& faces) {
    std::vector<char> mark(soup.at.size(), 0);
    for (const std::uint32_t f : faces) mark[f] = 1;
    return mark;
  };
  Duplicates found = find_duplicates(soup);
  if (!found.by_number.empty()) {
    drop_duplicates(marked(found.by_number));
    if (!found.by_place.empty()) found = find_duplicates(soup);
  }
  if (found.by_place.empty()) return false;
  const std::size_t before = soup.at.size();
  drop_duplicates(without_tearing(soup, marked(found.by_place)));
  return before - soup.at.size() < found.by_place.size();
}

bool drop_loosened(Soup& soup, const Scan& cleaned, std::span<const std::uint32_t> source,
                   CleanCounts& counts) {
  CleanCounts ignored;
  Soup again = make_soup(cleaned, ignored);
  std::copy(source.begin(), source.end(), again.source.begin());
  drop_faces(again, ignored);
  if (again.at.size() == cleaned.triangles.size()) return false;
  // By their number: a face may have been cut in two.
  std::vector<std::uint32_t> left(soup.scan.triangles.size(), 0);
  for (const std::uint32_t f : source) ++left[f];
  for (const std::uint32_t f : again.source) --left[f];
  std::vector<char> drop(soup.at.size(), 0);
  for (std::size_t f = 0; f < drop.size(); ++f) {
    drop[f] = left[soup.source[f]] > 0;
    if (drop[f]) counts.duplicate.add(soup.source[f]);
  }
  remove(soup, drop);
  return true;
}

}  // namespace nacre::remesh
