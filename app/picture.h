// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/scan.h"

/// Pictures of meshes without a graphics card: a z-buffered software rasteriser that writes PNG.
namespace nacre::app {

/// One mesh in the picture. What it points to must live until render_png returns.
struct Panel {
  const Scan* mesh = nullptr;  ///< null or empty: only the caption is drawn
  /// One value per vertex of `mesh`, e.g. its distance to another surface; empty: plain clay. Drawn
  /// with the viridis colours from 0 to PictureOptions::quality_max, with a legend bar.
  std::span<const float> quality = {};
  /// sRGB per vertex, blended, or per face of `mesh`, which wins; `quality` wins over both.
  std::span<const std::array<std::uint8_t, 3>> vertex_color = {}, face_color = {};
  std::string caption;  ///< printable ASCII; a newline starts a second line
  /// Edges of this mesh are drawn over the surface, e.g. the base mesh or `mesh` itself.
  const Scan* wire = nullptr;
};

/// Where the camera stands: orthographic, aimed so that the first mesh fills its panel.
struct View {
  enum class Up : std::uint8_t { kX, kY, kZ };
  Up up = Up::kY;
  double azimuth_deg = 25;    ///< about `up`; 0 looks from the axis after `up` (+Z for kY)
  double elevation_deg = 15;  ///< above the horizon, -90 .. 90
};

struct PictureOptions {
  View view;
  int panel_width = 640;   ///< pixels, 64 .. 8192
  int panel_height = 640;  ///< pixels without the caption strip, 64 .. 8192
  int supersampling = 3;   ///< samples per pixel and axis, 1 .. 4; cost grows with its square
  bool flat = false;       ///< one normal per triangle, which shows the triangulation
  /// Upper end of the colours, in the unit of `quality`; 0: the 99.5th percentile over all panels.
  double quality_max = 0;
  std::string quality_unit;  ///< printed after the legend's numbers, e.g. "mm"
};

/// An image, 3 bytes (sRGB) per pixel, rows from the top.
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};

/// Draws the panels from left to right with the same camera and scale.
///
/// Ensures  (1) the same panels and options give the same bytes, at any thread count
///          (2) back faces, which show through holes, have a tint of their own
/// Errors   kBadInput: no panel, an option out of range, `quality` of the wrong length.
///          kLimitExceeded: more than 2^28 samples in a panel, or 2^28 pixels in the picture.
[[nodiscard]] Result<Image> render(std::span<const Panel> panels,
                                   const PictureOptions& options = {});

/// The image as the bytes of a PNG file. Errors   kLimitExceeded when libpng refuses.
[[nodiscard]] Result<std::vector<std::uint8_t>> encode_png(const Image& image);

/// render, then encode_png.
[[nodiscard]] Result<std::vector<std::uint8_t>> render_png(std::span<const Panel> panels,
                                                           const PictureOptions& options = {});

/// Viridis at t in [0, 1] (clamped; not a number gives grey), sRGB.
[[nodiscard]] std::array<std::uint8_t, 3> viridis(double t);

}  // namespace nacre::app
