// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/base_size.h"

#include <algorithm>
#include <cmath>

namespace nacre::remesh {
namespace {

/// The finest mesh has no fewer triangles than this: creases come out a level later than curved
/// parts. Twice as many where no file's size says how fine is fine enough.
constexpr std::size_t kLeastFineTriangles = 160'000;

/// Nor is it asked for more than this many for each triangle of the scan.
constexpr std::size_t kMostPerScanTriangle = 16;

/// Base vertices that pieces, boundary loops and handles need before any are there for the shape.
std::size_t vertices_for_topology(const std::vector<PieceReport>& pieces) {
  std::size_t count = 0;
  for (const PieceReport& piece : pieces)
    count += 4 + 3 * piece.boundary_loops + 4 * static_cast<std::size_t>(std::max(piece.genus, 0));
  return count;
}

/// Pieces, holes and handles come out well where the base has so many times the vertices that they
/// need, if that is not more than a share of the scan's.
constexpr std::size_t kPerTopology = 20, kScanPerBase = 25;
/// And shapes of any kind come out well with so many, where nobody says that fewer shall do.
constexpr std::size_t kWell = 480;

/// A mesh that will be farther off than this share of its extent gets as many base vertices as take
/// it to the second one, up to one for so many of the scan's.
constexpr double kSlowError = 7.9e-5, kUsualError = 5.5e-5;
constexpr std::size_t kLeastScanPerBase = 5;

}  // namespace

bool is_free(const Options& options) {
  return options.levels == 0 && options.base_vertices == 0 && options.least_base_vertices == 0 &&
         options.most_base_vertices == 0;
}

int default_levels(std::size_t scan_triangles, std::size_t base_triangles, std::size_t asked) {
  const std::size_t least_fine = asked > 0 ? kLeastFineTriangles : 2 * kLeastFineTriangles;
  const std::size_t usual = std::max(scan_triangles * 5 / 2, least_fine);
  const std::size_t most = std::max(scan_triangles * kMostPerScanTriangle, usual);
  const std::size_t least = std::clamp(asked, usual, most);
  int levels = 1;
  while (levels < 10 && (base_triangles << (2 * levels)) < least) ++levels;
  return levels;
}

BaseSize base_size(const Options& options, const std::vector<PieceReport>& pieces,
                   std::size_t scan_vertices) {
  BaseSize size = {options.base_vertices, options.least_base_vertices, options.most_base_vertices};
  const std::size_t needed = vertices_for_topology(pieces);
  // As few as that would be bad everywhere.
  if (2 * needed > static_cast<std::size_t>(size.most)) size.most = 0;
  const bool is_bounded = options.least_base_vertices > 0 || options.most_base_vertices > 0;
  std::size_t well = std::max(kPerTopology * needed, is_bounded ? 0 : kWell);
  well = std::min(well, scan_vertices / kScanPerBase);
  if (size.most > 0) well = std::min(well, static_cast<std::size_t>(size.most));
  size.least = std::max(size.least, static_cast<int>(well));
  return size;
}

int denser_base(std::size_t now, std::size_t scan_vertices, double error) {
  if (!(error > kSlowError)) return 0;
  const auto size = static_cast<double>(now);
  const double denser = std::min(size * std::pow(error / kUsualError, 1 / kErrorPerSize),
                                 static_cast<double>(scan_vertices / kLeastScanPerBase));
  return denser > 1.25 * size ? static_cast<int>(denser) : 0;
}

}  // namespace nacre::remesh
