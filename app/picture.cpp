// SPDX-License-Identifier: GPL-3.0-or-later
//
// Two passes per panel. The first walks the triangles and keeps, per sample, the nearest one; the
// second shades the kept samples and averages them into pixels. So each sample is shaded once
// however deep the mesh is, and only the second, heavier pass runs in parallel (over rows, disjoint
// outputs).
#include "app/picture.h"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "app/picture_font.h"
#include "base/parallel.h"

namespace nacre::app {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kMargin = 0.06;    // share of the panel left free around the mesh
constexpr double kWireBias = 0.03;  // a chord of the base mesh dips this far below, in diagonals
constexpr double kOwnWireBias = 0.002;     // a mesh's own edges lie on it, but for the rounding
constexpr double kLegendQuantile = 0.995;  // a few outliers must not darken the rest
constexpr double kEdgeSlack = 1e-9;        // no cracks between neighbours from rounding
constexpr std::uint64_t kMaxSamples = std::uint64_t{1} << 28;

using Color = Eigen::Vector3f;  // linear light

float to_linear(double srgb) {
  return static_cast<float>(srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4));
}

Color from_srgb(int r, int g, int b) {
  return {to_linear(r / 255.0), to_linear(g / 255.0), to_linear(b / 255.0)};
}

std::uint8_t to_srgb(float linear) {
  const double v = std::clamp(static_cast<double>(linear), 0.0, 1.0);
  const double s = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(s * 255.0));
}

struct Palette {
  Color background_top = from_srgb(250, 250, 251), background_bottom = from_srgb(214, 219, 226);
  Color clay = from_srgb(232, 218, 200), back = from_srgb(168, 82, 72);
  Color wire = from_srgb(22, 32, 58), no_value = from_srgb(128, 128, 128);
};

struct Camera {
  Vec3 right, up, toward;  // `toward` points from the mesh to the viewer
  Vec3 center = Vec3::Zero();
  double pixels_per_unit = 1;
  double diagonal = 1;  // of the first mesh: what the depth biases are relative to
};

Camera aim(const View& view) {
  const int up_axis = static_cast<int>(view.up);
  Vec3 axis[3];  // local x (right at azimuth 0), y (up), z (toward the viewer at azimuth 0)
  for (int k = 0; k < 3; ++k) axis[k] = Vec3::Unit((up_axis + 2 + k) % 3);
  const double a = view.azimuth_deg * kPi / 180, e = view.elevation_deg * kPi / 180;
  const Vec3 horizon = std::sin(a) * axis[0] + std::cos(a) * axis[2];
  Camera camera;
  camera.toward = std::cos(e) * horizon + std::sin(e) * axis[1];
  camera.right = std::cos(a) * axis[0] - std::sin(a) * axis[2];
  camera.up = cross(camera.toward, camera.right);
  return camera;
}

/// Scales and centres so that the vertices on faces of `mesh` fill the panel.
void fit(Camera& camera, const Scan& mesh, const PictureOptions& options) {
  const double inf = std::numeric_limits<double>::infinity();
  Vec3 low(inf, inf, inf), high(-inf, -inf, -inf);
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t v : t) {
      const Vec3& p = mesh.positions[v];
      const Vec3 seen(dot(p, camera.right), dot(p, camera.up), dot(p, camera.toward));
      low = low.cwiseMin(seen);
      high = high.cwiseMax(seen);
    }
  }
  if (!(low[0] <= high[0])) return;
  const Vec3 middle = (low + high) / 2, size = high - low;
  camera.center =
      mesh.origin + middle[0] * camera.right + middle[1] * camera.up + middle[2] * camera.toward;
  camera.diagonal = std::max(norm(size), std::numeric_limits<double>::min());
  const double tiny = 1e-9 * camera.diagonal;
  camera.pixels_per_unit =
      (1 - 2 * kMargin) * std::min(options.panel_width / std::max(size[0], tiny),
                                   options.panel_height / std::max(size[1], tiny));
}

/// One panel's samples: the nearest triangle of each, and whether an edge is drawn there.
struct Samples {
  int width = 0, height = 0;
  std::vector<std::uint32_t> triangle;
  std::vector<float> nearness;  // in diagonals, along `toward`
  std::vector<std::uint8_t> wire;

