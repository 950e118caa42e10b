// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "app/dump.h"
#include "app/options.h"
#include "app/progress.h"
#include "codec/codec.h"

/// The stages of coding: where an encode starts at one of them, and what of them is dumped.
namespace nacre::app {

/// Before any work. Errors   kBadInput: a goal beside steps, symbols or a stream, which have their
/// size already; the steps or symbols of a profile that has none; as Dumper::check().
[[nodiscard]] Result<void> check_stages(const EncodeCommand& command, Dumper& dumper);

/// The coded scan, made from what the dumper's entry holds: steps, symbols, or the stream itself.
/// `mesh` is that of 06-coefficients; symbols and streams need none.
///
/// Errors   kUnreadableFile, kGeometryRefused, kCorruptStream: what is there does not make a stream.
[[nodiscard]] Result<codec::Encoded> recode(const StageFolder& entry, const SemiRegularMesh& mesh);

/// Whether the run codes without a search, by recode().
[[nodiscard]] inline bool recodes(const Dumper& dumper) {
  return dumper.starts_at_or_after(DumpStage::kSteps);
}

/// Whether a run that has come to the coder is to stop after `stage` or has stopped before.
[[nodiscard]] bool stops_by(const EncodeCommand& command, DumpStage stage);

}  // namespace nacre::app
