// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/edit_stream.h"

#include <algorithm>
#include <string>

#include "codec/stream_reader.h"
#include "codec/stream_writer.h"

namespace nacre::codec {
namespace {

std::size_t header_bytes(Profile profile, int levels, bool has_table, bool is_certified) {
  Header header;
  header.profile = profile;
  header.levels = levels;
  header.grid_bits = 1;
  if (has_table)
    header.level_table =
        LevelTable{1, std::vector<LevelTable::Cut>(static_cast<std::size_t>(levels) + 1)};
  if (is_certified) header.certified_error = 1;
  return write_header(header).size();
}

/// The header as it is now, then the sections of the first `bands` bands.
Result<std::vector<std::uint8_t>> rewritten(std::span<const std::uint8_t> stream,
                                            const StreamLayout& layout, const Header& header) {
  std::vector<std::uint8_t> bytes = write_header(header);
  for (std::size_t i = 0; i < 2 + header.bands.size(); ++i) {
    const SectionRange& section = layout.sections[i];
    if (const auto payload = read_section(stream, section); !payload) return payload.error();
    const auto whole = stream.subspan(section.offset, section.end() - section.offset);
    bytes.insert(bytes.end(), whole.begin(), whole.end());
  }
  return bytes;
}

Result<void> check(const LevelTable& table, int levels) {
  if (table.cuts.size() != static_cast<std::size_t>(levels) + 1) {
    return Error{ErrorCode::kBadInput, "a level table of " + std::to_string(table.cuts.size()) +
                                           " cuts for " + std::to_string(levels + 1) + " levels"};
  }
  bool fine = table.bbox_diagonal >= 0 && table.bbox_diagonal < 1e38;
  for (const LevelTable::Cut& cut : table.cuts)
    fine = fine && cut.max_error >= 0 && (cut.psnr_db >= 0 || cut.psnr_db < 0);
  if (!fine) return Error{ErrorCode::kBadInput, "a level table has a value that is no length"};
  return {};
}

}  // namespace

std::size_t level_table_bytes(Profile profile, int levels) {
  return header_bytes(profile, levels, true, false) - header_bytes(profile, levels, false, false);
}

std::size_t certified_error_bytes(Profile profile, bool has_level_table) {
  return header_bytes(profile, 0, has_level_table, true) -
         header_bytes(profile, 0, has_level_table, false);
}

Result<std::vector<std::uint8_t>> with_quality(std::span<const std::uint8_t> stream,
                                               const std::optional<LevelTable>& table,
                                               const std::optional<double>& certified_error) {
  auto layout = read_layout(stream);
  if (!layout) return layout.error();
  if (const auto ok = available_levels(*layout, stream.size(), false); !ok) return ok.error();
  if (table) {
    if (const auto ok = check(*table, layout->header.levels); !ok) return ok.error();
  }
  if (certified_error && !(*certified_error >= 0 && *certified_error < 1e38))
    return Error{ErrorCode::kBadInput, "the certified error is no length"};
  Header header = layout->header;
  header.level_table = table;
  header.certified_error = certified_error;
  return rewritten(stream, *layout, header);
}

Result<std::vector<std::uint8_t>> cut_at_level(std::span<const std::uint8_t> stream, int level) {
  const auto layout = read_layout(stream);
  if (!layout) return layout.error();
  Header header = layout->header;
  if (level < 0 || level > header.levels) {
    return Error{ErrorCode::kBadInput, "the stream has levels 0 to " +
                                           std::to_string(header.levels) + ", not " +
                                           std::to_string(level)};
  }
  if (header.profile == Profile::kNmc && level > 0 && level < header.levels)
    return Error{ErrorCode::kBadInput, "profile nmc has all levels in one band: nothing to cut"};
  if (level < header.levels) {
    header.levels = level;
    header.certified_error.reset();
    // Without levels profile best tells positions by planes; these are not.
    if (level == 0 && header.profile == Profile::kBest) header.profile = Profile::kPaper;
    if (header.level_table) header.level_table->cuts.resize(static_cast<std::size_t>(level) + 1);
  }
  if (header.bands.size() > static_cast<std::size_t>(level))
    header.bands.resize(static_cast<std::size_t>(level));
  while (!header.bands.empty() && header.bands.back().payload_bytes == 0) header.bands.pop_back();
  return rewritten(stream, *layout, header);
}

}  // namespace nacre::codec