  Samples(int w, int h)
      : width(w),
        height(h),
        triangle(static_cast<std::size_t>(w) * h, kNone),
        nearness(triangle.size(), -std::numeric_limits<float>::infinity()) {}
  [[nodiscard]] std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * width + x;
  }
};

/// A mesh as the camera sees it: x, y in samples from the top left corner, z nearness in diagonals.
std::vector<Vec3> project(const Scan& mesh, const Camera& camera, const PictureOptions& options) {
  std::vector<Vec3> seen(mesh.positions.size());
  const double scale = camera.pixels_per_unit * options.supersampling;
  const double cx = 0.5 * options.panel_width * options.supersampling;
  const double cy = 0.5 * options.panel_height * options.supersampling;
  const Vec3 offset = mesh.origin - camera.center;
  parallel_for_each_index(seen.size(), [&](std::size_t v) {
    const Vec3 p = mesh.positions[v] + offset;
    seen[v] = Vec3(cx + scale * dot(p, camera.right), cy - scale * dot(p, camera.up),
                   dot(p, camera.toward) / camera.diagonal);
  });
  return seen;
}

/// Twice the signed area of (a, b, p) on the screen; y points down, so it is negative for a
/// triangle that is counter-clockwise for the viewer.
double side(const Vec3& a, const Vec3& b, double x, double y) {
  return (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
}

int clamp_to(double value, int limit) {
  return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(limit)));
}

void draw_triangle(Samples& samples, std::uint32_t id, const Vec3& a, const Vec3& b,
                   const Vec3& c) {
  const double area = side(a, b, c[0], c[1]);
  if (!(std::abs(area) > 0) || !std::isfinite(area)) return;  // edge-on: no sample inside
  const auto [x_low, x_high] = std::minmax({a[0], b[0], c[0]});
  const auto [y_low, y_high] = std::minmax({a[1], b[1], c[1]});
  const int x0 = clamp_to(std::ceil(x_low - 0.5), samples.width);
  const int x1 = clamp_to(std::floor(x_high - 0.5) + 1, samples.width);
  const int y0 = clamp_to(std::ceil(y_low - 0.5), samples.height);
  const int y1 = clamp_to(std::floor(y_high - 0.5) + 1, samples.height);
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      const double u = side(b, c, x + 0.5, y + 0.5) / area;
      const double v = side(c, a, x + 0.5, y + 0.5) / area;
      const double w = 1 - u - v;
      if (std::min({u, v, w}) < -kEdgeSlack) continue;
      const float z = static_cast<float>(u * a[2] + v * b[2] + w * c[2]);
      const std::size_t s = samples.at(x, y);
      if (z <= samples.nearness[s]) continue;
      samples.nearness[s] = z;
      samples.triangle[s] = id;
    }
  }
}

/// Marks the samples of segment ab, `thick` samples wide, that lie at most `bias` behind the
/// surface.
void draw_edge(Samples& samples, const Vec3& a, const Vec3& b, int thick, float bias) {
  const double length = std::max(std::abs(b[0] - a[0]), std::abs(b[1] - a[1]));
  const double reach = samples.width + samples.height;
  const bool outside = std::max(a[0], b[0]) < -thick || std::min(a[0], b[0]) > reach ||
                       std::max(a[1], b[1]) < -thick || std::min(a[1], b[1]) > reach;
  if (!(length < 64 * reach) || outside) return;  // also drops what is not finite
  const int steps = static_cast<int>(std::ceil(length)) + 1;
  for (int i = 0; i <= steps; ++i) {
    const Vec3 p = a + (b - a) * (static_cast<double>(i) / steps);
    const int x0 = static_cast<int>(std::floor(p[0])) - thick / 2;
    const int y0 = static_cast<int>(std::floor(p[1])) - thick / 2;
    for (int y = std::max(y0, 0); y < std::min(y0 + thick, samples.height); ++y) {
      for (int x = std::max(x0, 0); x < std::min(x0 + thick, samples.width); ++x) {
        const std::size_t s = samples.at(x, y);
        if (static_cast<float>(p[2]) >= samples.nearness[s] - bias) samples.wire[s] = 1;
      }
    }
  }
}

