// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <limits>

#include "remesh/clean_steps.h"
#include "remesh/pierce.h"

namespace nacre::remesh {
namespace {

/// A closed piece with less volume, as a share of what its triangles span, has no inside: rounding.
constexpr double kLeastVolume = 1e-12;

struct Piece {
  std::size_t faces = 0, turned = 0;
  std::uint32_t first_face = kNone;
  bool closed = true;
  double volume = 0, spanned = 0;  // as the faces will be wound when joins agree
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;

  [[nodiscard]] bool solid() const { return closed && std::abs(volume) > kLeastVolume * spanned; }
  /// All faces agreed in the input already.
  [[nodiscard]] bool agrees() const { return turned == 0 || turned == faces; }
  /// Whether it faced inward as it came.
  [[nodiscard]] bool came_inward() const { return (volume < 0) == (turned == 0); }
};

std::vector<Piece> measure(const Soup& soup, const Joins& joins) {
  std::vector<Piece> pieces(joins.piece_count);
  const auto& p = soup.scan.positions;
  for (std::uint32_t f = 0; f < soup.at.size(); ++f) {
    Piece& piece = pieces[joins.piece[f]];
    const Triangle& t = soup.at[f];
    if (piece.faces++ == 0) piece.first_face = f;
    piece.turned += joins.turned[f] != 0;
    for (std::uint32_t k = 0; k < 3; ++k) piece.closed &= joins.partner[3 * f + k] != kNone;
    const Vec3& from = p[soup.at[piece.first_face][0]];
    const double volume = (p[t[0]] - from).dot((p[t[1]] - from).cross(p[t[2]] - from));
    piece.volume += joins.turned[f] ? -volume : volume;
    piece.spanned += std::abs(volume);
    for (const std::uint32_t v : t) {
      piece.low = piece.low.cwiseMin(p[v]);
      piece.high = piece.high.cwiseMax(p[v]);
    }
  }
  return pieces;
}

/// For each closed piece the outermost closed piece around it, itself if there is none.
class Enclosure {
 public:
  Enclosure(const Soup& soup, const Joins& joins, const std::vector<Piece>& pieces)
      : soup_(soup), pieces_(pieces), closed_(collect(soup, joins, pieces)), tree_(closed_) {
    for (std::uint32_t f = 0; f < soup.at.size(); ++f)
      if (pieces[joins.piece[f]].solid()) piece_.push_back(joins.piece[f]);
    for (const Piece& piece : pieces) {
      low_ = low_.cwiseMin(piece.low);
      high_ = high_.cwiseMax(piece.high);
    }
  }

  [[nodiscard]] std::uint32_t outermost(std::uint32_t piece) const {
    // By count of crossings on the way out, in three directions that no modelled face lies along,
    // because one of them may still run through an edge.
    const Vec3 from = soup_.scan.positions[soup_.at[pieces_[piece].first_face][0]];
    std::vector<std::uint32_t> around;
    for (const Vec3& direction : {Vec3(0.5377, 0.6833, 0.4939), Vec3(-0.7121, 0.3049, 0.6324),
                                  Vec3(0.2131, -0.8017, 0.5584)}) {
      std::vector<std::uint32_t> crossed;
      for (const auto& hit : tree_.hits(from, direction, 2 * (high_ - low_).norm()))
        if (hit.t > 0 && piece_[hit.point.face] != piece) crossed.push_back(piece_[hit.point.face]);
      std::sort(crossed.begin(), crossed.end());
      for (std::size_t i = 0; i < crossed.size();) {
        std::size_t end = i;
        while (end < crossed.size() && crossed[end] == crossed[i]) ++end;
        if ((end - i) % 2 == 1) around.push_back(crossed[i]);
        i = end;
      }
    }
    std::sort(around.begin(), around.end());
    std::uint32_t best = piece;
    for (std::size_t i = 1; i < around.size(); ++i) {
      if (around[i] != around[i - 1]) continue;  // at least two of three
      if (best == piece || extent(around[i]) > extent(best)) best = around[i];
    }
    return best;
  }

 private:
  static Scan collect(const Soup& soup, const Joins& joins, const std::vector<Piece>& pieces) {
    Scan closed;
    closed.positions = soup.scan.positions;
    for (std::uint32_t f = 0; f < soup.at.size(); ++f)
      if (pieces[joins.piece[f]].solid()) closed.triangles.push_back(soup.at[f]);
    return closed;
  }
  [[nodiscard]] double extent(std::uint32_t piece) const {
    return (pieces_[piece].high - pieces_[piece].low).norm();
  }

  const Soup& soup_;
  const std::vector<Piece>& pieces_;
  Scan closed_;
  LineTree tree_;
  std::vector<std::uint32_t> piece_;  // per face of closed_
  Vec3 low_ = Vec3::Constant(std::numeric_limits<double>::infinity()), high_ = -low_;
};

/// Which pieces are to be turned as a whole, once their faces agree.
std::vector<char> inward_pieces(const Soup& soup, const Joins& joins,
                                const std::vector<Piece>& pieces) {
  std::vector<char> inward(pieces.size(), 0);
  std::size_t solids = 0;
  bool any_inward = false;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Piece& piece = pieces[i];
    inward[i] = piece.solid() ? piece.volume < 0 : 2 * piece.turned > piece.faces;
    if (!piece.solid() || !piece.agrees()) continue;
    ++solids;
    any_inward |= piece.came_inward();
  }
  if (solids < 2 || !any_inward) return inward;
  const Enclosure enclosure(soup, joins, pieces);
  for (std::uint32_t i = 0; i < pieces.size(); ++i) {
    if (!pieces[i].solid() || !pieces[i].agrees()) continue;
    const Piece& outer = pieces[enclosure.outermost(i)];
    if (outer.agrees()) inward[i] = outer.came_inward() != (pieces[i].turned != 0);
  }
  return inward;
}

/// Turns a face over: corners 1 and 2 change places, so sides 0 and 2 do.
void turn(Soup& soup, Joins& joins, std::uint32_t f) {
  std::swap(soup.at[f][1], soup.at[f][2]);
  std::swap(soup.corners[f][1], soup.corners[f][2]);
  auto& partner = joins.partner;
  const std::uint32_t p0 = partner[3 * f], p2 = partner[3 * f + 2];
  partner[3 * f] = p2;
  partner[3 * f + 2] = p0;
  if (p2 != kNone) partner[p2] = 3 * f;
  if (p0 != kNone) partner[p0] = 3 * f + 2;
}

}  // namespace

void orient(Soup& soup, Joins& joins, CleanCounts& counts) {
  const std::vector<Piece> pieces = measure(soup, joins);
  const std::vector<char> inward = inward_pieces(soup, joins, pieces);
  std::vector<char> whole(pieces.size(), 0);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    whole[i] = pieces[i].turned == (inward[i] ? 0 : pieces[i].faces);
    if (whole[i]) counts.inside_out.add(soup.source[pieces[i].first_face]);
  }
  for (std::uint32_t f = 0; f < soup.at.size(); ++f) {
    joins.turned[f] = (joins.turned[f] != 0) != (inward[joins.piece[f]] != 0);
    if (!joins.turned[f]) continue;
    turn(soup, joins, f);
    if (!whole[joins.piece[f]]) counts.reoriented.add(soup.source[f]);
  }
  for (auto& sides : joins.crowded)
    for (std::uint32_t& s : sides)
      if (joins.turned[s / 3]) s = s - s % 3 + (2 - s % 3);
}

}  // namespace nacre::remesh
