// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/files.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <string>
#include <system_error>
#include <utility>

#include "base/topology.h"
#include "codec/comparators.h"
#include "codec/decode.h"
#include "io/io.h"
#include "io/write.h"
#include "remesh/remesh.h"

namespace nacre::app {
namespace fs = std::filesystem;

Error in_file(Error error, const fs::path& file) {
  std::ranges::replace(error.message, '\n', ' ');
  if (error.message.find(file.string()) == std::string::npos) {
    error.message = fmt::format("{}: {}", file.string(), error.message);
  }
  return error;
}

Error stream_error(Error error, const fs::path& file) {
  if (error.code == ErrorCode::kBadInput || error.code == ErrorCode::kLimitExceeded) {
    error.code = ErrorCode::kCorruptStream;
  }
  // Most of the decoder's messages name the place themselves.
  const std::string place = fmt::format(" (byte {})", error.where);
  if (error.code == ErrorCode::kCorruptStream && error.where > 0 &&
      !error.message.ends_with(place)) {
    error.message += place;
  }
  return in_file(std::move(error), file);
}

Error surface_error(Error error, const fs::path& file) {
  if (error.code == ErrorCode::kBadInput) error.code = ErrorCode::kGeometryRefused;
  return in_file(std::move(error), file);
}

bool has_extension(const fs::path& file, std::string_view extension) {
  return std::ranges::equal(file.extension().string(), extension, [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == b;
  });
}

bool is_stream_name(const fs::path& file) { return has_extension(file, ".ncr"); }

Result<void> check_output(const fs::path& output, bool overwrite, const fs::path& input) {
  const auto error = [&](ErrorCode code, std::string what) {
    return Error{code, fmt::format("{}: {}", output.string(), what)};
  };
  std::error_code ignored;
  if (fs::is_directory(output, ignored)) {
    return error(ErrorCode::kBadInput, "is a folder; name a file in it");
  }
  if (fs::equivalent(output, input, ignored)) {
    return error(ErrorCode::kBadInput, "is the input itself; choose another output");
  }
  if (!overwrite && fs::exists(fs::symlink_status(output, ignored))) {
    return error(ErrorCode::kBadInput, "exists already; use -f to overwrite it");
  }
  const fs::path folder = output.has_parent_path() ? output.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, ignored)) {
    return error(ErrorCode::kCannotWrite, "its folder does not exist; create it first");
  }
  if (access(folder.c_str(), W_OK | X_OK) != 0) {
    return error(ErrorCode::kCannotWrite, "its folder may not be written; choose another one");
  }
  return {};
}

Result<void> check_output_named(const fs::path& output, std::string_view extension, bool overwrite,
                                const fs::path& input) {
  if (!has_extension(output, extension)) {
    return Error{ErrorCode::kBadInput, fmt::format("{}: the name of this output must end in {}",
                                                   output.string(), extension)};
  }
  return check_output(output, overwrite, input);
}

Result<void> write_output(const fs::path& output, std::span<const std::uint8_t> bytes,
                          bool overwrite) {
  Result<void> written = io::write_file(output, bytes, overwrite);
  if (written) return {};
  Error error = in_file(written.error(), output);
  // Somebody else made the file since check_output().
  std::error_code ignored;
  if (!overwrite && fs::exists(output, ignored)) error.code = ErrorCode::kBadInput;
  return error;
}

Result<void> write_output(const fs::path& output, std::string_view text, bool overwrite) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(text.data());
  return write_output(output, std::span(bytes, text.size()), overwrite);
}

Result<TriangleMesh> to_triangles(const SemiRegularMesh& mesh, int level) {
  const int wanted = level < 0 ? mesh.level_count : std::min(level, mesh.level_count);
  Result<Topology> topology = Topology::build(mesh.base_triangles, mesh.base_vertex_count, wanted);
  if (!topology) return topology.error();
  const LevelTopology& finest = topology->level(wanted);
  if (finest.vertex_count > mesh.positions.size()) {
    return Error{ErrorCode::kBadInput, "the mesh has fewer positions than vertices"};
  }
  TriangleMesh triangles;
  triangles.positions.assign(mesh.positions.begin(), mesh.positions.begin() + finest.vertex_count);
  triangles.triangles = finest.triangles;
  triangles.origin = mesh.origin;
  return triangles;
}

Result<Scan> load_surface(const fs::path& file) {
  if (!is_stream_name(file)) {
    Result<io::ReadResult> read = io::read_scan(file);
    if (!read) return in_file(read.error(), file);
    return std::move(read->scan);
  }
  Result<std::vector<std::uint8_t>> bytes = io::read_file(file);
  if (!bytes) return in_file(bytes.error(), file);
  codec::DecodeOptions options;
  options.comparators = codec::decode_comparator_bands;
  Result<SemiRegularMesh> mesh = codec::decode(*bytes, options);
  if (!mesh) return stream_error(mesh.error(), file);
  Result<TriangleMesh> triangles = to_triangles(*mesh);
  if (!triangles) return stream_error(triangles.error(), file);
  return triangles;
}

Scan drawable(const Scan& scan) {
  Result<remesh::CleanScan> cleaned = remesh::clean(scan);
  return cleaned ? std::move(cleaned->scan) : scan;
}

bool has_area(const Scan& scan) {
  return std::ranges::any_of(scan.triangles, [&](const Triangle& t) {
    const Vec3& p = scan.positions[t[0]];
    return norm(cross(scan.positions[t[1]] - p, scan.positions[t[2]] - p)) > 0;
  });
}

Box bounding_box(const Scan& scan) {
  Box box;
  bool first = true;
  for (const Triangle& triangle : scan.triangles) {
    for (const std::uint32_t v : triangle) {
      const Vec3& p = scan.positions[v];
      box.low = first ? p : box.low.cwiseMin(p).eval();
      box.high = first ? p : box.high.cwiseMax(p).eval();
      first = false;
    }
  }
  return box;
}

double bbox_diagonal(const Scan& scan) {
  const Box box = bounding_box(scan);
  return norm(box.high - box.low);
}

}  // namespace nacre::app
