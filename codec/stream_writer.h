// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "codec/stream_format.h"

namespace nacre::codec {

/// The header's bytes, checksum included. `header.bands` must not end in an empty band.
[[nodiscard]] std::vector<std::uint8_t> write_header(const Header& header);

/// A section: payload and checksum; empty for an empty payload.
[[nodiscard]] std::vector<std::uint8_t> write_section(const std::vector<std::uint8_t>& payload);

/// Header and sections joined. Fills the header's lengths from the payloads and drops empty bands
/// at the end; `header.bands` has the step of each payload in `bands`.
[[nodiscard]] std::vector<std::uint8_t> write_stream(
    Header header, const std::vector<std::uint8_t>& connectivity,
    const std::vector<std::uint8_t>& positions, std::span<const std::vector<std::uint8_t>> bands);

}  // namespace nacre::codec
