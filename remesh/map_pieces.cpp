// SPDX-License-Identifier: GPL-3.0-or-later
//
// Read me first: all pieces are mapped together, as if they were one, and the trial mesh tells how
// each came out. Nearly always all are healthy, and that is all. Where one is not, it takes base
// vertices from the others, so that these are mapped once more without it.
#include "remesh/map_pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>

#include "remesh/base_size.h"
#include "remesh/choose_base.h"
#include "remesh/clean_steps.h"
#include "remesh/kept_pieces.h"
#include "remesh/split_edges.h"

namespace nacre::remesh {
namespace {

/// No triangle is larger than it would be if this many equal ones covered the scan.
constexpr double kLeastTriangles = 20'000;

/// A piece is unhealthy whose trial mesh has more than this share of its triangles folded,
constexpr double kMostFolded = 0.01;
/// or will be farther from the scan than this many times what half of the scan will be,
constexpr double kTimesUsual = 4;
/// if that is more than this share of the scan's extent: 75 dB.
constexpr double kMostError = 1.8e-4;
/// What one level more leaves of the error of unhealthy pieces. Healthy ones keep less.
constexpr double kErrorPerLevel = 0.5;

/// Rounds with a denser base, each with so many times the vertices, up to this share of the
/// piece's own triangles.
constexpr int kRounds = 2;
constexpr std::size_t kDenser = 4;
constexpr double kMostOfOwn = 0.25;
/// Unhealthy pieces together may have so many base triangles, or as many as all others.
constexpr std::size_t kMostBaseTriangles = 2500;
/// The others are mapped again if unhealthy ones took more than this share of the base.
constexpr double kMuchOfBase = 0.1;

/// Some of the scan's pieces with a map of their own.
struct Part {
  std::vector<std::uint32_t> pieces;                      ///< their numbers in the whole, ascending
  std::shared_ptr<Scan> scan = std::make_shared<Scan>();  ///< stays where it is: `tree` is of it
  std::vector<std::uint32_t> piece;                       ///< per triangle: number in the whole
  Parameterisation map;
  std::vector<Health> health;                              ///< per entry of `pieces`
  std::vector<std::size_t> base_triangles, base_vertices;  ///< the same
  std::size_t scan_triangles = 0;                          ///< before long edges were split
  std::shared_ptr<const LineTree> tree;
};

/// The pieces with the given numbers, numbered anew in that order.
CleanScan select(const CleanScan& cleaned, const std::vector<std::uint32_t>& pieces) {
  CleanScan out;
  std::vector<std::uint32_t> number(cleaned.pieces.size(), kNone);
  for (std::uint32_t i = 0; i < pieces.size(); ++i) {
    number[pieces[i]] = i;
    out.pieces.push_back(cleaned.pieces[pieces[i]]);
  }
  std::vector<std::uint32_t> id(cleaned.scan.positions.size(), kNone);
  for (std::size_t f = 0; f < cleaned.scan.triangles.size(); ++f) {
    const std::uint32_t piece = number[cleaned.piece[f]];
    if (piece == kNone) continue;
    for (const std::uint32_t v : cleaned.scan.triangles[f]) id[v] = 0;
    out.piece.push_back(piece);
    out.scan.triangles.push_back(cleaned.scan.triangles[f]);
  }
  for (std::size_t v = 0; v < id.size(); ++v) {
    if (id[v] == kNone) continue;
    id[v] = static_cast<std::uint32_t>(out.scan.positions.size());
    out.scan.positions.push_back(cleaned.scan.positions[v]);
  }
  for (Triangle& t : out.scan.triangles)
    for (std::uint32_t& v : t) v = id[v];
  out.scan.origin = cleaned.scan.origin;
  return out;
}

double extent_of(const Scan& scan) {
  Box box;
  for (const Vec3& p : scan.positions) box.add(p);
  return box.extent();
}

/// Counts, per piece, what of the base and of the trial is its own.
void count_base(const std::vector<Health>& health, std::size_t piece_count, Part& part) {
  std::vector<std::uint32_t> piece_of_vertex(part.scan->positions.size(), 0),
      place(piece_count, kNone);
  for (std::uint32_t i = 0; i < part.pieces.size(); ++i) place[part.pieces[i]] = i;
  for (std::size_t f = 0; f < part.piece.size(); ++f)
    for (const std::uint32_t v : part.scan->triangles[f]) piece_of_vertex[v] = place[part.piece[f]];
  part.health.resize(part.pieces.size());
  part.base_triangles.assign(part.pieces.size(), 0);
  part.base_vertices.assign(part.pieces.size(), 0);
  const BaseMesh& base = part.map.base;
  for (const std::uint32_t v : base.scan_vertex) ++part.base_vertices[piece_of_vertex[v]];
  for (std::size_t f = 0; f < base.triangles.size(); ++f) {
    const std::uint32_t piece = piece_of_vertex[base.scan_vertex[base.triangles[f][0]]];
    ++part.base_triangles[piece];
    if (f < health.size())
      part.health[piece] += health[f];
    else
      part.health[piece].is_finite = false;  // no trial came to an end
  }
}

/// The scan's own triangles as base of these pieces.
Part kept_part(const CleanScan& cleaned, const std::vector<std::uint32_t>& pieces) {
  CleanScan selected = select(cleaned, pieces);
  Part part;
  part.pieces = pieces;
  *part.scan = std::move(selected.scan);
  for (const std::uint32_t p : selected.piece) part.piece.push_back(pieces[p]);
  part.map = identity(*part.scan);
  count_base({}, cleaned.pieces.size(), part);
  return part;
}

/// The pieces with the given numbers, as they are mapped in `from`.
Part cut_out(const Part& from, const std::vector<std::uint32_t>& pieces) {
  Part part;
  part.pieces = pieces;
  part.scan_triangles = from.scan_triangles;
  part.scan->origin = from.scan->origin;
  std::vector<std::uint32_t> vertex(from.scan->positions.size(), kNone),
      corner(from.map.base.scan_vertex.size(), kNone), face(from.map.base.triangles.size(), kNone);
  for (std::size_t f = 0; f < from.piece.size(); ++f) {
    if (!std::binary_search(pieces.begin(), pieces.end(), from.piece[f])) continue;
    part.piece.push_back(from.piece[f]);
    part.scan->triangles.push_back(from.scan->triangles[f]);
    for (const std::uint32_t v : from.scan->triangles[f]) vertex[v] = 0;
  }
  for (std::size_t v = 0; v < vertex.size(); ++v) {
    if (vertex[v] == kNone) continue;
    vertex[v] = static_cast<std::uint32_t>(part.scan->positions.size());
    part.scan->positions.push_back(from.scan->positions[v]);
    part.map.point.push_back(from.map.point[v]);
  }
  const BaseMesh& base = from.map.base;
  for (std::size_t c = 0; c < corner.size(); ++c) {
    if (vertex[base.scan_vertex[c]] == kNone) continue;
    corner[c] = static_cast<std::uint32_t>(part.map.base.scan_vertex.size());
    part.map.base.scan_vertex.push_back(vertex[base.scan_vertex[c]]);
  }
  for (std::size_t f = 0; f < face.size(); ++f) {
    if (corner[base.triangles[f][0]] == kNone) continue;
    face[f] = static_cast<std::uint32_t>(part.map.base.triangles.size());
    part.map.base.triangles.push_back(base.triangles[f]);
    part.map.base.neighbors.push_back(base.neighbors[f]);
  }
  const auto renumber = [](std::vector<Triangle>& triangles, const auto& number) {
    for (Triangle& t : triangles)
      for (std::uint32_t& x : t)
        if (x != kNone) x = number[x];
  };
  renumber(part.scan->triangles, vertex);
  renumber(part.map.base.triangles, corner);
  renumber(part.map.base.neighbors, face);
  for (DomainPoint& p : part.map.point) p.face = face[p.face];
  for (std::size_t i = 0; i < from.pieces.size(); ++i) {
    if (!std::binary_search(pieces.begin(), pieces.end(), from.pieces[i])) continue;
    part.health.push_back(from.health[i]);
    part.base_triangles.push_back(from.base_triangles[i]);
    part.base_vertices.push_back(from.base_vertices[i]);
  }
  return part;
}

/// What healthy is, in one scan.
struct Yardstick {
  double extent = 1, most_error = 0;
  int levels = 0;  ///< that the mesh will have

