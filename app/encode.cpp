// SPDX-License-Identifier: GPL-3.0-or-later
//
// The quality that is reported was measured on the bytes that are written: they are decoded and
// compared with the scan as read before the file is made, so a run that fails anywhere, or is
// interrupted, leaves nothing behind.
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "app/code_scan.h"
#include "app/estimate.h"
#include "app/files.h"
#include "app/level_table.h"
#include "app/remesh_stage.h"
#include "app/report.h"
#include "app/report_html.h"
#include "app/stage_recode.h"
#include "app/verbs.h"
#include "base/parallel.h"
#include "codec/edit_stream.h"

namespace nacre::app {
namespace {

bool wants_page(const EncodeCommand& command) { return command.report.extension() == ".html"; }

Result<void> check_outputs(const EncodeCommand& command) {
  const bool overwrite = command.common.overwrite;
  if (command.output.empty()) return {};  // stops before
  Result<void> ok = check_output_named(command.output, ".ncr", overwrite, command.scan);
  if (!ok || command.report.empty()) return ok;
  const char* extension = wants_page(command) ? ".html" : ".json";
  return check_output_named(command.report, extension, overwrite, command.scan);
}

/// Puts into the file what its header may say of its quality.
Result<void> add_quality(const EncodeCommand& command, const Reference& reference, Coded& coded,
                         Console& console) {
  std::vector<std::uint8_t>& bytes = coded.encoded.bytes;
  const std::uint64_t target = coded.size_limit != 0 ? coded.size_limit : bytes.size();
  const bool has_table = reserved_table_bytes(command.level_table, command.profile,
                                              coded.encoded.report.levels, target) > 0;
  if (command.certify) {
    if (!coded.certified) {
      auto certified = certify(reference, coded, console);
      if (!certified) return in_file(certified.error(), command.scan);
      coded.certified = std::move(*certified);
    }
    auto with = codec::with_quality(bytes, std::nullopt, coded.certified->upper());
    if (!with) return in_file(with.error(), command.scan);
    bytes = std::move(*with);
  }
  if (!has_table) return {};
  LevelTableOptions options;
  options.samples = command.samples;
  options.finest = coded.distance;
  options.finest_certified = coded.certified;
  return fill_level_table(bytes, reference.scan, options, console);
}

/// The normal mesh against the scan: as dear as the file's own measurement, so only for who will
/// see it.
Result<void> measure_remesh(EncodeRun& run, const Prepared& prepared, const Reference& reference,
                            StageClock& clock, Console& console) {
  const EncodeCommand& command = run.command;
  if (command.report.empty() && !console.verbose()) return {};
  if (prepared.remesh.mesh.positions.empty()) return {};  // the run started behind it
  Result<TriangleMesh> normal_mesh = to_triangles(prepared.remesh.mesh);
  if (!normal_mesh) return in_file(normal_mesh.error(), command.scan);
  metric::Options sampling;
  sampling.samples = command.samples;
  Result<metric::Comparison> distance =
      metric::compare(reference.scan, reference.surface, *normal_mesh, sampling, console.context());
  if (!distance) return surface_error(distance.error(), command.scan);
  run.remesh_distance = *distance;
  clock.finish("measure_remesh");
  return {};
}

Result<void> write_outputs(const EncodeRun& run, const Prepared& prepared, const Coded& coded,
                           Console& console) {
  const EncodeCommand& command = run.command;
  std::string report;
  if (wants_page(command)) {
    const auto extras =
        html_extras(run, prepared.scan, prepared.remesh.mesh, coded.encoded.bytes, console);
    if (!extras) return extras.error();
    report = to_html(run, *extras);
  } else if (!command.report.empty()) {
    report = to_json(run);
  }
  Result<void> written =
      write_output(command.output, coded.encoded.bytes, command.common.overwrite);
  if (!written || command.report.empty()) return written;
  return write_output(command.report, report, command.common.overwrite);
}

void print_summary(const EncodeRun& run, const Coded& coded, Console& console) {
  for (const std::string& line : describe_costs(run.costs)) console.detail(line);
  if (run.remesh_distance) {
    console.detail(fmt::format("remesh alone: PSNR {:.2f} dB", run.remesh_distance->psnr_db));
  }
  console.detail(describe(run.distance));
  if (run.certified) console.detail(describe(*run.certified));
  if (!coded.remark.empty()) console.note(coded.remark);
  console.note(summary_line(run));
}

/// The end of a run that was asked to stop early.
Result<void> finish_dumps(const EncodeCommand& command, Dumper& dumper, Console& console) {
  if (Result<void> dumped = dumper.finish(); !dumped) return dumped;
  console.note(stopped_line(*command.dump.until, command.dump));
  return {};
}

/// From the coded scan to the files.
Result<void> finish(const EncodeCommand& command, const Prepared& prepared,
                    const Reference& reference, Coded& coded, StageClock& clock, Console& console) {
  if (Result<void> ok = add_quality(command, reference, coded, console); !ok) return ok;
  clock.finish("level_table");
  EncodeRun run;
  run.command = command;
  run.input = prepared.input;
  run.remesh = remesh_facts(prepared.remesh);
  run.target_bytes = coded.size_limit;
  run.from = prepared.from;
  run.coded = coded.encoded.report;
  run.coded.bytes = coded.encoded.bytes.size();
  run.distance = coded.distance;
  run.certified = coded.certified;
  const auto info = codec::inspect(coded.encoded.bytes, decoding_options());
  if (!info) return in_file(info.error(), command.scan);
  run.coded.bytes_header = info->bytes_header;  // with what add_quality() put there
  run.command.profile = info->profile;  // a run from dumped steps takes theirs, not the option's
  run.command.transform = info->transform;
  run.levels = level_facts(*info);
  if (Result<void> ok = measure_remesh(run, prepared, reference, clock, console); !ok) return ok;
  if (Result<void> go_on = check_cancelled(console); !go_on) return go_on;
  run.costs = clock.costs();
  run.seconds = clock.total_seconds();
  if (Result<void> written = write_outputs(run, prepared, coded, console); !written) return written;
  print_summary(run, coded, console);
  return {};
}

}  // namespace

Result<void> run_encode(const EncodeCommand& command, Console& console) {
  if (Result<void> ok = check_outputs(command); !ok) return ok;
  Dumper dumper(command.dump, command.common.overwrite);
  if (Result<void> ok = check_stages(command, dumper); !ok) return ok;
  StageClock clock;
  Result<Prepared> prepared = read_input(command.scan, clock, console);
  if (!prepared) return prepared.error();
  const Result<bool> enough =
      only_estimates(command.common, prepared->input, true,
                     first_settings(command, prepared->input).least_triangles);
  if (!enough) return enough.error();
  if (*enough) return {};
  if (Result<void> ok = read_reference(command.reference, *prepared, console); !ok) return ok;
  Result<void> remeshed;
  std::optional<Result<metric::Surface>> surface;
  std::optional<double> simplified_psnr;
  in_parallel(
      [&] {
        remeshed = remesh_input(*prepared, first_settings(command, prepared->input), clock, console,
                                &dumper);
      },
      [&] {
        surface = metric::Surface::build(prepared->scan);
        if (!*surface) return;
        simplified_psnr =
            early_simplified_psnr(command, *prepared, {prepared->scan, **surface}, console);
      });
  if (!remeshed) return remeshed;
  if (!prepared->stopped_after) dumper.coefficients(prepared->remesh.mesh, command.transform);
  if (stops_by(command, DumpStage::kCoefficients)) {
    note_remesh(*prepared, console);
    return finish_dumps(command, dumper, console);
  }
  if (!*surface) return surface_error(surface->error(), command.scan);
  const Reference reference{prepared->scan, **surface};
  Result<Coded> coded =
      recodes(dumper)
          ? measured(command, recode(*dumper.entry(), prepared->remesh.mesh), reference, console)
          : code_scan(command, *prepared, reference, simplified_psnr, clock, console);
  if (!coded) return coded.error();
  note_remesh(*prepared, console);
  dumper.coded(coded->encoded, coded->options);
  if (stops_by(command, DumpStage::kStream)) return finish_dumps(command, dumper, console);
  if (Result<void> dumped = dumper.finish(); !dumped) return dumped;
  return finish(command, *prepared, reference, *coded, clock, console);
}

}  // namespace nacre::app
