// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "base/result.h"
#include "codec/decode.h"
#include "codec/stream_format.h"

namespace nacre::codec {

/// Where a section lies in the file: its payload, then its checksum.
struct SectionRange {
  std::size_t offset = 0;
  std::size_t payload_bytes = 0;

  [[nodiscard]] std::size_t end() const {
    return offset + payload_bytes + checksum_bytes(payload_bytes);
  }
};

/// A stream's checked header and the place of each section; the sections may be cut off.
struct StreamLayout {
  Header header;
  std::size_t header_bytes = 0;
  std::vector<SectionRange> sections;  ///< base connectivity, base positions, coded bands

  [[nodiscard]] std::size_t bytes_whole() const { return sections.back().end(); }
};

/// Reads and checks the header; no section is looked at.
///
/// Errors   kCorruptStream, kUnsupportedVersion; `where` is the byte offset.
[[nodiscard]] Result<StreamLayout> read_layout(std::span<const std::uint8_t> bytes);

/// The same from a beginning of a stream; nothing if more bytes are needed to tell, which is so for
/// less than kMaxHeaderBytes only.
[[nodiscard]] Result<std::optional<StreamLayout>> try_read_layout(
    std::span<const std::uint8_t> bytes);

/// The payload of a section that is wholly there, after checking its checksum.
///
/// Errors   kCorruptStream.
[[nodiscard]] Result<std::span<const std::uint8_t>> read_section(
    std::span<const std::uint8_t> bytes, const SectionRange& section);

/// The same from the section's own bytes, checksum included.
[[nodiscard]] Result<std::span<const std::uint8_t>> checked_payload(
    std::span<const std::uint8_t> bytes, const SectionRange& section);

/// How many levels the bytes that are there decode to, at most `header.levels`.
///
/// Errors   kCorruptStream if the stream is cut short (unless `accept_prefix`), is cut before the
///          end of the base mesh, or goes on after its end.
[[nodiscard]] Result<int> available_levels(const StreamLayout& layout, std::size_t byte_count,
                                           bool accept_prefix);

}  // namespace nacre::codec
