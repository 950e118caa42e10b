// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "base/scan.h"
#include "base/semi_regular_mesh.h"
#include "remesh/observer.h"

/// Raw scan → cleaned pieces → base mesh → parameterisation → normal mesh. See README.md.
namespace nacre::remesh {

enum class RepairPolicy : std::uint8_t {
  kSafe,        ///< weld, drop degenerate and duplicate faces, split non-manifold places, orient,
                ///< drop small pieces whose loss does not show
  kStrict,      ///< as safe, but refuse a scan that needs more than welding and isolated vertices
  kNone,        ///< refuse a scan that needs any change
  kAggressive,  ///< as safe, and drop small pieces wherever they lie, fill pin holes (12 edges, 1 %
                ///< of the piece's extent or 3 edges wide), cut handles that measure 1 % of it
};

/// One kind of change that cleaning made, with how often and where first.
struct CleanAction {
  std::string kind;  ///< e.g. "welded vertices", "split non-manifold edges"
  std::size_t count = 0;
  std::vector<std::size_t> first_ids;  ///< of the input's vertices or faces: the lowest, up to 8
  double area = 0;                     ///< of dropped pieces, all together
  double extent = 0;  ///< of the largest piece, hole or handle: diagonal of its box
};

struct CleanReport {
  std::vector<CleanAction> actions;  ///< only what was done
  std::size_t vertices = 0, triangles = 0, pieces = 0, closed_pieces = 0, boundary_loops = 0;
  int genus = 0;  ///< summed over the pieces, boundary loops capped
};

/// A connected component of the cleaned scan.
struct PieceReport {
  std::size_t triangles = 0, base_triangles = 0, boundary_loops = 0;
  int genus = 0;
  std::string fallback;  ///< empty when remeshed as usual, else "what was done instead: why"
  std::size_t base_vertices = 0;
  bool is_own_base = false;  ///< its own triangles are its base, new vertices the middles of edges
};

struct CleanScan {
  Scan scan;                         ///< oriented 2-manifold; every vertex has a face
  std::vector<std::uint32_t> piece;  ///< per triangle
  std::vector<PieceReport> pieces;   ///< what is said of bases and fallbacks still empty
  CleanReport report;
};

/// Pieces below this share of the largest one's extent (diagonal of the bounding box) are small.
inline constexpr double kSmallExtent = 0.01;

/// Makes an oriented 2-manifold of any soup, changing as little as that takes. A closed surface is
/// not opened for the sake of what is attached to it, and a manifold comes back as it is, though
/// renumbered in the order of its triangles.
///
/// Ensures  (1) cleaning the result changes nothing, and no policy refuses it
///          (2) nothing that is not in the report was done
/// Options  small_extent: pieces smaller than this share of the largest one are dropped if they lie
///          within 0.05 % of its extent of what stays, and are at most 5 % of the area: shreds on
///          another layer, of which the error tells nothing. 0: none; kStrict and kNone: none.
/// Errors   kGeometryRefused if nothing is left, or the policy forbids a needed change; kBadInput
///          if a coordinate is not finite or an option is out of range.
[[nodiscard]] Result<CleanScan> clean(const Scan& scan, RepairPolicy policy = RepairPolicy::kSafe,
                                      double small_extent = kSmallExtent);

struct Options {
  /// How often the base is split. 0: enough for the semi-regular mesh to resolve the scan.
  int levels = 0;
  /// Vertices of the base mesh, all pieces together. 0: chosen from the scan, from
  /// least_base_vertices to most_base_vertices (0: no bound; nor where the scan has so many pieces,
  /// holes and handles that they need half of it). Without any bound at least 480, or one for 25 of
  /// the scan's.
  int base_vertices = 0;
  int least_base_vertices = 0, most_base_vertices = 0;
  /// Where levels is 0: the finest mesh gets at least so many triangles, if that is not more than
  /// 16 for each one of the scan.
  std::size_t least_triangles = 0;
  /// The scan's own triangles are the base mesh, as they are after cleaning, or simplified to
  /// base_vertices if that is not 0; `levels` splits follow, also if that is 0. No fallback, as it
  /// was asked for.
  bool keep_triangles = false;
  /// Fewer base meshes are tried: a third less time, about as good in the mean. Where triangles are
  /// kept and simplified: collapse_edges_quickly(), and no fit_surface().
  bool few_trials = false;
  RepairPolicy repair = RepairPolicy::kSafe;
  /// See clean(). 0: every piece is kept.
  double small_extent = kSmallExtent;
  /// The coder's own prediction (wavelet::predict_at_need); required.
  LevelPredictor predict;
  /// Told of the steps; never changes the result.
  Observer observer;
};

/// What one level of refinement did.
struct BandReport {
  std::size_t vertices = 0;
  std::size_t normal_only = 0;       ///< details with zero tangential part
  std::size_t folded_triangles = 0;  ///< of the level it makes: normal opposes the scan's under it
};

struct StageCost {
  std::string stage;
  double seconds = 0;
  std::size_t peak_bytes = 0;  ///< peak resident size of the process at the end of the stage
};

struct Remesh {
  SemiRegularMesh mesh;  ///< origin as the scan's
  CleanReport clean;
  std::vector<BandReport> bands;
  std::vector<PieceReport> pieces;
  std::vector<StageCost> costs;
};

class LineTree;

/// A scan with its map onto a base mesh: all that is needed to pierce it. Pieces that are their own
/// base come last in both.
struct MappedScan {
  std::shared_ptr<const Scan> scan;  ///< the cleaned one, long edges split
  Parameterisation map;              ///< of it
  int levels = 0;                    ///< how often the base will be split
  bool is_kept = false;             ///< the scan is its own base, new vertices the middles of edges
  std::vector<PieceReport> pieces;  ///< complete
  std::shared_ptr<const LineTree> tree;  ///< of all of `scan`; none: made when needed
};

/// remesh() in two halves, for who wants to stop between them or has changed something there.
/// remesh() is clean(), map_onto_base() and pierce_map() with the same options.
///
/// Errors   kGeometryRefused, kBadInput (an option out of range), kCancelled.
[[nodiscard]] Result<MappedScan> map_onto_base(CleanScan cleaned, const Options& options,
                                               const RunContext& context = {});
/// Of the result, `clean` and `costs` are left empty. Errors   kBadInput: the parts of `mapped` do
/// not fit together; kCancelled.
[[nodiscard]] Result<Remesh> pierce_map(const MappedScan& mapped, const Options& options,
                                        const RunContext& context = {});

/// Errors   kGeometryRefused, kBadInput (an option out of range), kCancelled.
[[nodiscard]] Result<Remesh> remesh(const Scan& scan, const Options& options,
                                    const RunContext& context = {});

}  // namespace nacre::remesh
