// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <utility>
#include <vector>

#include "app/files.h"
#include "app/picture.h"
#include "app/remesh_stage.h"
#include "app/report.h"
#include "app/verbs.h"
#include "io/write.h"

namespace nacre::app {
namespace {

Result<void> check_outputs(const CompareCommand& command) {
  const bool overwrite = command.common.overwrite;
  for (const std::filesystem::path& input : {command.a, command.b}) {
    if (!command.map.empty()) {
      Result<void> ok = check_output_named(command.map, ".ply", overwrite, input);
      if (!ok) return ok;
    }
    if (!command.picture.empty()) {
      Result<void> ok = check_output_named(command.picture, ".png", overwrite, input);
      if (!ok) return ok;
    }
  }
  return {};
}

/// The same surface relative to another origin, so that both can be drawn and queried together.
void rebase(Scan& scan, const Vec3& origin) {
  const Vec3 shift = scan.origin - origin;
  if (shift.isZero(0)) return;
  for (Vec3& p : scan.positions) p += shift;
  scan.origin = origin;
}

/// Distance of every vertex of A to the surface of B; both have the same origin.
Result<std::vector<float>> distances_on(const Scan& a, const Scan& b,
                                        const std::filesystem::path& b_file) {
  Result<metric::Surface> surface = metric::Surface::build(b);
  if (!surface) return surface_error(surface.error(), b_file);
  const std::vector<double> distances = surface->distances(a.positions);
  std::vector<float> quality(distances.size());
  std::ranges::transform(distances, quality.begin(),
                         [](double d) { return static_cast<float>(d); });
  return quality;
}

Result<std::vector<std::uint8_t>> map_bytes(const CompareCommand& command, const Scan& a,
                                            const Scan& b) {
  Result<std::vector<float>> quality = distances_on(a, b, command.b);
  if (!quality) return quality.error();
  const auto largest = std::ranges::max_element(*quality);
  const double top =
      command.map_max.value_or(largest == (*quality).end() ? 0.0 : static_cast<double>(*largest));
  io::VertexChannels channels;
  channels.color.reserve((*quality).size());
  for (const float q : *quality) {
    channels.color.push_back(viridis(top > 0 ? static_cast<double>(q) / top : 0));
  }
  channels.quality = std::move(*quality);
  Result<std::vector<std::uint8_t>> bytes = io::serialize_mesh(a, io::MeshFormat::kPly, channels);
  if (!bytes) return in_file(bytes.error(), command.map);
  return bytes;
}

/// Captions are printable ASCII; file names need not be.
std::string caption(const std::filesystem::path& file, const std::string& second_line) {
  std::string text = file.filename().string();
  for (char& c : text) {
    if (c < ' ' || c > '~') c = '?';
  }
  return text + "\n" + second_line;
}

Result<std::vector<std::uint8_t>> picture_bytes(const CompareCommand& command, const Scan& raw_a,
                                                const Scan& raw_b,
                                                const metric::Comparison& comparison) {
  const Scan a = drawable(raw_a), b = drawable(raw_b);
  Result<std::vector<float>> quality = distances_on(a, raw_b, command.b);
  if (!quality) return quality.error();
  std::array<Panel, 3> panels;
  panels[0].mesh = &a;
  panels[0].caption = caption(command.a, fmt::format("{} faces", raw_a.triangles.size()));
  panels[1].mesh = &b;
  panels[1].caption = caption(command.b, fmt::format("{} faces", raw_b.triangles.size()));
  panels[2].mesh = &a;
  panels[2].quality = *quality;
  panels[2].caption = fmt::format("distance to the second surface\nPSNR {:.2f} dB, max {:.3g}",
                                  comparison.psnr_db, max_error(comparison));
  PictureOptions options;
  options.view = command.view;
  options.quality_max = command.map_max.value_or(0);
  Result<std::vector<std::uint8_t>> bytes = render_png(panels, options);
  if (!bytes) return in_file(bytes.error(), command.picture);
  return bytes;
}

/// Makes both files before it writes the first.
Result<void> write_outputs(const CompareCommand& command, const Scan& a, const Scan& b,
                           const metric::Comparison& comparison) {
  std::vector<std::uint8_t> map, picture;
  if (!command.map.empty()) {
    Result<std::vector<std::uint8_t>> bytes = map_bytes(command, a, b);
    if (!bytes) return bytes.error();
    map = std::move(*bytes);
  }
  if (!command.picture.empty()) {
    Result<std::vector<std::uint8_t>> bytes = picture_bytes(command, a, b, comparison);
    if (!bytes) return bytes.error();
    picture = std::move(*bytes);
  }
  if (!command.map.empty()) {
    Result<void> written = write_output(command.map, map, command.common.overwrite);
    if (!written) return written;
  }
  if (command.picture.empty()) return {};
  return write_output(command.picture, picture, command.common.overwrite);
}

Result<std::optional<metric::Certified>> certify(const CompareCommand& command, const Scan& a,
                                                 const Scan& b, Console& console) {
  if (!command.certify) return std::optional<metric::Certified>();
  metric::CertifyOptions options;
  options.relative_tolerance = command.certify_percent / 100;
  Result<metric::Certified> certified =
      metric::certified_distance(a, b, options, console.context());
  if (!certified) return surface_error(certified.error(), command.a);
  if (!certified->within_tolerance())
    console.warning("the certified bounds hold, but are farther apart than was asked for");
  return std::optional(*certified);
}

std::string result_text(const CompareCommand& command, const metric::Comparison& comparison,
                        const std::optional<metric::Certified>& certified) {
  if (command.json) return to_json(comparison, certified);
  std::string text = describe(comparison) + "\n";
  if (certified) text += describe(*certified) + "\n";
  return text + describe_histogram(comparison) + "\n";
}

}  // namespace

Result<void> run_compare(const CompareCommand& command, Console& console) {
  if (Result<void> ok = check_outputs(command); !ok) return ok;
  Result<Scan> a = load_surface(command.a);
  if (!a) return a.error();
  Result<Scan> b = load_surface(command.b);
  if (!b) return b.error();
  rebase(*b, a->origin);
  for (const auto& [scan, file] : {std::pair(&*a, &command.a), std::pair(&*b, &command.b)}) {
    if (!has_area(*scan)) {
      return Error{ErrorCode::kGeometryRefused,
                   fmt::format("{}: no face has an area, so there is no surface to measure",
                               file->string())};
    }
  }
  Result<metric::Comparison> comparison = measure(*a, *b, command.samples, command.a, console);
  if (!comparison) return comparison.error();
  const Result<std::optional<metric::Certified>> certified = certify(command, *a, *b, console);
  if (!certified) return certified.error();
  if (Result<void> go_on = check_cancelled(console); !go_on) return go_on;
  if (Result<void> written = write_outputs(command, *a, *b, *comparison); !written) return written;
  const std::string text = result_text(command, *comparison, *certified);
  std::fwrite(text.data(), 1, text.size(), stdout);
  return {};
}

}  // namespace nacre::app
