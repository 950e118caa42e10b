// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/coded_point.h"

#include <fmt/format.h>

#include <span>

#include "base/parallel.h"
#include "bench/support.h"
#include "codec/comparators.h"
#include "io/write.h"

namespace nacre::bench {
namespace {

constexpr double kTimeout = 900;

/// Decodes and measures.
void measure(const PreparedScan& scan, std::span<const std::uint8_t> bytes, std::size_t samples,
             CodedPoint& out) {
  const auto decoded = codec::decode(bytes, {.comparators = codec::decode_comparator_bands});
  const auto distance = decoded ? distance_to_scan(scan, *decoded, samples)
                                : Result<metric::Comparison>(decoded.error());
  if (!distance) {
    out.error = distance.error();
    return;
  }
  out.point = rate_point(bytes.size(), *distance);
}

void code_point(const PreparedScan& scan, const SemiRegularMesh& mesh, std::size_t samples,
                CodedPoint& out) {
  codec::EncodeOptions options;
  options.profile = out.profile;
  options.target_bytes = out.target_bytes;
  auto encoded = codec::encode(mesh, options);
  if (!encoded) {
    out.error = encoded.error();
    return;
  }
  measure(scan, encoded->bytes, samples, out);
  out.report = std::move(encoded->report);
}

}  // namespace

std::vector<CodedPoint> code_points(const PreparedScan& scan,
                                    const std::vector<codec::Profile>& profiles,
                                    const std::vector<std::size_t>& sizes, std::size_t samples,
                                    const std::vector<SemiRegularMesh>& meshes) {
  std::vector<CodedPoint> points;
  for (const codec::Profile profile : profiles)
    for (const std::size_t bytes : sizes) points.push_back({profile, bytes, {}, {}, {}});
  parallel_for_each_index(
      points.size(),
      [&](std::size_t i) {
        const SemiRegularMesh& mesh = meshes.empty() ? scan.mesh : meshes[i % sizes.size()];
        code_point(scan, mesh, samples, points[i]);
      },
      1);
  return points;
}

std::vector<CodedPoint> command_points(const PreparedScan& scan, const std::string& file,
                                       const std::string& nacre,
                                       const std::vector<std::size_t>& sizes, std::size_t samples) {
  const TemporaryFolder folder;
  const std::string coded = folder.path() / "coded.ncr";
  std::vector<CodedPoint> points;
  for (const std::size_t bytes : sizes) {
    CodedPoint& point = points.emplace_back();
    point.target_bytes = bytes;
    const ChildRun run =
        run_child({nacre, "encode", file, "-o", coded, "-f", "-q", "--size", std::to_string(bytes)},
                  kTimeout);
    const auto stream = run.ok()
                            ? io::read_file(coded)
                            : Error{ErrorCode::kNoConvergence, "nacre encode: " + run.outcome()};
    if (!stream) {
      point.error = stream.error();
      continue;
    }
    measure(scan, *stream, samples, point);
  }
  return points;
}

std::vector<RatePoint> curve_of(const std::vector<CodedPoint>& points, codec::Profile profile) {
  std::vector<RatePoint> out;
  for (const CodedPoint& p : points)
    if (p.profile == profile && !p.error) out.push_back(p.point);
  return out;
}

void write_text(const std::filesystem::path& file, const std::string& text) {
  std::error_code ignored;
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), ignored);
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(text.data());
  const auto done = io::write_file(file, std::span(bytes, text.size()), true);
  if (!done) fmt::print(stderr, "{}: {}\n", file.string(), done.error().message);
}

}  // namespace nacre::bench
