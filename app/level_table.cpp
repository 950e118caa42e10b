// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/level_table.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "app/files.h"
#include "codec/comparators.h"
#include "codec/edit_stream.h"
#include "codec/push_reader.h"

namespace nacre::app {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::infinity();
constexpr std::uint64_t kLeastFileShare = 100;  // of the table: 1 %

class Measurer {
 public:
  Measurer(const Scan& scan, metric::Surface surface, const LevelTableOptions& options,
           Console& console)
      : scan_(scan), surface_(std::move(surface)), options_(options), console_(console) {}

  Result<codec::LevelTable::Cut> measure(const SemiRegularMesh& mesh, bool is_finest) const {
    const Result<TriangleMesh> triangles = to_triangles(mesh);
    if (!triangles) return triangles.error();
    // A mesh folded to nothing has no surface to measure; it is rated as useless as it is.
    if (!has_area(*triangles)) return codec::LevelTable::Cut{0, kUnknown};
    Result<metric::Comparison> distance = compare(*triangles, is_finest);
    if (!distance) return distance.error();
    Result<metric::Certified> certified = certify(*triangles, is_finest);
    if (!certified) return certified.error();
    return codec::LevelTable::Cut{std::max(distance->psnr_db, 0.0), certified->upper()};
  }

  [[nodiscard]] double bbox_diagonal() const { return surface_.bbox_diagonal(); }

 private:
  [[nodiscard]] Result<metric::Comparison> compare(const TriangleMesh& level,
                                                   bool is_finest) const {
    if (is_finest && options_.finest) return *options_.finest;
    metric::Options sampling;
    sampling.samples = is_finest ? options_.samples : std::min(options_.samples, kCoarseSamples);
    return metric::compare(scan_, surface_, level, sampling, console_.context());
  }
  [[nodiscard]] Result<metric::Certified> certify(const TriangleMesh& level, bool is_finest) const {
    if (is_finest && options_.finest_certified) return *options_.finest_certified;
    return metric::certified_distance(scan_, surface_, level, {}, console_.context());
  }

  const Scan& scan_;
  metric::Surface surface_;
  const LevelTableOptions& options_;
  Console& console_;
};

}  // namespace

std::size_t reserved_table_bytes(LevelTableMode mode, codec::Profile profile, int levels,
                                 std::uint64_t target_bytes) {
  const std::size_t bytes = codec::level_table_bytes(profile, levels);
  if (mode == LevelTableMode::kOn) return bytes;
  return mode == LevelTableMode::kAuto && bytes * kLeastFileShare <= target_bytes ? bytes : 0;
}

Result<void> fill_level_table(std::vector<std::uint8_t>& stream, const Scan& scan,
                              const LevelTableOptions& options, Console& console) {
  codec::DecodeOptions decoding;
  decoding.comparators = codec::decode_comparator_bands;
  const Result<codec::StreamInfo> info = codec::inspect(stream, decoding);
  if (!info) {
    return Error{ErrorCode::kNoConvergence,
                 "the coded scan does not decode: " + info.error().message};
  }
  Result<metric::Surface> surface = metric::Surface::build(scan);
  if (!surface) return surface_error(surface.error(), "the scan");
  const Measurer measurer(scan, std::move(*surface), options, console);
  codec::LevelTable table;
  table.bbox_diagonal = measurer.bbox_diagonal();
  const auto finest = static_cast<int>(info->levels.size()) - 1;
  Result<void> measured;
  codec::PushReader reader(decoding);
  const Result<void> decoded = reader.push(stream, [&](const SemiRegularMesh& mesh) {
    if (!measured) return;
    // Levels that come together with a finer one, as those of nmc do, are not known.
    table.cuts.resize(static_cast<std::size_t>(mesh.level_count), {0, kUnknown});
    Result<codec::LevelTable::Cut> cut = measurer.measure(mesh, mesh.level_count == finest);
    if (cut) {
      table.cuts.push_back(*cut);
    } else {
      measured = cut.error();
    }
  });
  if (!decoded) {
    return Error{ErrorCode::kNoConvergence,
                 "the coded scan does not decode: " + decoded.error().message};
  }
  if (!measured) return measured;
  Result<std::vector<std::uint8_t>> with_table =
      codec::with_quality(stream, table, info->certified_error);
  if (!with_table) return with_table.error();
  stream = std::move(*with_table);
  return {};
}

}  // namespace nacre::app
