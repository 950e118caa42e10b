// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <filesystem>

#include "app/batch/manifest.h"
#include "app/batch/record.h"
#include "base/result.h"

namespace nacre::app::batch {

/// Encodes one scan in this process: hash, encode in `work`, thumbnail, record, output in place.
/// `work` is an empty folder of the output's file system. A scan whose record turns out to fit
/// after all (the same bytes with another time) is not encoded again, unless `force`.
///
/// Ensures  killed at any point, the output is the old one or the new one, and state_of() tells
/// Errors   those of run_encode; kUnreadableFile if the scan changes meanwhile.
[[nodiscard]] Result<void> encode_item(const Store& store, const Manifest& manifest,
                                       const Item& item, const std::filesystem::path& work,
                                       int threads, bool force, const std::atomic<bool>& cancel);

/// PNG in base64 of what a .ncr file decodes to, at a level coarse enough to be quick; empty if
/// that fails, for a batch does not stop for a picture.
[[nodiscard]] std::string thumbnail_of(const std::filesystem::path& stream);

}  // namespace nacre::app::batch
