// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "app/dump.h"
#include "app/options.h"
#include "app/progress.h"
#include "app/report.h"
#include "base/result.h"
#include "remesh/remesh.h"

/// The first half of `encode`, which is also all of `remesh`.
namespace nacre::app {

struct Prepared {
  Scan scan;                      ///< as read; what is measured against
  std::optional<Scan> to_remesh;  ///< as read, where `scan` is another: --reference
  InputFacts input;
  remesh::Remesh remesh;  ///< empty mesh where the run starts at symbols or at the stream
  std::optional<DumpStage> stopped_after;  ///< --until: `remesh` may be empty
  std::optional<Reentry> from;

  [[nodiscard]] const Scan& source() const { return to_remesh ? *to_remesh : scan; }
};

/// The remesher's options for these settings.
[[nodiscard]] remesh::Options remesh_options(const RemeshSettings& settings);

/// Reads a scan, noting on the console what is not carried.
[[nodiscard]] Result<Prepared> read_input(const std::filesystem::path& file, StageClock& clock,
                                          Console& console);

/// From now on what is made is measured against this scan; no file: against what was read.
[[nodiscard]] Result<void> read_reference(const std::filesystem::path& file, Prepared& prepared,
                                          Console& console);

/// Remeshes what was read, noting in `dumper` (null: nowhere) what it looks like. The dumper, once
/// checked, also says where to start and to stop, and which stages are there already.
/// Errors   those of the stages and of dumping.
[[nodiscard]] Result<void> remesh_input(Prepared& prepared, const RemeshSettings& settings,
                                        StageClock& clock, Console& console,
                                        Dumper* dumper = nullptr);

/// Notes on the console what cleaning changed and which pieces fell back.
void note_remesh(const Prepared& prepared, Console& console);

/// metric::compare with the file's name on its errors.
[[nodiscard]] Result<metric::Comparison> measure(const Scan& scan, const Scan& other,
                                                 std::size_t samples,
                                                 const std::filesystem::path& file,
                                                 Console& console);

/// kCancelled if the user pressed Ctrl-C.
[[nodiscard]] Result<void> check_cancelled(const Console& console);

/// What a run says that was asked to stop after a stage.
[[nodiscard]] std::string stopped_line(DumpStage stage, const DumpSettings& settings);

}  // namespace nacre::app