void draw_wire(Samples& samples, const Panel& panel, const Camera& camera,
               const PictureOptions& options) {
  samples.wire.assign(samples.triangle.size(), 0);
  const std::vector<Vec3> seen = project(*panel.wire, camera, options);
  const float bias = static_cast<float>(panel.wire == panel.mesh ? kOwnWireBias : kWireBias);
  const int thick =
      panel.wire == panel.mesh ? std::max(1, options.supersampling / 2) : options.supersampling;
  for (const Triangle& t : panel.wire->triangles)
    for (int k = 0; k < 3; ++k) draw_edge(samples, seen[t[k]], seen[t[(k + 1) % 3]], thick, bias);
}

std::vector<Vec3> vertex_normals(const Scan& mesh) {
  std::vector<Vec3> normals(mesh.positions.size(), Vec3::Zero());
  for (const Triangle& t : mesh.triangles) {
    const Vec3& a = mesh.positions[t[0]];
    const Vec3 n = cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a);  // weighted by area
    for (const std::uint32_t v : t) normals[v] += n;
  }
  return normals;
}

/// Everything that the colour of a sample depends on.
class Shader {
 public:
  Shader(const Panel& panel, const Camera& camera, const PictureOptions& options,
         double quality_max)
      : panel_(panel),
        camera_(camera),
        flat_(options.flat),
        quality_max_(quality_max),
        seen_(project(*panel.mesh, camera, options)),
        normals_(flat_ ? std::vector<Vec3>() : vertex_normals(*panel.mesh)) {
    key_ = (-0.45 * camera.right + 0.65 * camera.up + 0.75 * camera.toward).normalized();
    fill_ = (0.8 * camera.right - 0.15 * camera.up + 0.5 * camera.toward).normalized();
    half_ = (key_ + camera.toward).normalized();
    for (std::size_t i = 0; i < ramp_.size(); ++i) {
      const auto c = viridis(static_cast<double>(i) / kRampEnd);
      ramp_[i] = from_srgb(c[0], c[1], c[2]);
    }
  }

  [[nodiscard]] const std::vector<Vec3>& seen() const { return seen_; }

  [[nodiscard]] Color color(std::uint32_t triangle, double x, double y) const {
    const Triangle& t = panel_.mesh->triangles[triangle];
    const Vec3 &a = seen_[t[0]], &b = seen_[t[1]], &c = seen_[t[2]];
    const double area = side(a, b, c[0], c[1]);
    const double u = side(b, c, x, y) / area, v = side(c, a, x, y) / area, w = 1 - u - v;
    const bool front = area < 0;
    Color base = front ? palette_.clay : palette_.back;
    if (front && !panel_.quality.empty()) {
      base = quality_color(u * panel_.quality[t[0]] + v * panel_.quality[t[1]] +
                           w * panel_.quality[t[2]]);
    } else if (front && !panel_.face_color.empty()) {
      base = given(panel_.face_color[triangle]);
    } else if (front && !panel_.vertex_color.empty()) {
      base = static_cast<float>(u) * given(panel_.vertex_color[t[0]]) +
             static_cast<float>(v) * given(panel_.vertex_color[t[1]]) +
             static_cast<float>(w) * given(panel_.vertex_color[t[2]]);
    }
    return lit(base, normal(t, u, v, w, front), front);
  }

  [[nodiscard]] const Palette& palette() const { return palette_; }

 private:
  [[nodiscard]] Color quality_color(double q) const {
    const double t = quality_max_ > 0 ? q / quality_max_ : 0;
    if (!std::isfinite(t)) return palette_.no_value;
    return ramp_[static_cast<std::size_t>(std::lround(std::clamp(t, 0.0, 1.0) * kRampEnd))];
  }

  static Color given(const std::array<std::uint8_t, 3>& rgb) {
    return from_srgb(rgb[0], rgb[1], rgb[2]);
  }

  /// Toward the viewer's side of the triangle, unit length.
  [[nodiscard]] Vec3 normal(const Triangle& t, double u, double v, double w, bool front) const {
    const auto& p = panel_.mesh->positions;
    const Vec3 face = cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
    Vec3 n = flat_ ? face
                   : Vec3(u * normals_[t[0]].normalized() + v * normals_[t[1]].normalized() +
                          w * normals_[t[2]].normalized());
    if (!(norm(n) > 0)) n = face;
    const double length = norm(n);
    if (!(length > 0)) return camera_.toward;
    return front ? Vec3(n / length) : Vec3(-n / length);
  }

