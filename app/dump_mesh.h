// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "app/dump_colors.h"
#include "app/folds.h"
#include "base/result.h"
#include "base/scan.h"
#include "base/semi_regular_mesh.h"
#include "remesh/remesh.h"

/// Steps of a run as coloured meshes.
namespace nacre::app {

/// A mesh with values and colours on its vertices and faces; empty, or one entry each.
struct DumpMesh {
  TriangleMesh mesh;
  std::vector<float> vertex_quality, face_quality;
  std::vector<Rgb> vertex_color, face_color;
  std::vector<std::string> comments;  ///< one line each: what the values and colours mean
};

/// Binary PLY as MeshLab reads it: `quality` and colours per vertex and per face. Coordinates are
/// absolute: floats while the origin is zero, else doubles.
///
/// Errors   kBadInput as io::serialize_mesh, or a channel of the wrong length.
[[nodiscard]] Result<std::vector<std::uint8_t>> to_ply(const DumpMesh& dump);

/// Adds `more` behind `dump`, which is empty or has the same channels and origin.
void append(DumpMesh& dump, DumpMesh more);

/// Quality: the piece. Colour: the piece; boundary vertices blue.
[[nodiscard]] DumpMesh dump_clean(const remesh::CleanScan& cleaned);

/// Corners where simplification left them. Quality of a vertex: its number of edges. Colour of a
/// face: its own hue, as in dump_parameterisation; boundary vertices blue. Hues count from
/// `first_face`.
[[nodiscard]] DumpMesh dump_base(const Scan& scan, const remesh::Parameterisation& map,
                                 std::size_t first_face = 0);

/// The scan with the map painted on, split so that it shows: each base triangle has its hue, in it
/// a checkerboard of the triangles that some splits make, and dark borders. Quality of a face: how
/// far the map pulls it out of shape, the larger singular value over the smaller (1: not at all; 0:
/// not known, it lies in several base triangles).
[[nodiscard]] DumpMesh dump_parameterisation(const Scan& scan, const remesh::Parameterisation& map,
                                             std::size_t first_face = 0);

/// One level. Quality of a vertex: its remesh::DetailKind; colour: grey for normal, blue for
/// boundary, orange for vector, magenta at folded triangles. Quality of a face: distance of its
/// centroid to the scan; colour: magenta if folded (see FoldCheck), else its base triangle's hue,
/// pale.
[[nodiscard]] Result<DumpMesh> dump_level(const SemiRegularMesh& mesh, int level,
                                          std::span<const std::uint8_t> kind,
                                          const FoldCheck& scan);

}  // namespace nacre::app