  /// As it will be, from a trial mesh that may be coarser.
  [[nodiscard]] double error_of(const Health& health) const {
    return health.error() * std::pow(kErrorPerLevel, std::max(levels - health.levels, 0));
  }
  /// Empty: it is.
  [[nodiscard]] std::string fault_of(const Health& health) const {
    const auto percent = [](double share) {
      const std::string text = std::to_string(100 * share);
      return text.substr(0, text.find('.') + 4) + " %";
    };
    if (!health.is_finite || !std::isfinite(health.error())) return "no mesh";
    const double triangles = static_cast<double>(std::max<std::size_t>(health.triangles, 1));
    const double folded = static_cast<double>(health.folds) / triangles;
    if (folded > kMostFolded) return percent(folded) + " of its triangles folded";
    if (error_of(health) > most_error)
      return "about " + percent(error_of(health) / extent) + " of the scan's extent off";
    return "";
  }
};

/// What is usual is asked of tangled pieces as well if the others are less than this share: else a
/// speck would say what is healthy.
constexpr double kLeastUntangled = 0.25;

/// Per entry of `part.pieces`: whether it is to say what is usual.
std::vector<char> without_tangled(const Part& part, const std::vector<PieceSurface>& surfaces) {
  std::vector<char> counts(part.pieces.size(), 1);
  double all = 0, smooth = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const PieceSurface& surface = surfaces[part.pieces[i]];
    counts[i] = !surface.is_tangled();
    all += surface.size;
    smooth += counts[i] * surface.size;
  }
  if (smooth < kLeastUntangled * all) counts.assign(counts.size(), 1);
  return counts;
}

/// The error that half of the scan, by samples, does not pass. Tangled pieces would have most of
/// the samples: proxies keep more vertices of them.
double usual_error(const Part& part, const std::vector<PieceSurface>& surfaces,
                   const Yardstick& yardstick) {
  const std::vector<char> counts = without_tangled(part, surfaces);
  std::vector<std::pair<double, std::size_t>> errors;
  std::size_t all = 0, so_far = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (!counts[i]) continue;
    errors.emplace_back(yardstick.error_of(part.health[i]), part.health[i].missed.count);
    all += part.health[i].missed.count;
  }
  std::sort(errors.begin(), errors.end());
  for (const auto& [error, count] : errors) {
    so_far += count;
    if (2 * so_far >= all) return error;
  }
  return 0;
}

