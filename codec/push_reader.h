// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "codec/decode.h"

namespace nacre::codec {

class LevelDecoder;

/// Decodes a stream while it arrives: bytes in, in pieces of any size, and out comes each level as
/// soon as its band is whole. All work is done once: the whole costs what decode() costs, and no
/// byte is kept longer than its section needs.
///
///     PushReader reader;
///     while (bytes arrive)
///       if (auto ok = reader.push(bytes, show); !ok) return ok.error();
///     if (auto ok = reader.finish(); !ok) …  // cut short: mesh() is the finest level that came
///
/// Ensures  the meshes are bit-identical to decode()'s of the prefixes, however the bytes are cut
///          into pieces.
/// Profiles nmc and eqmc (DecodeOptions::comparators) give the base mesh, then the finest level;
/// their bytes are kept.
class PushReader {
 public:
  using OnLevel = std::function<void(const SemiRegularMesh& mesh)>;

  /// max_level: levels beyond it are neither decoded nor waited for. accept_prefix: finish() is
  /// content with any level. max_vertices is held against the finest level wanted, for how far the
  /// bytes will come is not known.
  explicit PushReader(const DecodeOptions& options = {});
  ~PushReader();
  PushReader(PushReader&&) noexcept;
  PushReader& operator=(PushReader&&) noexcept;

  /// Takes the next bytes; calls `on_level` for each level that they complete, coarse to fine. The
  /// mesh handed over is mesh(): copy it to keep it.
  ///
  /// Errors   as decode(); then the reader has failed, and mesh() is what came before the damage.
  ///          Bytes beyond the stream's end are kCorruptStream.
  Result<void> push(std::span<const std::uint8_t> bytes, const OnLevel& on_level = {});

  /// No more bytes will come. Errors   kCorruptStream if the finest level wanted is not there
  /// (with accept_prefix: if not even the base mesh is).
  [[nodiscard]] Result<void> finish() const;

  /// The finest level so far, -1 before the base mesh.
  [[nodiscard]] int level() const;
  /// Everything that was wanted is there.
  [[nodiscard]] bool done() const;
  /// The mesh of level(); null before the base mesh.
  [[nodiscard]] const SemiRegularMesh* mesh() const;
  /// Known once the header is there.
  [[nodiscard]] const std::optional<StreamInfo>& info() const { return info_; }

 private:
  struct State;
  Result<void> fail(Error error);
  Result<void> read_header();
  Result<bool> read_next(const OnLevel& on_level);
  Result<bool> read_base(const OnLevel& on_level);
  Result<bool> read_band(const OnLevel& on_level);
  Result<bool> read_comparator(const OnLevel& on_level);
  void reached(const OnLevel& on_level) const;

  DecodeOptions options_;
  std::optional<StreamInfo> info_;
  std::unique_ptr<State> state_;
};

}  // namespace nacre::codec
