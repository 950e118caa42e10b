// SPDX-License-Identifier: GPL-3.0-or-later
#include "remesh/remesh.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <utility>

#include "app/estimate.h"
#include "app/files.h"
#include "app/remesh_stage.h"
#include "app/verbs.h"
#include "io/io.h"
#include "io/write.h"
#include "wavelet/wavelet.h"

namespace nacre::app {
namespace {

Result<void> check_outputs(const RemeshCommand& command) {
  if (command.output.empty()) return {};  // stops before
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

Result<void> run_remesh(const RemeshCommand& command, Console& console) {
  if (Result<void> ok = check_outputs(command); !ok) return ok;
  Dumper dumper(command.dump, command.common.overwrite);
  if (Result<void> ok = dumper.check(); !ok) return ok;
  if (dumper.starts_at_or_after(DumpStage::kCoefficients))
    return Error{ErrorCode::kBadInput,
                 fmt::format("{}: is a stage of encode; remesh ends with 05-normal-mesh",
                             command.dump.from.string())};
  StageClock clock;
  Result<Prepared> prepared = read_input(command.scan, clock, console);
  if (!prepared) return prepared.error();
  const Result<bool> enough = only_estimates(command.common, prepared->input, false);
  if (!enough) return enough.error();
  if (*enough) return {};
  if (Result<void> ok = remesh_input(*prepared, command.remesh, clock, console, &dumper); !ok)
    return ok;
  note_remesh(*prepared, console);
  if (prepared->stopped_after) {
    console.note(stopped_line(*prepared->stopped_after, command.dump));
    return {};
  }
  Result<TriangleMesh> mesh = to_triangles(prepared->remesh.mesh);
  if (!mesh) return in_file(mesh.error(), command.scan);
  Result<metric::Comparison> distance =
      measure(prepared->scan, *mesh, command.samples, command.scan, console);
  if (!distance) return distance.error();
  clock.finish("measure");
  if (Result<void> go_on = check_cancelled(console); !go_on) return go_on;

  const RemeshRun run{command,       prepared->input, remesh_facts(prepared->remesh),
                      *distance,     clock.costs(),   clock.total_seconds(),
                      prepared->from};
  if (Result<void> written = write_outputs(run, *mesh); !written) return written;
  for (const std::string& line : describe_costs(run.costs)) console.detail(line);
  console.note(describe(run.distance));
  console.note(summary_line(run));
  return {};
}

}  // namespace nacre::app
