// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace nacre::bench {
namespace {

constexpr double kWidth = 720, kHeight = 480;
constexpr double kLeft = 70, kRight = 20, kTop = 40, kBottom = 55;
/// Told apart without red against green [Okabe and Ito].
constexpr std::array<const char*, 7> kColours = {"#000000", "#e69f00", "#56b4e9", "#009e73",
                                                 "#d55e00", "#0072b2", "#cc79a7"};

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else
      out += c;
  }
  return out;
}

/// One direction: values to pixels, and where to put ticks.
class Axis {
 public:
  Axis(bool is_log, double low, double high, double pixel_low, double pixel_high)
      : is_log_(is_log), pixel_low_(pixel_low), pixel_high_(pixel_high) {
    if (!(high > low)) high = low + (low == 0 ? 1 : std::abs(low));
    low_ = scaled(low);
    high_ = scaled(high);
    const double margin = 0.03 * (high_ - low_);
    low_ -= margin;
    high_ += margin;
  }

  [[nodiscard]] double at(double value) const {
    return pixel_low_ + (scaled(value) - low_) / (high_ - low_) * (pixel_high_ - pixel_low_);
  }

  [[nodiscard]] std::vector<double> ticks() const {
    std::vector<double> out;
    if (is_log_) {
      // Wide ranges by powers of ten, narrow ones by 1, 2, 5.
      const bool is_wide = high_ - low_ > 4;
      for (double power = std::floor(low_); power <= high_; power += 1)
        for (const double step : {1.0, 2.0, 5.0}) {
          const double value = step * std::pow(10.0, power);
          const double x = std::log10(value);
          if (x >= low_ && x <= high_ && (step == 1.0 || !is_wide)) out.push_back(value);
        }
      return out;
    }
    const double rough = (high_ - low_) / 8, power = std::pow(10.0, std::floor(std::log10(rough)));
    double step = 10 * power;
    for (const double factor : {5.0, 2.0, 1.0})
      if (factor * power >= rough) step = factor * power;
    // + 0 makes no tick of -0.
    for (double k = std::ceil(low_ / step); k * step <= high_; k += 1) out.push_back(k * step + 0);
    return out;
  }

 private:
  [[nodiscard]] double scaled(double value) const { return is_log_ ? std::log10(value) : value; }

  bool is_log_;
  double pixel_low_, pixel_high_;
  double low_ = 0, high_ = 1;
};

std::string number(double value) { return fmt::format("{:.4g}", value); }

std::string frame(const Plot& plot, const Axis& x, const Axis& y) {
  const double right = kWidth - kRight, bottom = kHeight - kBottom;
  std::string out;
  for (const double tick : x.ticks())
    out += fmt::format(
        "<line x1='{0:.1f}' y1='{1}' x2='{0:.1f}' y2='{2}' stroke='#ddd'/>"
        "<text x='{0:.1f}' y='{3}' text-anchor='middle'>{4}</text>\n",
        x.at(tick), kTop, bottom, bottom + 18, number(tick));
  for (const double tick : y.ticks())
    out += fmt::format(
        "<line x1='{0}' y1='{1:.1f}' x2='{2}' y2='{1:.1f}' stroke='#ddd'/>"
        "<text x='{3}' y='{4:.1f}' text-anchor='end'>{5}</text>\n",
        kLeft, y.at(tick), right, kLeft - 6, y.at(tick) + 4, number(tick));
  out += fmt::format("<rect x='{}' y='{}' width='{}' height='{}' fill='none' stroke='#333'/>\n",
                     kLeft, kTop, right - kLeft, bottom - kTop);
  out += fmt::format("<text x='{}' y='24' text-anchor='middle' font-size='15'>{}</text>\n",
                     (kLeft + right) / 2, escaped(plot.title));
  out += fmt::format("<text x='{}' y='{}' text-anchor='middle'>{}</text>\n", (kLeft + right) / 2,
                     kHeight - 14, escaped(plot.x_label));
  out +=
      fmt::format("<text transform='translate(16 {}) rotate(-90)' text-anchor='middle'>{}</text>\n",
                  (kTop + bottom) / 2, escaped(plot.y_label));
  return out;
}

std::string curve(const Series& series, const char* colour, const Axis& x, const Axis& y) {
  std::string out, path;
  for (const auto& [px, py] : series.points) {
    path += fmt::format("{}{:.2f} {:.2f}", path.empty() ? "M" : " L", x.at(px), y.at(py));
    if (series.has_markers)
      out += fmt::format("<circle cx='{:.2f}' cy='{:.2f}' r='3' fill='{}'/>\n", x.at(px), y.at(py),
                         colour);
  }
  if (series.has_line)
    out += fmt::format("<path d='{}' fill='none' stroke='{}' stroke-width='1.8'/>\n", path, colour);
  return out;
}

}  // namespace

std::string to_svg(const Plot& plot) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double x_low = kInfinity, x_high = -kInfinity, y_low = kInfinity, y_high = -kInfinity;
  for (const Series& s : plot.series)
    for (const auto& [px, py] : s.points) {
      x_low = std::min(x_low, px);
      x_high = std::max(x_high, px);
      y_low = std::min(y_low, py);
      y_high = std::max(y_high, py);
    }
  if (x_low > x_high) x_low = y_low = 1, x_high = y_high = 2;
  const Axis x(plot.x_is_log, x_low, x_high, kLeft, kWidth - kRight);
  const Axis y(plot.y_is_log, y_low, y_high, kHeight - kBottom, kTop);
  std::string out = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' width='{0}' height='{1}' viewBox='0 0 {0} {1}' "
      "font-family='sans-serif' font-size='12'>\n<rect width='{0}' height='{1}' fill='white'/>\n",
      kWidth, kHeight);
  out += frame(plot, x, y);
  // To the right, below curves that rise and above those that fall.
  const auto& first =
      plot.series.empty() ? std::vector<std::pair<double, double>>{} : plot.series[0].points;
  const bool falls = !first.empty() && first.back().second < first.front().second;
  double legend = 0;
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const Series& s = plot.series[i];
    if (s.points.empty()) continue;
    const char* colour = kColours[i % kColours.size()];
    out += curve(s, colour, x, y);
    const double at = falls ? kTop + 20 + legend : kHeight - kBottom - 14 - legend;
    out += fmt::format(
        "<rect x='{}' y='{}' width='18' height='4' fill='{}'/>"
        "<text x='{}' y='{}' text-anchor='end'>{}</text>\n",
        kWidth - kRight - 30, at - 6, colour, kWidth - kRight - 36, at, escaped(s.name));
    legend += 17;
  }
  return out + "</svg>\n";
}

}  // namespace nacre::bench