  [[nodiscard]] Color lit(const Color& base, const Vec3& n, bool front) const {
    const double key = std::max(0.0, dot(n, key_)), fill = std::max(0.0, dot(n, fill_));
    const double sky = 0.5 + 0.5 * dot(n, camera_.up);
    const double rim = 1 - std::clamp(dot(n, camera_.toward), 0.0, 1.0);
    const double gloss = front ? 0.10 * std::pow(std::max(0.0, dot(n, half_)), 40.0) : 0.0;
    const double light = (0.78 * key + 0.14 * fill + 0.10 + 0.14 * sky) * (1 - 0.35 * rim * rim);
    return base * static_cast<float>(light) + Color::Constant(static_cast<float>(gloss));
  }

  Panel panel_;
  Camera camera_;
  Palette palette_;
  bool flat_;
  double quality_max_;
  std::vector<Vec3> seen_, normals_;
  Vec3 key_, fill_, half_;
  static constexpr double kRampEnd = 255;
  std::array<Color, 256> ramp_;
};

Color background(const Palette& palette, int y, int height) {
  const float t = static_cast<float>(y) / static_cast<float>(std::max(1, height - 1));
  return palette.background_top * (1 - t) + palette.background_bottom * t;
}

void put(Image& image, int x, int y, const Color& c) {
  if (x < 0 || y < 0 || x >= image.width || y >= image.height) return;
  std::uint8_t* p = &image.rgb[(static_cast<std::size_t>(y) * image.width + x) * 3];
  for (int k = 0; k < 3; ++k) p[k] = to_srgb(c[k]);
}

void fill_background(Image& image, int left, const PictureOptions& options) {
  const Palette palette;
  for (int y = 0; y < options.panel_height; ++y)
    for (int x = 0; x < options.panel_width; ++x)
      put(image, left + x, y, background(palette, y, options.panel_height));
}

void draw_panel(Image& image, int left, const Panel& panel, const Camera& camera,
                const PictureOptions& options, double quality_max) {
  const int ss = options.supersampling;
  Samples samples(options.panel_width * ss, options.panel_height * ss);
  const Shader shader(panel, camera, options, quality_max);
  const auto& triangles = panel.mesh->triangles;
  for (std::uint32_t f = 0; f < triangles.size(); ++f) {
    const Triangle& t = triangles[f];
    draw_triangle(samples, f, shader.seen()[t[0]], shader.seen()[t[1]], shader.seen()[t[2]]);
  }
  if (panel.wire != nullptr) draw_wire(samples, panel, camera, options);
  const auto row = [&](std::size_t y_index) {
    const int y = static_cast<int>(y_index);
    const Color behind = background(shader.palette(), y, options.panel_height);
    for (int x = 0; x < options.panel_width; ++x) {
      Color sum = Color::Zero();
      for (int j = y * ss; j < (y + 1) * ss; ++j) {
        for (int i = x * ss; i < (x + 1) * ss; ++i) {
          const std::size_t s = samples.at(i, j);
          Color c = samples.triangle[s] == kNone
                        ? behind
                        : shader.color(samples.triangle[s], i + 0.5, j + 0.5);
          if (!samples.wire.empty() && samples.wire[s] != 0)
            c = 0.2F * c + 0.8F * shader.palette().wire;
          sum += c;
        }
      }
      put(image, left + x, y, sum / static_cast<float>(ss * ss));
    }
  };
  parallel_for_each_index(static_cast<std::size_t>(options.panel_height), row, 8);
}

struct Pen {
  int scale = 1;
  Color color = Palette().wire;

  [[nodiscard]] int advance() const { return (kGlyphWidth + 1) * scale; }
  [[nodiscard]] int line_height() const { return (kGlyphHeight + 3) * scale; }

  void write(Image& image, int x, int y, const std::string& text) const {
    for (const char character : text) {
      const int code = static_cast<unsigned char>(character);
      const auto& glyph =
          kGlyphs[static_cast<std::size_t>(code < 32 || code > 126 ? '?' - 32 : code - 32)];
      for (int column = 0; column < kGlyphWidth * scale; ++column)
        for (int line = 0; line < kGlyphHeight * scale; ++line)
          if ((glyph[static_cast<std::size_t>(column / scale)] >> (line / scale)) & 1)
            put(image, x + column, y + line, color);
      x += advance();
    }
  }
};

