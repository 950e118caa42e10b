// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/report_svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace nacre::app {
namespace {

constexpr int kLeft = 64, kRight = 16, kTop = 14, kBottom = 44;  // of the plotting area, pixels
constexpr int kTicksX = 6, kTicksY = 5;

/// One axis: values to pixels.
struct Scale {
  double low = 0, high = 1, first = 0, last = 1;  // [low, high] goes to [first, last]
  bool logarithmic = false;

  [[nodiscard]] double position(double value) const {
    const auto f = [&](double x) { return logarithmic ? std::log10(x) : x; };
    return first + (f(value) - f(low)) / (f(high) - f(low)) * (last - first);
  }
};

bool is_shown(const std::array<double, 2>& p, const Plot& plot) {
  return std::isfinite(p[0]) && std::isfinite(p[1]) && (!plot.x.logarithmic || p[0] > 0) &&
         (!plot.y.logarithmic || p[1] > 0);
}

/// Of all points, a little wider, and never empty.
Scale scale_of(const Plot& plot, std::size_t k) {
  Scale scale;
  scale.logarithmic = k == 0 ? plot.x.logarithmic : plot.y.logarithmic;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Series& series : plot.series) {
    for (const auto& p : series.points) {
      if (!is_shown(p, plot)) continue;
      low = std::min(low, p[k]);
      high = std::max(high, p[k]);
    }
  }
  if (scale.logarithmic) {
    const double wider = low < high ? std::pow(high / low, 0.06) : 2;
    scale.low = low / wider;
    scale.high = high * wider;
  } else {
    const double wider = low < high ? 0.06 * (high - low) : std::max(1.0, std::abs(low));
    scale.low = low >= 0 && low < 6 * wider ? 0 : low - wider;
    scale.high = high + wider;
  }
  scale.first = k == 0 ? kLeft : plot.height - kBottom;
  scale.last = k == 0 ? plot.width - kRight : kTop;
  return scale;
}

std::string number(double x) {
  if (x != 0 && (std::abs(x) >= 1e6 || std::abs(x) < 1e-3)) return fmt::format("{:.2g}", x);
  return fmt::format("{:.6g}", x);
}

std::string axes(const Plot& plot, const Scale& x, const Scale& y) {
  std::string out;
  const int bottom = plot.height - kBottom, right = plot.width - kRight;
  for (const double t : ticks(x.low, x.high, kTicksX, x.logarithmic)) {
    const double at = x.position(t);
    out += fmt::format(
        "<line class=\"grid\" x1=\"{0:.1f}\" y1=\"{1}\" x2=\"{0:.1f}\" y2=\"{2}\"/>"
        "<text x=\"{0:.1f}\" y=\"{3}\" text-anchor=\"middle\">{4}</text>",
        at, kTop, bottom, bottom + 16, number(t));
  }
  for (const double t : ticks(y.low, y.high, kTicksY, y.logarithmic)) {
    const double at = y.position(t);
    out += fmt::format(
        "<line class=\"grid\" x1=\"{1}\" y1=\"{0:.1f}\" x2=\"{2}\" y2=\"{0:.1f}\"/>"
        "<text x=\"{3}\" y=\"{4:.1f}\" text-anchor=\"end\">{5}</text>",
        at, kLeft, right, kLeft - 6, at + 4, number(t));
  }
  out += fmt::format("<path class=\"axis\" d=\"M{} {}V{}H{}\"/>", kLeft, kTop, bottom, right);
  out += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                     (kLeft + right) / 2, plot.height - 8, escaped(plot.x.label));
  out += fmt::format(
      "<text transform=\"translate(14 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
      (kTop + bottom) / 2, escaped(plot.y.label));
  return out;
}

