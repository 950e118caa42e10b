// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/decode.h"

#include <fmt/format.h>

#include <utility>

#include "app/files.h"
#include "app/report.h"
#include "app/sizes.h"
#include "app/verbs.h"
#include "codec/comparators.h"
#include "io/write.h"

namespace nacre::app {
namespace {

Result<SemiRegularMesh> decode_stream(const DecodeCommand& command,
                                      std::span<const std::uint8_t> bytes) {
  codec::DecodeOptions options;
  options.max_level = command.level;
  options.accept_prefix = command.partial;
  options.comparators = codec::decode_comparator_bands;
  Result<SemiRegularMesh> mesh = codec::decode(bytes, options);
  if (!mesh) return stream_error(mesh.error(), command.stream);
  if (mesh->level_count < command.level) {
    return Error{ErrorCode::kBadInput,
                 fmt::format("{}: has levels 0 to {} only, --level asks for {}",
                             command.stream.string(), mesh->level_count, command.level)};
  }
  return mesh;
}

}  // namespace

Result<void> run_decode(const DecodeCommand& command, Console& console) {
  Result<io::MeshFormat> format = io::mesh_format(command.output);
  if (!format) return in_file(format.error(), command.output);
  if (Result<void> ok = check_output(command.output, command.common.overwrite, command.stream);
      !ok) {
    return ok;
  }
  const StageClock clock;
  Result<std::vector<std::uint8_t>> bytes = io::read_file(command.stream);
  if (!bytes) return in_file(bytes.error(), command.stream);
  Result<SemiRegularMesh> mesh = decode_stream(command, *bytes);
  if (!mesh) return mesh.error();
  Result<TriangleMesh> triangles = to_triangles(*mesh);
  if (!triangles) return stream_error(triangles.error(), command.stream);
  Result<std::vector<std::uint8_t>> file = io::serialize_mesh(*triangles, *format);
  if (!file) return in_file(file.error(), command.output);
  if (console.cancelled()) return Error{ErrorCode::kCancelled, "interrupted; nothing was written"};
  Result<void> written = write_output(command.output, *file, command.common.overwrite);
  if (!written) return written;
  console.note(fmt::format("{} {} -> {} {} faces {}, level {}, {:.1f} s",
                           command.stream.filename().string(), format_bytes(bytes->size()),
                           command.output.filename().string(),
                           format_count(triangles->triangles.size()), format_bytes(file->size()),
                           mesh->level_count, clock.total_seconds()));
  return {};
}

}  // namespace nacre::app
