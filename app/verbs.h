// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "app/options.h"
#include "app/progress.h"
#include "base/result.h"

/// The verbs. Each checks what is cheap first, writes its outputs last, and returns an error that
/// is printed as it is: one line, with the file's name. stdout gets data or the asked-for report
/// only; the rest goes through the console.
namespace nacre::app {

[[nodiscard]] Result<void> run_encode(const EncodeCommand& command, Console& console);
[[nodiscard]] Result<void> run_decode(const DecodeCommand& command, Console& console);
[[nodiscard]] Result<void> run_cut(const CutCommand& command, Console& console);
[[nodiscard]] Result<void> run_remesh(const RemeshCommand& command, Console& console);
[[nodiscard]] Result<void> run_compare(const CompareCommand& command, Console& console);
[[nodiscard]] Result<void> run_info(const InfoCommand& command, Console& console);
[[nodiscard]] Result<void> run_stage(const StageCommand& command, Console& console);

}  // namespace nacre::app