std::vector<std::string> lines_of(const std::string& caption) {
  std::vector<std::string> lines(1);
  for (const char c : caption) {
    if (c == '\n')
      lines.emplace_back();
    else
      lines.back() += c;
  }
  return lines;
}

Pen pen_for(const PictureOptions& options) {
  return {.scale = std::max(1, options.panel_width / 320)};
}

int caption_height(std::span<const Panel> panels, const PictureOptions& options) {
  std::size_t lines = 0;
  for (const Panel& panel : panels)
    if (!panel.caption.empty()) lines = std::max(lines, lines_of(panel.caption).size());
  const Pen pen = pen_for(options);
  return lines == 0 ? 0
                    : static_cast<int>(std::min<std::size_t>(lines, 8)) * pen.line_height() +
                          6 * pen.scale;
}

void draw_caption(Image& image, int left, const Panel& panel, const PictureOptions& options) {
  const Pen pen = pen_for(options);
  int y = options.panel_height + 5 * pen.scale;
  for (std::string line : lines_of(panel.caption)) {
    line = line.substr(0, static_cast<std::size_t>(options.panel_width / pen.advance()));
    const int width = static_cast<int>(line.size()) * pen.advance() - pen.scale;
    pen.write(image, left + (options.panel_width - width) / 2, y, line);
    y += pen.line_height();
  }
}

/// A bar of the colours at the panel's lower edge, with the values of its ends and middle.
void draw_legend(Image& image, int left, const PictureOptions& options, double quality_max) {
  const Pen pen = pen_for(options);
  const int width = options.panel_width / 2, height = 6 * pen.scale;
  const int x0 = left + (options.panel_width - width) / 2;
  const int y0 = options.panel_height - pen.line_height() - height - 5 * pen.scale;
  for (int x = 0; x < width; ++x) {
    const auto c = viridis(static_cast<double>(x) / (width - 1));
    for (int y = 0; y < height; ++y) put(image, x0 + x, y0 + y, from_srgb(c[0], c[1], c[2]));
  }
  for (int tick = 0; tick <= 2; ++tick) {
    char number[32];
    std::snprintf(number, sizeof number, "%.3g", quality_max * tick / 2);
    std::string text = number;
    if (tick == 2 && !options.quality_unit.empty()) text += " " + options.quality_unit;
    const int x = x0 + (width - 1) * tick / 2;
    for (int y = 0; y < 2 * pen.scale; ++y) put(image, x, y0 + height + y, pen.color);
    pen.write(image, x - static_cast<int>(text.size()) * pen.advance() / 2,
              y0 + height + 3 * pen.scale, text);
  }
}

double legend_end(std::span<const Panel> panels, const PictureOptions& options) {
  if (options.quality_max > 0) return options.quality_max;
  std::vector<float> values;
  for (const Panel& panel : panels)
    for (const float q : panel.quality)
      if (std::isfinite(q)) values.push_back(q);
  if (values.empty()) return 0;
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(
                                        kLegendQuantile * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), nth, values.end());
  return std::max(0.0, static_cast<double>(*nth));
}

Result<void> check_mesh(const Scan* mesh, std::size_t panel) {
  if (mesh == nullptr) return {};
  for (const Triangle& t : mesh->triangles)
    for (const std::uint32_t v : t)
      if (v >= mesh->positions.size())
        return Error{ErrorCode::kBadInput, "picture: a triangle names a vertex that is not there",
                     panel};
  return {};
}

