// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>

#include "codec/decode.h"
#include "codec/stream_reader.h"
#include "entropy/detail_model.h"

namespace nacre::codec {

/// Decodes a stream section by section, coarse to fine, in place: the base mesh, then one level
/// after the other. What decode() and PushReader are made of.
class LevelDecoder {
 public:
  /// Decodes the base mesh from its two payloads; `finest` is the level that next_level() may lead
  /// to, at most header.levels.
  ///
  /// Errors   kCorruptStream, kLimitExceeded; `where` is the section's offset.
  static Result<std::unique_ptr<LevelDecoder>> begin(const StreamLayout& layout,
                                                     std::span<const std::uint8_t> connectivity,
                                                     std::span<const std::uint8_t> positions,
                                                     int finest);

  /// Adds a level: of profiles paper and best, from its band's payload (empty for a band that is
  /// not there) ...
  Result<void> next_level(std::span<const std::uint8_t> payload);
  /// ... or from its details, one per edge of the level.
  Result<void> next_level(std::span<const Vec3> details);

  /// The mesh of the level reached. Later levels change it.
  [[nodiscard]] const SemiRegularMesh& mesh() const { return mesh_; }
  [[nodiscard]] SemiRegularMesh take() { return std::move(mesh_); }
  [[nodiscard]] const Topology& topology() const { return topology_; }

 private:
  LevelDecoder(const StreamLayout& layout, Topology topology, SemiRegularMesh base);
  [[nodiscard]] Result<wavelet::SparseBand> decode_band(std::span<const std::uint8_t> payload);
  Result<void> add(const wavelet::SparseBand& band);

  StreamLayout layout_;
  Topology topology_;
  SemiRegularMesh mesh_;
  wavelet::Synthesizer synthesizer_;
  entropy::DetailModel model_;  // of profile best
};

}  // namespace nacre::codec
