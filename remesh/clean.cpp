// SPDX-License-Identifier: GPL-3.0-or-later
//
// Read me first: the soup becomes a manifold by deciding, for every side of every face, which
// single other face it joins (or none). All later topology follows from these joins alone: a vertex
// whose faces fall into several fans of joined faces becomes several vertices. So no case of
// non-manifold input needs a rule of its own, and what is reported is what came of it: a vertex
// counts as welded or split by where its faces went.
#include "remesh/clean_steps.h"
#include "remesh/fill_loops.h"
#include "remesh/side_groups.h"

namespace nacre::remesh {
namespace {

/// What dropping small pieces may add to the error, as a share of the largest piece's extent: with
/// the few per cent of the area that they have, below what 90 dB leave.
constexpr double kSmallError = 5e-4;

bool has_area(const Scan& scan) {
  return std::any_of(scan.triangles.begin(), scan.triangles.end(), [&](const Triangle& t) {
    return (scan.positions[t[1]] - scan.positions[t[0]])
               .cross(scan.positions[t[2]] - scan.positions[t[0]])
               .squaredNorm() > 0;
  });
}

/// Pin holes, tiny handles, and small pieces wherever they lie.
void repair_aggressively(CleanScan& cleaned, std::vector<std::uint32_t>& source,
                         CleanCounts& counts) {
  const std::size_t before = cleaned.scan.triangles.size();
  fill_pin_holes(cleaned, source, counts);
  const bool handles = std::any_of(cleaned.pieces.begin(), cleaned.pieces.end(),
                                   [](const PieceReport& piece) { return piece.genus > 0; });
  if (handles) cut_tiny_handles(cleaned, source, counts);
  if (cleaned.scan.triangles.size() == before) return;
  count_topology(cleaned, static_cast<std::uint32_t>(cleaned.pieces.size()),
                 side_partners(cleaned.scan.triangles, cleaned.scan.positions.size()));
}

/// `source` becomes the input face of each triangle.
CleanScan make_manifold(const Scan& scan, CleanCounts& counts, std::vector<std::uint32_t>& source) {
  Soup soup = make_soup(scan, counts);
  const bool layers = drop_faces(soup, counts);
  while (true) {
    CleanCounts now = counts;
    Soup work = layers ? soup : std::move(soup);
    Joins joins = join_sides(work, now);
    orient(work, joins, now);
    CleanScan cleaned = part_vertices(work, joins, now);
    if (layers && drop_loosened(soup, cleaned.scan, work.source, counts)) continue;
    count_topology(cleaned, joins.piece_count, joins.partner);
    counts = now;
    source = std::move(work.source);
    return cleaned;
  }
}

void sum_up(CleanScan& cleaned, const CleanCounts& counts) {
  CleanReport& r = cleaned.report;
  for (const Counter* c :
       {&counts.welded, &counts.isolated, &counts.degenerate, &counts.duplicate, &counts.crowded,
        &counts.one_sided, &counts.parted, &counts.doubled, &counts.reoriented, &counts.inside_out,
        &counts.small, &counts.holes, &counts.handles})
    c->append_to(r);
  r.vertices = cleaned.scan.positions.size();
  r.triangles = cleaned.scan.triangles.size();
  r.pieces = cleaned.pieces.size();
  for (const PieceReport& piece : cleaned.pieces) {
    r.closed_pieces += piece.boundary_loops == 0;
    r.boundary_loops += piece.boundary_loops;
    r.genus += piece.genus;
  }
}

Result<void> check_policy(const CleanReport& report, RepairPolicy policy) {
  if (policy == RepairPolicy::kSafe || policy == RepairPolicy::kAggressive) return {};
  for (const CleanAction& action : report.actions) {
    const bool harmless =
        action.kind == "welded vertices" || action.kind == "dropped isolated vertices";
    if (policy == RepairPolicy::kStrict && harmless) continue;
    return Error{ErrorCode::kGeometryRefused,
                 "needs " + std::to_string(action.count) + " " + action.kind + " (first at " +
                     std::to_string(action.first_ids.front()) +
                     "), which this repair policy forbids; allow it with --repair safe",
                 action.first_ids.front()};
  }
  return {};
}

}  // namespace

Result<CleanScan> clean(const Scan& scan, RepairPolicy policy, double small_extent) {
  if (!(small_extent >= 0 && small_extent < 1))
    return Error{ErrorCode::kBadInput, "the extent of small pieces must be 0 .. 1 diagonals", 0};
  for (std::size_t v = 0; v < scan.positions.size(); ++v) {
    if (!scan.positions[v].allFinite())
      return Error{ErrorCode::kBadInput, "vertex " + std::to_string(v) + " is not finite", v};
  }
  CleanCounts counts;
  std::vector<std::uint32_t> source;
  CleanScan cleaned = make_manifold(scan, counts, source);
  if (cleaned.scan.triangles.empty())
    return Error{ErrorCode::kGeometryRefused, "no triangle of three different corners is left", 0};
  if (!has_area(cleaned.scan))
    return Error{ErrorCode::kGeometryRefused, "no triangle has any area", 0};
  const bool aggressive = policy == RepairPolicy::kAggressive;
  if ((aggressive || policy == RepairPolicy::kSafe) && small_extent > 0)
    drop_small_pieces(
        cleaned, source,
        {small_extent, aggressive ? std::numeric_limits<double>::infinity() : kSmallError}, counts);
  if (aggressive) repair_aggressively(cleaned, source, counts);
  sum_up(cleaned, counts);
  if (const auto ok = check_policy(cleaned.report, policy); !ok) return ok.error();
  return cleaned;
}

}  // namespace nacre::remesh
