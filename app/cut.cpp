// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <utility>

#include "app/files.h"
#include "app/prefix.h"
#include "app/sizes.h"
#include "app/verbs.h"
#include "codec/edit_stream.h"

namespace nacre::app {
namespace {

struct Cut {
  StreamPrefix prefix;
  std::vector<std::uint8_t> bytes;
};

Result<Cut> cut_to(const CutCommand& command, const PrefixChoice& choice) {
  Result<StreamPrefix> prefix = read_prefix(command.stream, choice, command.partial);
  if (!prefix) return prefix.error();
  Result<std::vector<std::uint8_t>> bytes = codec::cut_at_level(prefix->bytes, prefix->level);
  // A level that is there and cannot be cut at is the user's choice; the rest is damage.
  if (!bytes && bytes.error().code == ErrorCode::kBadInput)
    return in_file(bytes.error(), command.stream);
  if (!bytes) return stream_error(bytes.error(), command.stream);
  return Cut{std::move(*prefix), std::move(*bytes)};
}

/// The finest level whose file is small enough; headers shrink when they are cut, so the prefix may
/// be a little longer than what it becomes.
Result<Cut> cut_to_size(const CutCommand& command, std::uint64_t most) {
  const Result<codec::StreamInfo> info = read_stream_info(command.stream);
  if (!info) return info.error();
  std::size_t smallest = 0;
  for (std::size_t level = info->levels.size(); level-- > 0;) {
    const std::size_t bytes = info->levels[level].bytes;
    if (level > 0 && bytes - info->bytes_header > most) continue;
    if (level > 0 && command.partial && bytes > info->bytes_present) continue;
    PrefixChoice choice;
    choice.level = static_cast<int>(level);
    Result<Cut> cut = cut_to(command, choice);
    // Profile nmc has levels that cannot be cut at.
    if (!cut && cut.error().code == ErrorCode::kBadInput) continue;
    if (!cut || cut->bytes.size() <= most) return cut;
    smallest = cut->bytes.size();
  }
  return Error{ErrorCode::kGoalUnreachable,
               fmt::format("{}: its base mesh alone takes {} bytes, {} were asked for",
                           command.stream.string(), smallest, most)};
}

}  // namespace

Result<void> run_cut(const CutCommand& command, Console& console) {
  if (Result<void> ok =
          check_output_named(command.output, ".ncr", command.common.overwrite, command.stream);
      !ok) {
    return ok;
  }
  Result<Cut> cut = command.choice.bytes ? cut_to_size(command, *command.choice.bytes)
                                         : cut_to(command, command.choice);
  if (!cut) return cut.error();
  if (console.cancelled()) return Error{ErrorCode::kCancelled, "interrupted; nothing was written"};
  Result<void> written = write_output(command.output, cut->bytes, command.common.overwrite);
  if (!written) return written;
  const codec::StreamInfo& info = cut->prefix.info;
  const int level = cut->prefix.level;
  const std::string quality = level_quality_text(info, level);
  console.note(fmt::format("{} {} -> {} {}, level {} of {}, {} faces{}{}",
                           command.stream.filename().string(), format_bytes(info.bytes_present),
                           command.output.filename().string(), format_bytes(cut->bytes.size()),
                           level, info.levels.size() - 1,
                           format_count(info.levels[static_cast<std::size_t>(level)].triangles),
                           quality.empty() ? "" : ", ", quality));
  return {};
}

}  // namespace nacre::app
