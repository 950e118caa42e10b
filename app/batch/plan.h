// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "app/batch/command.h"
#include "app/batch/manifest.h"
#include "app/progress.h"
#include "base/result.h"

namespace nacre::app::batch {

/// The scans below a folder or of a list, each with the name of its output and its options, which
/// are checked here as the command line would.
///
/// The outputs mirror the folders: IN/a/b.ply becomes OUT/a/b.ncr. Where two scans would have one
/// output (b.ply beside b.obj), these keep their ending: b.ply.ncr.
///
/// Ensures  the same files and options give the same manifest
/// Errors   kUnreadableFile: no such folder, list or options file; no scan at all. kBadInput: an
///          option that encode refuses, with the scan.
[[nodiscard]] Result<Manifest> make_plan(const PlanCommand& command, Console& console);

}  // namespace nacre::app::batch