class Mapper {
 public:
  Mapper(const CleanScan& cleaned, const Options& options, const RunContext& context)
      : cleaned_(cleaned),
        options_(options),
        context_(context),
        side_(side_for_count(cleaned.scan, kLeastTriangles)),
        surfaces_(piece_surfaces(cleaned)),
        reports_(cleaned.pieces) {
    yardstick_.extent = extent_of(cleaned.scan);
  }

  Result<MappedScan> run(int useful) {
    std::vector<std::uint32_t> all(cleaned_.pieces.size());
    std::iota(all.begin(), all.end(), 0u);
    if (side_ == 0) return Error{ErrorCode::kGeometryRefused, "no triangle has an area", 0};
    auto together = map(all, nullptr, useful);
    if (!together) {
      const ErrorCode code = together.error().code;
      if (code == ErrorCode::kCancelled || (useful > 0 && code == ErrorCode::kNoConvergence))
        return together.error();
      if (const auto ok = map_apart(all, together.error().message); !ok) return ok.error();
      return joined();
    }
    if (const auto ok = mend(std::move(*together)); !ok) return ok.error();
    return joined();
  }

 private:
  /// `size`: null for what the pieces ask for.
  Result<Part> map(const std::vector<std::uint32_t>& pieces, const BaseSize* size, int useful = 0) {
    CleanScan selected = select(cleaned_, pieces);
    Part part;
    part.pieces = pieces;
    part.scan_triangles = selected.scan.triangles.size();
    split_long_edges(selected, side_,
                     4 * static_cast<std::size_t>(kLeastTriangles) + part.scan_triangles);
    split_chords(selected);
    *part.scan = std::move(selected.scan);
    part.piece = std::move(selected.piece);
    for (std::uint32_t& p : part.piece) p = pieces[p];
    BaseSize usual = base_size(options_, selected.pieces, part.scan->positions.size());
    usual.useful = useful;
    usual.few_trials = options_.few_trials;
    auto choice = choose_base(*part.scan, size != nullptr ? *size : usual, options_.levels,
                              options_.predict, context_);
    if (!choice) return choice.error();
    if (context_.cancelled()) return Error{ErrorCode::kCancelled, "interrupted", 0};
    part.map = std::move(choice->map);
    part.tree = std::move(choice->tree);
    count_base(choice->health, cleaned_.pieces.size(), part);
    return part;
  }

