// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "base/result.h"

/// What the process leaves with: one number per kind of outcome, stable for scripts.
namespace nacre::app {

enum ExitCode : int {
  kExitDone = 0,
  kExitUnexpected = 1,       ///< a bug, a full disk, a folder that cannot be written
  kExitUsage = 2,            ///< wrong option or argument; output exists and no -f
  kExitUnreadable = 3,       ///< input missing, unreadable, of no known format
  kExitGeometryRefused = 4,  ///< the scan cannot be processed under the repair policy
  kExitGoalUnreachable = 5,
  kExitLimit = 6,
  kExitCorruptStream = 7,  ///< .ncr damaged, cut short, or too new
  kExitItemsFailed = 8,    ///< a batch ended, some of its scans failed or are missing
  kExitInterrupted = 75,   ///< EX_TEMPFAIL: try again
};

/// The verbs recode an error where the same code means something else (see stream_error() and
/// surface_error() in files.h), so that this map needs the code alone.
constexpr int exit_code(ErrorCode code) {
  switch (code) {
    case ErrorCode::kBadInput:
      return kExitUsage;
    case ErrorCode::kUnreadableFile:
      return kExitUnreadable;
    case ErrorCode::kGeometryRefused:
      return kExitGeometryRefused;
    case ErrorCode::kGoalUnreachable:
      return kExitGoalUnreachable;
    case ErrorCode::kLimitExceeded:
      return kExitLimit;
    case ErrorCode::kCorruptStream:
    case ErrorCode::kUnsupportedVersion:
      return kExitCorruptStream;
    case ErrorCode::kCancelled:
      return kExitInterrupted;
    case ErrorCode::kCannotWrite:
    case ErrorCode::kNoConvergence:
      break;
  }
  return kExitUnexpected;
}

}  // namespace nacre::app
