// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <utility>

#include "app/aims.h"
#include "app/files.h"
#include "app/picture.h"
#include "app/report_html.h"
#include "codec/codec.h"
#include "codec/comparators.h"

namespace nacre::app {
namespace {

constexpr int kPictureSize = 480;
constexpr std::size_t kCurveSamples = 100'000;
/// Sizes of the curve, relative to the file's.
constexpr std::array<double, 4> kCurveSizes = {0.25, 0.5, 2, 4};

Result<Scan> decoded_level(std::span<const std::uint8_t> stream, int level) {
  codec::DecodeOptions options;
  options.comparators = codec::decode_comparator_bands;
  options.max_level = level;
  const Result<SemiRegularMesh> mesh = codec::decode(stream, options);
  if (!mesh) return mesh.error();
  return to_triangles(*mesh);
}

/// Panel i of a rendered row.
Image panel_of(const Image& row, int i) {
  Image panel{row.width / 4, row.height, {}};
  for (int y = 0; y < row.height; ++y) {
    const auto first = row.rgb.begin() + 3 * (std::ptrdiff_t{y} * row.width + i * panel.width);
    panel.rgb.insert(panel.rgb.end(), first, first + 3 * panel.width);
  }
  return panel;
}

Result<std::vector<HtmlExtras::Picture>> pictures(const Scan& raw,
                                                  std::span<const std::uint8_t> stream) {
  const Result<Scan> base = decoded_level(stream, 0), decoded = decoded_level(stream, -1);
  if (!base) return base.error();
  if (!decoded) return decoded.error();
  const Result<metric::Surface> surface = metric::Surface::build(*decoded);
  if (!surface) return surface.error();
  const Scan scan = drawable(raw);
  const std::vector<double> distances = surface->distances(scan.positions);
  std::vector<float> quality(distances.size());
  std::ranges::transform(distances, quality.begin(),
                         [](double d) { return static_cast<float>(d); });
  std::array<Panel, 4> panels;
  panels[0].mesh = &scan;
  panels[1].mesh = &*base;
  panels[1].wire = &*base;
  panels[2].mesh = &*decoded;
  panels[3].mesh = &scan;
  panels[3].quality = quality;
  PictureOptions options;
  options.panel_width = options.panel_height = kPictureSize;
  options.supersampling = 2;
  const Result<Image> row = render(panels, options);
  if (!row) return row.error();
  const char* captions[] = {"the scan", "its base mesh", "decoded", "distance of the scan from it"};
  std::vector<HtmlExtras::Picture> found;
  for (int i = 0; i < 4; ++i) {
    Result<std::vector<std::uint8_t>> png = encode_png(panel_of(*row, i));
    if (!png) return png.error();
    found.push_back({captions[i], std::move(*png)});
  }
  return found;
}

Result<std::vector<HtmlExtras::RdPoint>> rd_curve(const EncodeRun& run, const Scan& scan,
                                                  const SemiRegularMesh& mesh, Console& console) {
  std::vector<HtmlExtras::RdPoint> curve;
  if (mesh.positions.empty()) return curve;
  const Result<metric::Surface> surface = metric::Surface::build(scan);
  if (!surface) return surface_error(surface.error(), run.command.scan);
  codec::EncodeOptions options;
  options.profile = run.command.profile;
  options.effort = run.command.effort;
  options.transform = run.command.transform;
  options.theta_degrees = run.command.theta_degrees;
  const std::vector<Vec3> aims = options.profile == codec::Profile::kBest &&
                                         options.transform == wavelet::Transform::kButterfly
                                     ? aims_between(mesh, {scan, *surface})
                                     : std::vector<Vec3>();
  options.aims = aims;
  for (const double size : kCurveSizes) {
    if (console.cancelled())
      return Error{ErrorCode::kCancelled, "interrupted; nothing was written"};
    options.target_bytes = static_cast<std::size_t>(size * static_cast<double>(run.coded.bytes));
    const Result<codec::Encoded> encoded = codec::encode(mesh, options, console.context());
    // Too few bytes for a base mesh, for instance: a point that is not there.
    if (!encoded) continue;
    const Result<Scan> decoded = decoded_level(encoded->bytes, -1);
    if (!decoded || !has_area(*decoded)) continue;
    metric::Options sampling;
    sampling.samples = std::min(run.command.samples, kCurveSamples);
    const Result<metric::Comparison> distance =
        metric::compare(scan, *surface, *decoded, sampling, console.context());
    if (!distance) return distance.error();
    curve.push_back({encoded->bytes.size(), distance->psnr_db});
  }
  return curve;
}

}  // namespace

Result<HtmlExtras> html_extras(const EncodeRun& run, const Scan& scan, const SemiRegularMesh& mesh,
                               std::span<const std::uint8_t> stream, Console& console) {
  HtmlExtras extras;
  Result<std::vector<HtmlExtras::Picture>> drawn = pictures(scan, stream);
  if (!drawn) return in_file(drawn.error(), run.command.report);
  extras.pictures = std::move(*drawn);
  Result<std::vector<HtmlExtras::RdPoint>> curve = rd_curve(run, scan, mesh, console);
  if (!curve) return in_file(curve.error(), run.command.report);
  extras.rd_curve = std::move(*curve);
  return extras;
}

}  // namespace nacre::app