  /// Pieces that could not be mapped together: in halves, and what cannot be mapped alone is kept.
  Result<void> map_apart(const std::vector<std::uint32_t>& pieces, const std::string& why) {
    if (pieces.size() == 1) {
      keep_piece(pieces[0], why);
      return {};
    }
    const auto half = pieces.begin() + static_cast<std::ptrdiff_t>(pieces.size() / 2);
    for (const auto& some : {std::vector<std::uint32_t>(pieces.begin(), half),
                             std::vector<std::uint32_t>(half, pieces.end())}) {
      auto part = map(some, nullptr);
      if (part) {
        parts_.push_back(std::move(*part));
        continue;
      }
      if (part.error().code == ErrorCode::kCancelled) return part.error();
      if (const auto ok = map_apart(some, part.error().message); !ok) return ok;
    }
    return {};
  }

  void keep_piece(std::uint32_t piece, const std::string& why) {
    kept_.push_back(piece);
    reports_[piece].fallback = "its own triangles are the base: " + why;
    reports_[piece].is_own_base = true;
  }

  /// Looks at what was mapped together, and maps again what is unhealthy.
  Result<void> mend(Part together) {
    set_yardstick(together);
    std::vector<std::size_t> ill;
    std::vector<std::uint32_t> well;
    std::size_t base_of_ill = 0;
    for (std::size_t i = 0; i < together.pieces.size(); ++i) {
      if (yardstick_.fault_of(together.health[i]).empty()) {
        well.push_back(together.pieces[i]);
      } else {
        ill.push_back(i);
        base_of_ill += together.base_triangles[i];
      }
    }
    if (ill.empty()) {
      if (const auto ok = densify(together); !ok) return ok;
      parts_.push_back(std::move(together));
      return {};
    }
    const auto base = static_cast<double>(together.map.base.triangles.size());
    if (!well.empty()) {
      if (static_cast<double>(base_of_ill) <= kMuchOfBase * base)
        parts_.push_back(cut_out(together, well));
      else if (const auto ok = map_again(well); !ok)
        return ok;
    }
    std::size_t room = kMostBaseTriangles;
    for (const Part& part : parts_) room = std::max(room, part.map.base.triangles.size());
    if (well.empty()) room = std::max(room, cleaned_.scan.triangles.size() / 4);
    if (options_.most_base_vertices > 0)
      room = std::min(room, static_cast<std::size_t>(options_.most_base_vertices));
    return map_ill(together, std::move(ill), std::max(room, base_of_ill));
  }

  /// A single piece on a denser base where the levels that it has will not take it close to the
  /// scan, if that helps.
  Result<void> densify(Part& part) {
    if (part.pieces.size() > 1 || !is_free(options_)) return {};
    BaseSize size;
    size.few_trials = options_.few_trials;
    size.vertices = denser_base(part.map.base.scan_vertex.size(), part.scan->positions.size(),
                                yardstick_.error_of(part.health[0]) / yardstick_.extent);
    if (size.vertices == 0) return {};
    auto denser = map(part.pieces, &size);
    if (!denser && denser.error().code == ErrorCode::kCancelled) return denser.error();
    // With as many splits: one less would take back what is gained.
    if (denser && yardstick_.fault_of(denser->health[0]).empty() &&
        yardstick_.error_of(denser->health[0]) < yardstick_.error_of(part.health[0]))
      part = std::move(*denser);
    return {};
  }

