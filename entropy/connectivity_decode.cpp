// SPDX-License-Identifier: Apache-2.0
#include "entropy/closed_mesh.h"
#include "entropy/connectivity.h"
#include "entropy/valence_conquest.h"

namespace nacre::entropy {
namespace {

/// Knows nothing of the mesh: everything is read.
struct NoGuide {
  std::optional<Start> next_component() { return std::nullopt; }
  void started(const Triangle&) {}
  void closing(std::uint32_t, std::uint32_t) {}
  Step propose(const ValenceFront&, std::uint32_t) { return {}; }
  void added(std::uint32_t, std::uint32_t) {}
  void joined(std::uint32_t, std::uint32_t, std::uint32_t) {}
};

}  // namespace

Result<Connectivity> decode_connectivity(std::span<const std::uint8_t> bytes,
                                         std::uint32_t max_triangles) {
  SymbolReader reader(bytes);
  NoGuide guide;
  ValenceConquest<SymbolReader, NoGuide> conquest(reader, guide, max_triangles);
  if (!conquest.run() || !reader.ends_exactly())
    return Error{ErrorCode::kCorruptStream, "base connectivity does not decode to a surface", 0};
  Connectivity& decoded = conquest.result();
  // Each vertex has one fan by construction, but two of its neighbours may still be the same
  // vertex.
  if (const auto mesh = close_mesh(decoded.triangles, decoded.vertex_count); !mesh)
    return Error{ErrorCode::kCorruptStream, "base connectivity: " + mesh.error().message, 0};
  return std::move(decoded);
}

}  // namespace nacre::entropy
