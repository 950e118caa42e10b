// SPDX-License-Identifier: GPL-3.0-or-later
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/batch/encode_item.h"
#include "app/files.h"
#include "app/picture.h"
#include "codec/comparators.h"
#include "codec/decode.h"
#include "io/write.h"

namespace nacre::app::batch {
namespace {

constexpr int kWidthPixels = 112;
// About one for two pixels: finer levels hardly show, and the picture is most of what a batch adds
// to a scan: 3 ms, and 1.7 ms for each thousand triangles.
constexpr std::uint64_t kMostTriangles = 6'000;

std::string base64(std::span<const std::uint8_t> bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = bytes.size() - i;
    const std::uint32_t group = std::uint32_t{bytes[i]} << 16 |
                                (left > 1 ? std::uint32_t{bytes[i + 1]} << 8 : 0) |
                                (left > 2 ? std::uint32_t{bytes[i + 2]} : 0);
    text += kDigits[group >> 18];
    text += kDigits[group >> 12 & 63];
    text += left > 1 ? kDigits[group >> 6 & 63] : '=';
    text += left > 2 ? kDigits[group & 63] : '=';
  }
  return text;
}

}  // namespace

std::string thumbnail_of(const std::filesystem::path& stream) {
  const auto bytes = io::read_file(stream);
  if (!bytes) return {};
  codec::DecodeOptions options;
  options.comparators = codec::decode_comparator_bands;
  const auto info = codec::inspect(*bytes, options);
  if (!info) return {};
  options.max_level = 0;
  for (std::size_t j = 0; j < info->levels.size(); ++j) {
    if (info->levels[j].triangles <= kMostTriangles) options.max_level = static_cast<int>(j);
  }
  const auto decoded = codec::decode(*bytes, options);
  const auto mesh = decoded ? to_triangles(*decoded) : decoded.error();
  if (!mesh) return {};
  PictureOptions look;
  look.panel_width = look.panel_height = kWidthPixels;
  look.supersampling = 2;
  Panel panel;
  panel.mesh = &*mesh;
  const auto picture = render_png(std::span(&panel, 1), look);
  return picture ? base64(*picture) : std::string();
}

}  // namespace nacre::app::batch