  /// Where base and levels are not free, healthy is what half of the scan is.
  void set_yardstick(const Part& together) {
    levels_ = levels_for(together);
    yardstick_.levels = levels_;
    yardstick_.most_error = most_error_beside(together);
    if (together.pieces.size() == 1)
      yardstick_.most_error = is_free(options_) ? kMostError * yardstick_.extent
                                                : std::numeric_limits<double>::infinity();
  }

  /// Pieces may be so far off beside these.
  [[nodiscard]] double most_error_beside(const Part& part) const {
    return std::max(kTimesUsual * usual_error(part, surfaces_, yardstick_),
                    kMostError * yardstick_.extent);
  }

  [[nodiscard]] int levels_for(const Part& part) const {
    return options_.levels > 0 ? options_.levels
                               : default_levels(part.scan_triangles, part.map.base.triangles.size(),
                                                options_.least_triangles);
  }

  Result<void> map_again(const std::vector<std::uint32_t>& pieces) {
    auto part = map(pieces, nullptr);
    if (!part && part.error().code == ErrorCode::kCancelled) return part.error();
    if (!part) return map_apart(pieces, part.error().message);
    levels_ = levels_for(*part);
    yardstick_.levels = levels_;
    // These had less of the base before, and what is usual was worse.
    yardstick_.most_error = std::min(yardstick_.most_error, most_error_beside(*part));
    parts_.push_back(std::move(*part));
    return {};
  }

  /// Smaller ones first, so that as many as possible find room.
  Result<void> map_ill(const Part& together, std::vector<std::size_t> ill, std::size_t room) {
    const auto triangles = [&](std::size_t i) {
      return cleaned_.pieces[together.pieces[i]].triangles;
    };
    std::stable_sort(ill.begin(), ill.end(),
                     [&](std::size_t a, std::size_t b) { return triangles(a) < triangles(b); });
    for (const std::size_t i : ill) {
      const auto used = map_one(together, i, room);
      if (!used) return used.error();
      room -= std::min(room, *used);
    }
    return {};
  }

  /// Returns the base triangles that it came to.
  Result<std::size_t> map_one(const Part& together, std::size_t i, std::size_t room) {
    const std::uint32_t piece = together.pieces[i];
    const std::size_t own = cleaned_.pieces[piece].triangles;
    Part best = cut_out(together, {piece});
    std::string fault = yardstick_.fault_of(best.health[0]);
    std::string why =
        fault + " on a base of " + std::to_string(best.base_triangles[0]) + " triangles";
    bool is_denser = false;
    for (int round = 0; round < kRounds && !fault.empty(); ++round) {
      const std::size_t now = best.base_vertices[0];
      BaseSize size;
      size.vertices = static_cast<int>(
          std::min({kDenser * now, room / 2,
                    static_cast<std::size_t>(kMostOfOwn * static_cast<double>(own))}));
      size.one_trial = true;
      if (static_cast<std::size_t>(size.vertices) <= now + now / 4) break;
      auto part = map({piece}, &size);
      if (!part && part.error().code == ErrorCode::kCancelled) return part.error();
      if (!part) break;
      const std::string again = yardstick_.fault_of(part->health[0]);
      if (!again.empty()) {
        why += ", " + again + " on one of " + std::to_string(part->base_triangles[0]);
        if (yardstick_.error_of(part->health[0]) >= yardstick_.error_of(best.health[0])) break;
      }
      best = std::move(*part);
      fault = again;
      is_denser = true;
    }
    if (!fault.empty() && (own <= room || !best.health[0].is_finite)) {
      keep_piece(piece, why);
      return own;
    }
    std::string& report = reports_[piece].fallback;
    report = (is_denser ? "a denser base: " : "as usual all the same: ") + why;
    if (!fault.empty())
      report += "; a base of its own " + std::to_string(own) + " triangles is too large";
    parts_.push_back(std::move(best));
    return parts_.back().base_triangles[0];
  }

