// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/assemble.h"

#include <limits>
#include <string>

#include "codec/comparators.h"
#include "codec/stream_format.h"
#include "codec/stream_writer.h"

namespace nacre::codec {

std::vector<std::uint8_t> assemble(const Prepared& prepared, const CodedGeometry& coded,
                                   Profile profile, const Vec3& origin) {
  Header header;
  header.profile = profile;
  header.transform = prepared.transform;
  header.levels = prepared.topology.level_count();
  header.origin = origin;
  const LevelTopology& base = prepared.topology.level(0);
  header.base_vertices = base.vertex_count;
  header.base_triangles = base.triangles.size();
  header.boundary_edges = 2 * base.edges.size() - 3 * base.triangles.size();
  header.grid_bits = coded.base.grid_bits;
  header.grid_step_index = coded.steps[0];
  header.grid_corner = coded.base.corner;
  std::vector<std::vector<std::uint8_t>> payloads;
  for (std::size_t j = 0; j < coded.bands.size(); ++j) {
    header.bands.push_back({0, coded.steps[j + 1]});
    payloads.push_back(coded.bands[j].payload);
  }
  return write_stream(header, prepared.connectivity.bytes, coded.base.payload, payloads);
}

Error base_too_large(std::size_t smallest_bytes, std::size_t target_bytes) {
  return {ErrorCode::kGoalUnreachable,
          "the base mesh alone takes " + std::to_string(smallest_bytes) + " bytes, " +
              std::to_string(target_bytes) + " were asked for",
          smallest_bytes};
}

Error encoding_cancelled() { return {ErrorCode::kCancelled, "encoding was cancelled", 0}; }

Result<Encoded> verified(const Prepared& prepared, EncodeReport report,
                         std::vector<std::uint8_t> bytes) {
  const auto decoded = decode(
      bytes, {-1, std::numeric_limits<std::uint64_t>::max(), false, decode_comparator_bands});
  if (!decoded) return decoded.error();
  report.measured_distortion = mean_squared_difference(decoded->positions, prepared.positions);
  return Encoded{std::move(bytes), std::move(report), {}};
}

EncodeReport describe(const Prepared& prepared, const CodedGeometry& coded,
                      std::size_t file_bytes) {
  const auto sized = [](const std::vector<std::uint8_t>& payload) {
    return payload.size() + checksum_bytes(payload.size());
  };
  EncodeReport report;
  report.bytes = file_bytes;
  report.bytes_base_connectivity = sized(prepared.connectivity.bytes);
  report.bytes_base_positions = sized(coded.base.payload);
  report.bytes_base = report.bytes_base_connectivity + report.bytes_base_positions;
  report.bytes_header = report.bytes - report.bytes_base;
  report.base_bits = coded.base.grid_bits;
  report.levels = prepared.topology.level_count();
  for (std::size_t j = 0; j < coded.bands.size(); ++j) {
    const CodedBand& part = coded.bands[j];
    BandReport band;
    band.vertices = part.decoded.size();
    band.step = part.payload.empty() ? 0 : step_size(coded.steps[j + 1]);
    band.bits = 8.0 * static_cast<double>(sized(part.payload));
    band.normal_only_fraction = part.normal_only_fraction;
    band.distortion = part.distortion;
    report.bytes_header -= sized(part.payload);
    report.bands.push_back(std::move(band));
  }
  return report;
}

}  // namespace nacre::codec
