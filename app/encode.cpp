// SPDX-License-Identifier: GPL-3.0-or-later
//
// The quality that is reported was measured on the bytes that are written: they are decoded and
// compared with the scan as read before the file is made, so a run that fails anywhere, or is
// interrupted, leaves nothing behind.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/files.h"
#include "app/remesh_stage.h"
#include "app/report.h"
#include "app/sizes.h"
#include "app/verbs.h"
#include "codec/codec.h"
#include "codec/comparators.h"
#include "codec/decode.h"

namespace nacre::app {
namespace {

Result<void> check_outputs(const EncodeCommand& command) {
  const bool overwrite = command.common.overwrite;
  Result<void> ok = check_output_named(command.output, ".ncr", overwrite, command.scan);
  if (!ok || command.report.empty()) return ok;
  return check_output_named(command.report, ".json", overwrite, command.scan);
}

/// The goal as bytes of the whole file; at least one, so that the coder can say what it needs.
std::uint64_t target_bytes(const EncodeCommand& command, const InputFacts& input) {
  if (command.size_bytes) return *command.size_bytes;
  const double bits =
      command.bits_per_input_vertex.value_or(1) * static_cast<double>(input.goal_vertices);
  constexpr double kMost = 1e18;  // fits std::uint64_t
  return static_cast<std::uint64_t>(std::clamp(std::floor(bits / 8), 1.0, kMost));
}

Result<codec::Encoded> code(const EncodeCommand& command, const remesh::Remesh& remesh,
                            std::uint64_t target, Console& console) {
  codec::EncodeOptions options;
  options.profile = command.profile;
  options.effort = command.effort;
  options.transform = command.transform;
  options.target_bytes = target;
  options.theta_degrees = command.theta_degrees;
  Result<codec::Encoded> encoded = codec::encode(remesh.mesh, options, console.context());
  if (!encoded) {
    Error error = in_file(encoded.error(), command.scan);
    if (error.code == ErrorCode::kGoalUnreachable && command.bits_per_input_vertex) {
      error.message +=
          fmt::format(" ({} bits per input vertex make {}; ask for more, or use --size)",
                      *command.bits_per_input_vertex, format_bytes(target));
    }
    return error;
  }
  if (encoded->bytes.size() > target) {
    return Error{ErrorCode::kGoalUnreachable,
                 fmt::format("{}: coded to {} bytes, over the {} asked for", command.scan.string(),
                             encoded->bytes.size(), target)};
  }
  return encoded;
}

/// Decodes what will be written. An error here is the coder's fault, not the stream's.
Result<TriangleMesh> decode_again(const EncodeCommand& command, const codec::Encoded& encoded) {
  codec::DecodeOptions options;
  options.comparators = codec::decode_comparator_bands;
  Result<SemiRegularMesh> decoded = codec::decode(encoded.bytes, options);
  Result<TriangleMesh> mesh = decoded ? to_triangles(*decoded) : decoded.error();
  if (mesh) return mesh;
  return Error{ErrorCode::kNoConvergence,
               fmt::format("{}: the coded scan does not decode ({}); please report this scan",
                           command.scan.string(), mesh.error().message)};
}

/// Fills in the figures that need the surfaces.
Result<void> measure_all(EncodeRun& run, const Prepared& prepared, const TriangleMesh& decoded,
                         StageClock& clock, Console& console) {
  const EncodeCommand& command = run.command;
  Result<metric::Comparison> distance =
      measure(prepared.scan, decoded, command.samples, command.scan, console);
  if (!distance) return distance.error();
  run.distance = *distance;
  clock.finish("measure");
  // As dear as the first measurement, so only for who will see it.
  if (command.report.empty() && !console.verbose()) return {};
  Result<TriangleMesh> normal_mesh = to_triangles(prepared.remesh.mesh);
  if (!normal_mesh) return in_file(normal_mesh.error(), command.scan);
  Result<metric::Comparison> remesh_distance =
      measure(prepared.scan, *normal_mesh, command.samples, command.scan, console);
  if (!remesh_distance) return remesh_distance.error();
  run.remesh_distance = *remesh_distance;
  clock.finish("measure_remesh");
  return {};
}

Result<void> write_outputs(const EncodeRun& run, const codec::Encoded& encoded) {
  const EncodeCommand& command = run.command;
  Result<void> written = write_output(command.output, encoded.bytes, command.common.overwrite);
  if (!written || command.report.empty()) return written;
  return write_output(command.report, to_json(run), command.common.overwrite);
}

void print_summary(const EncodeRun& run, Console& console) {
  for (const std::string& line : describe_costs(run.costs)) console.detail(line);
  if (run.remesh_distance) {
    console.detail(fmt::format("remesh alone: PSNR {:.2f} dB", run.remesh_distance->psnr_db));
  }
  console.detail(describe(run.distance));
  console.note(summary_line(run));
}

}  // namespace

Result<void> run_encode(const EncodeCommand& command, Console& console) {
  if (Result<void> ok = check_outputs(command); !ok) return ok;
  StageClock clock;
  Result<Prepared> prepared = read_and_remesh(command.scan, command.remesh, clock, console);
  if (!prepared) return prepared.error();

  EncodeRun run;
  run.command = command;
  run.input = prepared->input;
  run.remesh = remesh_facts(prepared->remesh);
  run.target_bytes = target_bytes(command, run.input);
  Result<codec::Encoded> encoded = code(command, prepared->remesh, run.target_bytes, console);
  if (!encoded) return encoded.error();
  run.coded = encoded->report;
  run.coded.bytes = encoded->bytes.size();
  clock.finish("encode");

  Result<TriangleMesh> decoded = decode_again(command, *encoded);
  if (!decoded) return decoded.error();
  clock.finish("decode");
  if (Result<void> ok = measure_all(run, *prepared, *decoded, clock, console); !ok) return ok;
  if (Result<void> go_on = check_cancelled(console); !go_on) return go_on;

  run.costs = clock.costs();
  run.seconds = clock.total_seconds();
  if (Result<void> written = write_outputs(run, *encoded); !written) return written;
  print_summary(run, console);
  return {};
}

}  // namespace nacre::app