Result<void> check(std::span<const Panel> panels, const PictureOptions& options) {
  const auto bad = [](std::string message, std::size_t where = 0) {
    return Error{ErrorCode::kBadInput, "picture: " + std::move(message), where};
  };
  if (panels.empty()) return bad("there is no panel to draw");
  const auto size_ok = [](int size) { return size >= 64 && size <= 8192; };
  if (!size_ok(options.panel_width) || !size_ok(options.panel_height))
    return bad("a panel is 64 to 8192 pixels wide and high");
  if (options.supersampling < 1 || options.supersampling > 4) return bad("supersampling is 1 to 4");
  if (!std::isfinite(options.view.azimuth_deg) || !(std::abs(options.view.elevation_deg) <= 90) ||
      static_cast<int>(options.view.up) > 2)
    return bad("the view's elevation is -90 to 90 degrees, its azimuth any finite number");
  if (!(options.quality_max >= 0) || std::isinf(options.quality_max))
    return bad("the upper end of the colours is zero or more");
  for (std::size_t i = 0; i < panels.size(); ++i) {
    if (!panels[i].quality.empty() &&
        (panels[i].mesh == nullptr || panels[i].quality.size() != panels[i].mesh->positions.size()))
      return bad("there must be one quality value per vertex", i);
    const auto fits = [](std::size_t colors, std::size_t count) {
      return colors == 0 || colors == count;
    };
    const Scan* drawn = panels[i].mesh;
    if (!fits(panels[i].vertex_color.size(), drawn == nullptr ? 0 : drawn->positions.size()) ||
        !fits(panels[i].face_color.size(), drawn == nullptr ? 0 : drawn->triangles.size()))
      return bad("there must be one colour per vertex or per face", i);
    for (const Scan* mesh : {panels[i].mesh, panels[i].wire})
      if (Result<void> ok = check_mesh(mesh, i); !ok) return ok;
  }
  const auto pixels = static_cast<std::uint64_t>(options.panel_width) * options.panel_height;
  const auto ss = static_cast<std::uint64_t>(options.supersampling);
  if (pixels * ss * ss > kMaxSamples || panels.size() > 1024 ||
      pixels * panels.size() > kMaxSamples)
    return Error{ErrorCode::kLimitExceeded, "picture: too many pixels; make the panels smaller"};
  return {};
}

}  // namespace

std::array<std::uint8_t, 3> viridis(double t) {
  // Samples of matplotlib's viridis (CC0) at multiples of 1/8, joined by straight lines.
  static constexpr std::array<std::array<int, 3>, 9> kStops = {{{68, 1, 84},
                                                                {71, 44, 122},
                                                                {59, 81, 139},
                                                                {44, 113, 142},
                                                                {33, 144, 141},
                                                                {39, 173, 129},
                                                                {92, 200, 99},
                                                                {170, 220, 50},
                                                                {253, 231, 37}}};
  if (std::isnan(t)) return {128, 128, 128};
  const double s = std::clamp(t, 0.0, 1.0) * (kStops.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(s), kStops.size() - 2);
  std::array<std::uint8_t, 3> color{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double value =
        kStops[i][k] + (s - static_cast<double>(i)) * (kStops[i + 1][k] - kStops[i][k]);
    color[k] = static_cast<std::uint8_t>(std::lround(value));
  }
  return color;
}

Result<Image> render(std::span<const Panel> panels, const PictureOptions& options) {
  if (Result<void> ok = check(panels, options); !ok) return ok.error();
  Image image;
  image.width = options.panel_width * static_cast<int>(panels.size());
  image.height = options.panel_height + caption_height(panels, options);
  image.rgb.assign(static_cast<std::size_t>(image.width) * image.height * 3, 255);

  Camera camera = aim(options.view);
  for (const Panel& panel : panels) {
    if (panel.mesh == nullptr || panel.mesh->triangles.empty()) continue;
    fit(camera, *panel.mesh, options);
    break;
  }
  const double quality_max = legend_end(panels, options);
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const int left = static_cast<int>(i) * options.panel_width;
    const bool drawable = panels[i].mesh != nullptr && !panels[i].mesh->triangles.empty();
    if (drawable)
      draw_panel(image, left, panels[i], camera, options, quality_max);
    else
      fill_background(image, left, options);
    if (drawable && !panels[i].quality.empty()) draw_legend(image, left, options, quality_max);
    draw_caption(image, left, panels[i], options);
  }
  return image;
}

Result<std::vector<std::uint8_t>> encode_png(const Image& image) {
  if (image.width < 1 || image.height < 1 ||
      image.rgb.size() != static_cast<std::size_t>(image.width) * image.height * 3)
    return Error{ErrorCode::kBadInput, "picture: the image's size does not fit its pixels"};
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::vector<std::uint8_t> bytes(size);
  if (png_image_write_to_memory(&header, bytes.data(), &size, 0, image.rgb.data(), 0, nullptr) == 0)
    return Error{ErrorCode::kLimitExceeded, std::string("picture: libpng: ") + header.message};
  bytes.resize(size);
  return bytes;
}

Result<std::vector<std::uint8_t>> render_png(std::span<const Panel> panels,
                                             const PictureOptions& options) {
  Result<Image> image = render(panels, options);
  if (!image) return image.error();
  return encode_png(*image);
}

}  // namespace nacre::app
