// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "codec/decode.h"

/// Changes to a finished stream that need no coding: its header is written anew, its sections stay.
namespace nacre::codec {

/// Bytes that a level table adds to the header of a stream of that many levels.
[[nodiscard]] std::size_t level_table_bytes(Profile profile, int levels);
/// Bytes that a certified error adds, a level table being there or not.
[[nodiscard]] std::size_t certified_error_bytes(Profile profile, bool has_level_table);

/// The stream with this table and this certified error, in place of those it has; without any if
/// they are null. The errors are rounded up, the PSNR down.
///
/// Errors   as inspect() for a stream that is not whole; kBadInput: a table that has not one cut
///          per level, or a number in it that is NaN or negative.
[[nodiscard]] Result<std::vector<std::uint8_t>> with_quality(
    std::span<const std::uint8_t> stream, const std::optional<LevelTable>& table,
    const std::optional<double>& certified_error = {});

/// The stream without what only levels beyond `level` need: whole again, of `level` levels. It
/// decodes to what decode() gives for that level, bit for bit. The table keeps its cuts up to
/// `level`; a certified error, which holds for the finest level, is dropped with it. Sections that
/// are left out need not be there. Profile best cut to its base mesh becomes profile paper.
///
/// Errors   as decode() for what is kept (checksums are compared); kBadInput: no such level, or a
///          level of profile nmc, which has all of them in one band.
[[nodiscard]] Result<std::vector<std::uint8_t>> cut_at_level(std::span<const std::uint8_t> stream,
                                                             int level);

}  // namespace nacre::codec
