// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "app/dump.h"
#include "app/options.h"
#include "app/progress.h"
#include "app/report.h"
#include "base/result.h"
#include "remesh/remesh.h"

/// The first half of `encode`, which is also all of `remesh`.
namespace nacre::app {

struct Prepared {
  Scan scan;  ///< as read
  InputFacts input;
  remesh::Remesh remesh;
};

/// Reads and remeshes, noting on the console what was changed and what is not carried, and in
/// `dumper` (null: nowhere) what it looks like.
[[nodiscard]] Result<Prepared> read_and_remesh(const std::filesystem::path& file,
                                               const RemeshSettings& settings, StageClock& clock,
                                               Console& console, Dumper* dumper = nullptr);

/// metric::compare with the file's name on its errors.
[[nodiscard]] Result<metric::Comparison> measure(const Scan& scan, const Scan& other,
                                                 std::size_t samples,
                                                 const std::filesystem::path& file,
                                                 Console& console);

/// kCancelled if the user pressed Ctrl-C.
[[nodiscard]] Result<void> check_cancelled(const Console& console);

}  // namespace nacre::app
