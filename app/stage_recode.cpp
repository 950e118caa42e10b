// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/stage_recode.h"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "app/files.h"
#include "app/goal.h"
#include "app/json.h"
#include "codec/comparators.h"
#include "codec/decode.h"
#include "codec/recode.h"
#include "codec/symbols.h"

namespace nacre::app {
namespace {

bool has_no_symbols(codec::Profile profile) {
  return profile == codec::Profile::kNmc || profile == codec::Profile::kEqmc;
}

/// What the bytes say of themselves, in the shape of what an encoder says of them.
codec::EncodeReport report_of(const codec::StreamInfo& info) {
  codec::EncodeReport report;
  report.bytes = info.bytes_whole;
  report.base_bits = info.base_bits;
  report.levels = static_cast<int>(info.levels.size()) - 1;
  report.bytes_header = report.bytes;
  for (std::size_t i = 0; i < info.sections.size(); ++i) {
    const codec::StreamInfo::Section& section = info.sections[i];
    report.bytes_header -= section.bytes;
    if (i == 0) report.bytes_base_connectivity = section.bytes;
    if (i == 1) report.bytes_base_positions = section.bytes;
    if (i < 2) continue;
    codec::BandReport band;
    if (i - 1 < info.levels.size())
      band.vertices =
          static_cast<std::size_t>(info.levels[i - 1].vertices - info.levels[i - 2].vertices);
    band.step = section.step;
    band.bits = 8.0 * static_cast<double>(section.bytes);
    report.bands.push_back(std::move(band));
  }
  report.bytes_base = report.bytes_base_connectivity + report.bytes_base_positions;
  return report;
}

/// A stream that was not made by an encoder just now: it must at least decode.
Result<codec::Encoded> checked(std::vector<std::uint8_t> bytes, const std::filesystem::path& file) {
  codec::DecodeOptions options;
  options.comparators = codec::decode_comparator_bands;
  const auto info = codec::inspect(bytes, options);
  if (!info) return stream_error(info.error(), file);
  const auto decoded = codec::decode(bytes, options);
  if (!decoded) return stream_error(decoded.error(), file);
  return codec::Encoded{std::move(bytes), report_of(*info), {}};
}

void set_coding_options(const EncodeCommand& command, Dumper& dumper) {
  dumper.set_options(DumpStage::kCoefficients,
                     Json{{"transform", name_of(command.transform)}}.dump());
  Json goal = {{"profile", codec::profile_name(command.profile)},
               {"effort", command.effort == codec::Effort::kFast ? "fast" : "normal"},
               {"theta_degrees", command.theta_degrees}};
  goal[std::string(name_of(command.goal.kind))] = command.goal.value;
  dumper.set_options(DumpStage::kRdCurves, goal.dump());
}

}  // namespace

bool stops_by(const EncodeCommand& command, DumpStage stage) {
  return command.dump.until && *command.dump.until <= stage;
}

Result<void> check_stages(const EncodeCommand& command, Dumper& dumper) {
  if (has_no_symbols(command.profile) && command.dump.from.empty()) {
    for (const DumpStage stage : {DumpStage::kSteps, DumpStage::kSymbols})
      if (dumper.wants(stage))
        return Error{ErrorCode::kBadInput,
                     fmt::format("profile {} has no {} that could be dumped; name other stages "
                                 "instead of all",
                                 codec::profile_name(command.profile),
                                 kDumpStageNames[static_cast<std::size_t>(stage)])};
  }
  if (Result<void> ok = dumper.check(); !ok) return ok;
  if (recodes(dumper) && command.has_goal)
    return Error{ErrorCode::kBadInput,
                 fmt::format("{}: has its size already, so a goal cannot be given; go on from "
                             "06-coefficients, or leave the goal out",
                             command.dump.from.string())};
  set_coding_options(command, dumper);
  return {};
}

Result<codec::Encoded> recode(const StageFolder& entry, const SemiRegularMesh& mesh) {
  if (entry.record.stage == DumpStage::kSteps) {
    const auto choice = choice_from(entry);
    if (!choice) return choice.error();
    auto encoded = codec::encode_with_steps(mesh, *choice);
    if (!encoded) return surface_error(encoded.error(), entry.folder);
    return encoded;
  }
  if (entry.record.stage == DumpStage::kSymbols) {
    const auto symbols = symbols_from(entry);
    if (!symbols) return symbols.error();
    auto bytes = codec::write_symbols(*symbols);
    if (!bytes) return surface_error(bytes.error(), entry.folder);
    return checked(std::move(*bytes), entry.folder);
  }
  const auto bytes = entry.file("stream.ncr");
  if (!bytes) return bytes.error();
  return checked({bytes->begin(), bytes->end()}, entry.folder / "stream.ncr");
}

}  // namespace nacre::app
