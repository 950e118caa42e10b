// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/decode.h"

#include <fmt/format.h>

#include <utility>

#include "app/files.h"
#include "app/prefix.h"
#include "app/report.h"
#include "app/sizes.h"
#include "app/verbs.h"
#include "codec/comparators.h"
#include "io/io.h"
#include "io/write.h"

namespace nacre::app {
namespace {

/// Whatever of the file the command needs.
Result<StreamPrefix> read(const DecodeCommand& command) {
  if (!command.choice.is_all()) return read_prefix(command.stream, command.choice, command.partial);
  // All of it: the file is then judged as a whole.
  StreamPrefix whole;
  Result<std::vector<std::uint8_t>> bytes = io::read_file(command.stream);
  if (!bytes) return in_file(bytes.error(), command.stream);
  whole.bytes = std::move(*bytes);
  whole.level = -1;
  return whole;
}

/// Whether the base mesh is there, but not all that the header announces.
bool is_cut_short(std::span<const std::uint8_t> stream) {
  codec::DecodeOptions options;
  options.accept_prefix = true;
  const Result<codec::StreamInfo> info = codec::inspect(stream, options);
  return info && info->bytes_present < info->bytes_whole;
}

Result<SemiRegularMesh> decode_stream(const DecodeCommand& command, const StreamPrefix& prefix) {
  codec::DecodeOptions options;
  options.max_level = prefix.level;
  options.accept_prefix = command.partial || !command.choice.is_all();
  options.comparators = codec::decode_comparator_bands;
  Result<SemiRegularMesh> mesh = codec::decode(prefix.bytes, options);
  if (mesh) return mesh;
  Error error = stream_error(mesh.error(), command.stream);
  if (!options.accept_prefix && is_cut_short(prefix.bytes))
    error.message += "; --partial takes what is there";
  return error;
}

std::string quality_text(const StreamPrefix& prefix) {
  const std::string text =
      prefix.level < 0 ? std::string() : level_quality_text(prefix.info, prefix.level);
  return text.empty() ? text : text + ", ";
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
  const Result<StreamPrefix> prefix = read(command);
  if (!prefix) return prefix.error();
  Result<SemiRegularMesh> mesh = decode_stream(command, *prefix);
  if (!mesh) return mesh.error();
  Result<TriangleMesh> triangles = to_triangles(*mesh);
  if (!triangles) return stream_error(triangles.error(), command.stream);
  Result<std::vector<std::uint8_t>> file = io::serialize_mesh(*triangles, *format);
  if (!file) return in_file(file.error(), command.output);
  if (console.cancelled()) return Error{ErrorCode::kCancelled, "interrupted; nothing was written"};
  Result<void> written = write_output(command.output, *file, command.common.overwrite);
  if (!written) return written;
  console.note(fmt::format("{} {} -> {} {} faces {}, level {}, {}{:.1f} s",
                           command.stream.filename().string(), format_bytes(prefix->bytes.size()),
                           command.output.filename().string(),
                           format_count(triangles->triangles.size()), format_bytes(file->size()),
                           mesh->level_count, quality_text(*prefix), clock.total_seconds()));
  return {};
}

}  // namespace nacre::app
