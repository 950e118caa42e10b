// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "app/options.h"
#include "base/result.h"
#include "codec/decode.h"

/// Parts of .ncr files, read without the rest.
namespace nacre::app {

/// What a .ncr file says of itself, from its header alone.
///
/// Errors   kUnreadableFile; kCorruptStream: no header, too short for the base mesh, or longer than
///          the stream; kUnsupportedVersion.
[[nodiscard]] Result<codec::StreamInfo> read_stream_info(const std::filesystem::path& file);

/// The level that a choice means; the finest for an empty one. Whether the file is long enough for
/// it is not asked.
///
/// Errors   kBadInput: no such level. kGoalUnreachable, with what can be had instead: not even the
///          base mesh has so few bytes, no level is so near, or errors are not known.
[[nodiscard]] Result<int> chosen_level(const codec::StreamInfo& info, const PrefixChoice& choice,
                                       const std::filesystem::path& file);

struct StreamPrefix {
  codec::StreamInfo info;
  int level = 0;
  std::vector<std::uint8_t> bytes;  ///< what the level needs, no more
};

/// Reads what the chosen level needs. With `partial` a file that is cut short gives the finest
/// level that it has instead of an error.
///
/// Errors   as the two above; kCorruptStream if the file is cut short of the level.
[[nodiscard]] Result<StreamPrefix> read_prefix(const std::filesystem::path& file,
                                               const PrefixChoice& choice, bool partial);

/// "PSNR 71.25 dB, max error 0.012 (0.42 %)" from the level table; empty without one.
[[nodiscard]] std::string level_quality_text(const codec::StreamInfo& info, int level);

}  // namespace nacre::app
