// SPDX-License-Identifier: Apache-2.0
#include "entropy/plane_positions_decode.h"

#include "entropy/plane_positions.h"

namespace nacre::entropy {
namespace {

bool read_by_planes(SymbolReader& reader, const ClosedMesh& mesh, int bits,
                    std::span<GridPoint> points) {
  PlaneTraversal traversal(mesh, bits);
  PlaneModels models;
  PlanePositionCoder<SymbolReader> coder(reader, models, bits);
  for (std::uint32_t v = traversal.next(); v != kNone; v = traversal.next()) {
    const Outlook outlook = traversal.look_out(v, points);
    PositionChoice choice;
    ToldVertex told;
    if (!coder.code(outlook, choice, points[v], told) || reader.failed()) return false;
    traversal.finish(v, told);
  }
  return true;
}

}  // namespace

Result<std::vector<GridPoint>> decode_positions_by_planes(std::span<const std::uint8_t> bytes,
                                                          const Connectivity& connectivity,
                                                          int bits) {
  const Error corrupt{ErrorCode::kCorruptStream, "positions by planes do not decode to grid points",
                      0};
  if (bits < 1 || bits > 24) return corrupt;
  const Result<ClosedMesh> mesh = close_mesh(connectivity.triangles, connectivity.vertex_count);
  if (!mesh) return corrupt;
  SymbolReader reader(bytes);
  std::vector<GridPoint> points(connectivity.vertex_count);
  if (!read_by_planes(reader, *mesh, bits, points) || !reader.ends_exactly()) return corrupt;
  return points;
}

}  // namespace nacre::entropy