std::string curve(const Series& series, const Plot& plot, const Scale& x, const Scale& y) {
  std::string path, dots;
  for (const auto& p : series.points) {
    if (!is_shown(p, plot)) continue;
    const double px = x.position(p[0]), py = y.position(p[1]);
    path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", px, py);
    if (series.dots) {
      dots += fmt::format(
          "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\"><title>{}, {}</title>"
          "</circle>",
          px, py, number(p[0]), number(p[1]));
    }
  }
  std::string out = fmt::format("<g class=\"{}\">", series.css_class);
  if (series.line && !path.empty()) out += fmt::format("<path class=\"curve\" d=\"{}\"/>", path);
  return out + dots + "</g>";
}

std::string legend(const Plot& plot) {
  std::string out;
  int y = plot.height - kBottom - 12;
  for (auto series = plot.series.rbegin(); series != plot.series.rend(); ++series) {
    if (series->name.empty()) continue;
    out += fmt::format(
        "<g class=\"{}\"><circle cx=\"{}\" cy=\"{}\" r=\"3.5\"/></g>"
        "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>",
        series->css_class, plot.width - kRight - 10, y - 4, plot.width - kRight - 20, y,
        escaped(series->name));
    y -= 16;
  }
  return out;
}

}  // namespace

std::vector<double> ticks(double low, double high, int count, bool logarithmic) {
  std::vector<double> found;
  if (!(low < high) || !std::isfinite(low) || !std::isfinite(high) || (logarithmic && low <= 0))
    return found;
  if (logarithmic && high / low > 4) {
    const bool decades_only = std::log10(high / low) > count / 2.0;
    for (int e = static_cast<int>(std::floor(std::log10(low))); std::pow(10.0, e) <= high; ++e) {
      for (const double m : {1.0, 2.0, 5.0}) {
        const double t = m * std::pow(10.0, e);
        if (t >= low && t <= high && (m == 1 || !decades_only)) found.push_back(t);
      }
    }
    const auto most = static_cast<std::size_t>(2 * count);
    const std::size_t stride = (found.size() + most - 1) / most;
    std::vector<double> thinned;
    for (std::size_t i = 0; i < found.size(); i += std::max<std::size_t>(stride, 1))
      thinned.push_back(found[i]);
    return thinned;
  }
  const double rough = (high - low) / count, power = std::pow(10.0, std::floor(std::log10(rough)));
  const double step = power * (rough / power < 1.5   ? 1
                               : rough / power < 3.5 ? 2
                               : rough / power < 7.5 ? 5
                                                     : 10);
  for (double i = std::ceil(low / step); i * step <= high; ++i) found.push_back(i * step);
  return found;
}

std::string escaped(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    // Bytes of a longer character, if they make one.
    const std::size_t length = c < 0x80         ? 1
                               : c >> 5 == 0x6  ? 2
                               : c >> 4 == 0xE  ? 3
                               : c >> 3 == 0x1E ? 4
                                                : 0;
    bool whole = length > 0 && i + length <= text.size();
    for (std::size_t k = 1; whole && k < length; ++k)
      whole = (static_cast<unsigned char>(text[i + k]) & 0xC0) == 0x80;
    if (!whole || c < ' ' || c == 0x7F) {
      out += c == '\n' ? " " : "\xEF\xBF\xBD";  // U+FFFD
      continue;
    }
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += text.substr(i, length);
    }
    i += length - 1;
  }
  return out;
}

std::string svg(const Plot& plot) {
  const bool any = std::ranges::any_of(plot.series, [&](const Series& s) {
    return std::ranges::any_of(s.points, [&](const auto& p) { return is_shown(p, plot); });
  });
  if (!any) return fmt::format("<p>{}: nothing to plot</p>", escaped(plot.title));
  const Scale x = scale_of(plot, 0), y = scale_of(plot, 1);
  std::string out = fmt::format("<svg viewBox=\"0 0 {} {}\" role=\"img\"><title>{}</title>",
                                plot.width, plot.height, escaped(plot.title));
  out += axes(plot, x, y);
  for (const Series& series : plot.series) out += curve(series, plot, x, y);
  return out + legend(plot) + "</svg>";
}

}  // namespace nacre::app