  Result<MappedScan> joined() {
    MappedScan out;
    if (levels_ == 0) levels_ = parts_.empty() ? options_.levels : levels_for(parts_[0]);
    out.levels = std::max(levels_, 1);
    std::sort(kept_.begin(), kept_.end());
    if (!kept_.empty()) parts_.push_back(kept_part(cleaned_, kept_));
    if (parts_.size() == 1 && kept_.empty()) out.tree = parts_[0].tree;
    auto scan = std::make_shared<Scan>();
    scan->origin = cleaned_.scan.origin;
    for (Part& part : parts_) {
      for (std::size_t i = 0; i < part.pieces.size(); ++i) {
        reports_[part.pieces[i]].base_triangles = part.base_triangles[i];
        reports_[part.pieces[i]].base_vertices = part.base_vertices[i];
      }
      if (parts_.size() == 1) {
        scan = part.scan;
        out.map = std::move(part.map);
      } else {
        append(part, *scan, out.map);
      }
    }
    out.scan = scan;
    out.pieces = std::move(reports_);
    return out;
  }

  static void append(const Part& part, Scan& scan, Parameterisation& map) {
    const auto vertices = static_cast<std::uint32_t>(scan.positions.size());
    const auto corners = static_cast<std::uint32_t>(map.base.scan_vertex.size());
    const auto faces = static_cast<std::uint32_t>(map.base.triangles.size());
    const auto shifted = [](Triangle t, std::uint32_t by) {
      for (std::uint32_t& x : t)
        if (x != kNone) x += by;
      return t;
    };
    scan.positions.insert(scan.positions.end(), part.scan->positions.begin(),
                          part.scan->positions.end());
    for (const Triangle& t : part.scan->triangles) scan.triangles.push_back(shifted(t, vertices));
    for (const Triangle& t : part.map.base.triangles)
      map.base.triangles.push_back(shifted(t, corners));
    for (const Triangle& t : part.map.base.neighbors)
      map.base.neighbors.push_back(shifted(t, faces));
    for (const std::uint32_t v : part.map.base.scan_vertex)
      map.base.scan_vertex.push_back(v + vertices);
    for (DomainPoint p : part.map.point) {
      p.face += faces;
      map.point.push_back(p);
    }
  }

  const CleanScan& cleaned_;
  const Options& options_;
  const RunContext& context_;
  double side_;  // of the scan's largest triangles, once split
  int levels_ = 0;
  Yardstick yardstick_;
  std::vector<PieceSurface> surfaces_;  // per piece
  std::vector<PieceReport> reports_;
  std::vector<Part> parts_;          // those of the healthy first
  std::vector<std::uint32_t> kept_;  // pieces
};

}  // namespace

Result<MappedScan> map_pieces(const CleanScan& cleaned, const Options& options, int useful,
                              const RunContext& context) {
  return Mapper(cleaned, options, context).run(useful);
}

MappedScan keep(CleanScan cleaned, int levels, const char* why) {
  MappedScan out;
  std::vector<std::uint32_t> all(cleaned.pieces.size());
  std::iota(all.begin(), all.end(), 0u);
  out.levels = levels;
  out.is_kept = true;
  Part part;
  part.pieces = all;
  *part.scan = std::move(cleaned.scan);
  part.piece = std::move(cleaned.piece);
  part.map = identity(*part.scan);
  count_base({}, all.size(), part);
  for (std::size_t i = 0; i < all.size(); ++i) {
    cleaned.pieces[i].fallback = why;
    cleaned.pieces[i].is_own_base = true;
    cleaned.pieces[i].base_triangles = part.base_triangles[i];
    cleaned.pieces[i].base_vertices = part.base_vertices[i];
  }
  out.map = std::move(part.map);
  out.scan = part.scan;
  out.pieces = std::move(cleaned.pieces);
  return out;
}

}  // namespace nacre::remesh
