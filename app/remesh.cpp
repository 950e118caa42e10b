// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/remesh.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <utility>

#include "app/files.h"
#include "app/remesh_stage.h"
#include "app/verbs.h"
#include "io/io.h"
#include "io/write.h"
#include "wavelet/wavelet.h"

namespace nacre::app {
namespace {

Result<void> check_outputs(const RemeshCommand& command) {
  Result<io::MeshFormat> format = io::mesh_format(command.output);
  if (!format) return in_file(format.error(), command.output);
  if (Result<void> ok = check_output(command.output, command.common.overwrite, command.scan); !ok) {
    return ok;
  }
  if (command.report.empty()) return {};
  return check_output_named(command.report, ".json", command.common.overwrite, command.scan);
}

Result<void> write_outputs(const RemeshRun& run, const TriangleMesh& mesh) {
  const RemeshCommand& command = run.command;
  Result<io::MeshFormat> format = io::mesh_format(command.output);
  if (!format) return in_file(format.error(), command.output);
  Result<std::vector<std::uint8_t>> bytes = io::serialize_mesh(mesh, *format);
  if (!bytes) return in_file(bytes.error(), command.output);
  Result<void> written = write_output(command.output, *bytes, command.common.overwrite);
  if (!written || command.report.empty()) return written;
  return write_output(command.report, to_json(run), command.common.overwrite);
}

}  // namespace

Result<void> check_cancelled(const Console& console) {
  if (!console.cancelled()) return {};
  return Error{ErrorCode::kCancelled, "interrupted; nothing was written"};
}

Result<metric::Comparison> measure(const Scan& scan, const Scan& other, std::size_t samples,
                                   const std::filesystem::path& file, Console& console) {
  metric::Options options;
  options.samples = samples;
  Result<metric::Comparison> comparison = metric::compare(scan, other, options, console.context());
  if (!comparison) return surface_error(comparison.error(), file);
  return comparison;
}

Result<Prepared> read_and_remesh(const std::filesystem::path& file, const RemeshSettings& settings,
                                 StageClock& clock, Console& console, Dumper* dumper) {
  console.context().report("read", 0);
  Result<io::ReadResult> read = io::read_scan(file);
  if (!read) return in_file(read.error(), file);
  if (!has_area(read->scan)) {
    return Error{
        ErrorCode::kGeometryRefused,
        fmt::format("{}: no face has an area, so there is no surface to code", file.string())};
  }
  Prepared prepared;
  prepared.input = input_facts(file, *read);
  prepared.input.bbox_diagonal = bbox_diagonal(read->scan);
  prepared.scan = std::move(read->scan);
  clock.finish("read");
  if (!prepared.input.read.not_carried.empty()) {
    console.note(fmt::format("not carried: {}", fmt::join(prepared.input.read.not_carried, ", ")));
  }
  if (Result<void> go_on = check_cancelled(console); !go_on) return go_on.error();

  remesh::Options options;
  options.levels = settings.levels;
  options.base_vertices = settings.base_vertices;
  options.repair = settings.repair;
  options.predict = wavelet::predict;
  if (dumper != nullptr) {
    dumper->input(prepared.scan);
    options.observer = dumper->observer();
  }
  Result<remesh::Remesh> remeshed = remesh::remesh(prepared.scan, options, console.context());
  const Result<void> dumped = dumper != nullptr ? dumper->finish() : Result<void>();
  if (!remeshed) return in_file(remeshed.error(), file);
  if (!dumped) return dumped.error();
  prepared.remesh = std::move(*remeshed);
  clock.finish("remesh", prepared.remesh.costs);
  const std::string cleaning = describe_cleaning(prepared.remesh.clean);
  if (!cleaning.empty()) console.note(cleaning);
  for (const std::string& line : describe_fallbacks(prepared.remesh.pieces)) console.warning(line);
  if (Result<void> go_on = check_cancelled(console); !go_on) return go_on.error();
  return prepared;
}

Result<void> run_remesh(const RemeshCommand& command, Console& console) {
  if (Result<void> ok = check_outputs(command); !ok) return ok;
  Dumper dumper(command.dump, command.common.overwrite);
  if (Result<void> ok = dumper.check(); !ok) return ok;
  StageClock clock;
  Result<Prepared> prepared =
      read_and_remesh(command.scan, command.remesh, clock, console, &dumper);
  if (!prepared) return prepared.error();
  Result<TriangleMesh> mesh = to_triangles(prepared->remesh.mesh);
  if (!mesh) return in_file(mesh.error(), command.scan);
  Result<metric::Comparison> distance =
      measure(prepared->scan, *mesh, command.samples, command.scan, console);
  if (!distance) return distance.error();
  clock.finish("measure");
  if (Result<void> go_on = check_cancelled(console); !go_on) return go_on;

  const RemeshRun run{command,   prepared->input, remesh_facts(prepared->remesh),
                      *distance, clock.costs(),   clock.total_seconds()};
  if (Result<void> written = write_outputs(run, *mesh); !written) return written;
  for (const std::string& line : describe_costs(run.costs)) console.detail(line);
  console.note(describe(run.distance));
  console.note(summary_line(run));
  return {};
}

}  // namespace nacre::app
