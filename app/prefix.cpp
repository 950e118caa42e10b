// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/prefix.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <system_error>

#include "app/files.h"
#include "app/sizes.h"
#include "io/io.h"
#include "io/write.h"

namespace nacre::app {
namespace fs = std::filesystem;
namespace {

/// The first `count` bytes, or all of a shorter file.
Result<std::vector<std::uint8_t>> read_beginning(const fs::path& file, std::size_t count) {
  std::error_code no_size;
  const std::uintmax_t size = fs::file_size(file, no_size);
  // Pipes and the like, and errors that read_file() has words for.
  if (no_size || size <= count) return io::read_file(file);
  std::ifstream in(file, std::ios::binary);
  std::vector<std::uint8_t> bytes(count);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(count));
  if (!in) return Error{ErrorCode::kUnreadableFile, "cannot be read"};
  return bytes;
}

Error corrupt(const fs::path& file, const std::string& what) {
  return {ErrorCode::kCorruptStream, fmt::format("{}: {}", file.string(), what)};
}

std::size_t last_level(const codec::StreamInfo& info) { return info.levels.size() - 1; }

Result<int> level_of_bytes(const codec::StreamInfo& info, std::uint64_t bytes,
                           const fs::path& file) {
  for (std::size_t j = info.levels.size(); j-- > 0;)
    if (info.levels[j].bytes <= bytes) return static_cast<int>(j);
  return Error{ErrorCode::kGoalUnreachable,
               fmt::format("{}: {} bytes hold not even the base mesh; the least is {}",
                           file.string(), bytes, info.levels[0].bytes)};
}

Result<int> level_of_error(const codec::StreamInfo& info, const ErrorGoal& goal,
                           const fs::path& file) {
  if (!info.level_table) {
    return Error{ErrorCode::kGoalUnreachable,
                 fmt::format("{}: has no level table, so the errors of its levels are not known; "
                             "encode it with --level-table on, or choose by --level",
                             file.string())};
  }
  const codec::LevelTable& table = *info.level_table;
  // The diagonal is rounded up to binary32.
  constexpr double kRoundingOfDiagonal = 1 - 0x1p-23;
  const double limit =
      goal.is_percent ? goal.value / 100 * table.bbox_diagonal * kRoundingOfDiagonal : goal.value;
  for (std::size_t j = 0; j < table.cuts.size(); ++j)
    if (table.cuts[j].max_error <= limit) return static_cast<int>(j);
  const auto best = std::ranges::min_element(table.cuts, {}, &codec::LevelTable::Cut::max_error);
  return Error{ErrorCode::kGoalUnreachable,
               fmt::format("{}: no level is within {:.6g}; level {} is nearest, within {:.6g} "
                           "({:.4f} %)",
                           file.string(), limit, best - table.cuts.begin(), best->max_error,
                           100 * best->max_error / table.bbox_diagonal)};
}

}  // namespace

Result<codec::StreamInfo> read_stream_info(const fs::path& file) {
  const Result<std::vector<std::uint8_t>> beginning = read_beginning(file, codec::kMaxHeaderBytes);
  if (!beginning) return in_file(beginning.error(), file);
  std::error_code no_size;
  const std::uintmax_t size = fs::file_size(file, no_size);
  const std::size_t bytes = no_size ? beginning->size() : static_cast<std::size_t>(size);
  Result<codec::StreamInfo> info = codec::inspect_header(*beginning, bytes);
  if (!info) return stream_error(info.error(), file);
  if (bytes < info->levels[0].bytes)
    return corrupt(
        file, fmt::format("the stream is cut before the end of the base mesh (byte {})", bytes));
  if (bytes > info->bytes_whole)
    return corrupt(
        file, fmt::format("there are bytes after the stream's end (byte {})", info->bytes_whole));
  return info;
}

Result<int> chosen_level(const codec::StreamInfo& info, const PrefixChoice& choice,
                         const fs::path& file) {
  const auto finest = static_cast<int>(last_level(info));
  if (choice.bytes) return level_of_bytes(info, *choice.bytes, file);
  if (choice.max_error) return level_of_error(info, *choice.max_error, file);
  if (choice.level <= finest) return choice.level < 0 ? finest : choice.level;
  return Error{ErrorCode::kBadInput, fmt::format("{}: has levels 0 to {} only, --level asks for {}",
                                                 file.string(), finest, choice.level)};
}

Result<StreamPrefix> read_prefix(const fs::path& file, const PrefixChoice& choice, bool partial) {
  Result<codec::StreamInfo> info = read_stream_info(file);
  if (!info) return info.error();
  const Result<int> wanted = chosen_level(*info, choice, file);
  if (!wanted) return wanted.error();
  StreamPrefix prefix;
  prefix.level = *wanted;
  const auto bytes_of = [&](int level) {
    return info->levels[static_cast<std::size_t>(level)].bytes;
  };
  if (bytes_of(prefix.level) > info->bytes_present && !partial) {
    return corrupt(file, fmt::format("the stream is cut: {} bytes expected (byte {}); --partial "
                                     "takes what is there",
                                     bytes_of(prefix.level), info->bytes_present));
  }
  while (bytes_of(prefix.level) > info->bytes_present) --prefix.level;
  Result<std::vector<std::uint8_t>> bytes = read_beginning(file, bytes_of(prefix.level));
  if (!bytes) return in_file(bytes.error(), file);
  bytes->resize(std::min(bytes->size(), bytes_of(prefix.level)));
  prefix.bytes = std::move(*bytes);
  prefix.info = std::move(*info);
  return prefix;
}

std::string level_quality_text(const codec::StreamInfo& info, int level) {
  if (!info.level_table) return "";
  const codec::LevelTable& table = *info.level_table;
  const codec::LevelTable::Cut& cut = table.cuts[static_cast<std::size_t>(level)];
  std::string text = fmt::format("PSNR {:.2f} dB", cut.psnr_db);
  if (!std::isfinite(cut.max_error)) return text;
  const double percent = table.bbox_diagonal > 0 ? 100 * cut.max_error / table.bbox_diagonal : 0;
  return text + fmt::format(", max error {:.3g} ({:.2g} %)", cut.max_error, percent);
}

}  // namespace nacre::app
