// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/goal.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace nacre::app {
namespace {

/// Medians of horse, venus and bunny, roughly so beyond 12: log2(diagonal / step), PSNR in dB, log2
/// of the file's bytes.
struct Usual {
  double fineness, psnr_db, log2_bytes;
};
constexpr std::array<Usual, 8> kUsual = {{{4, 49.7, 8.2},
                                          {6, 59.6, 9.5},
                                          {8, 66.4, 10.8},
                                          {10, 76.8, 12.6},
                                          {12, 85.5, 14.2},
                                          {14, 92.0, 16.3},
                                          {16, 96.5, 17.9},
                                          {18, 99.0, 19.0}}};

/// Piecewise linear through kUsual, and on beyond its ends.
double interpolate(double Usual::*from, double Usual::*to, double x) {
  std::size_t i = 1;
  while (i + 1 < kUsual.size() && kUsual[i].*from < x) ++i;
  const Usual &a = kUsual[i - 1], &b = kUsual[i];
  return a.*to + (b.*to - a.*to) * (x - a.*from) / (b.*from - a.*from);
}

constexpr double kBasePerRootByte = 3.6, kMostByRate = 480;
/// A base vertex costs about 25 bits; so many may be spent on shape where the shape asks for it.
constexpr double kBytesPerBaseVertex = 25.0 / 8, kMostBaseShare = 0.2;
/// A base mesh with more than this share of the scan's vertices is none.
constexpr double kMostOfScan = 1.0 / 8;
constexpr double kTrianglesPerByte = 33;

}  // namespace

std::string option_of(const Goal& goal) {
  switch (goal.kind) {
    case Goal::Kind::kQuality:
      return fmt::format("--quality {:g}", goal.value);
    case Goal::Kind::kSize:
      return fmt::format("--size {:.0f}", goal.value);
    case Goal::Kind::kBitsPerInputVertex:
      return fmt::format("--bits-per-vertex {:g}", goal.value);
    case Goal::Kind::kBitsPerSemiRegularVertex:
      return fmt::format("--bits-per-semi-regular-vertex {:g}", goal.value);
    case Goal::Kind::kPsnr:
      return fmt::format("--psnr {:g}", goal.value);
    case Goal::Kind::kMaxError:
      return fmt::format("--max-error {:g}", goal.value);
    case Goal::Kind::kMaxErrorPercent:
      return fmt::format("--max-error {:g}%", goal.value);
  }
  return {};
}

std::string_view name_of(Goal::Kind kind) {
  constexpr std::array<std::string_view, 7> kNames = {
      "quality", "size",      "bits_per_input_vertex", "bits_per_semi_regular_vertex",
      "psnr",    "max_error", "max_error_percent"};
  return kNames[static_cast<std::size_t>(kind)];
}

double step_of_quality(double quality) { return std::exp2(-4 - quality / 12.5); }

double usual_psnr_db(double relative_step) {
  return interpolate(&Usual::fineness, &Usual::psnr_db, -std::log2(relative_step));
}

double usual_bytes(double relative_step) {
  return std::exp2(interpolate(&Usual::fineness, &Usual::log2_bytes, -std::log2(relative_step)));
}

double usual_step(double psnr_db) {
  return std::exp2(-interpolate(&Usual::psnr_db, &Usual::fineness, psnr_db));
}

double allowed_error(const Goal& goal, double bbox_diagonal) {
  return goal.kind == Goal::Kind::kMaxErrorPercent ? goal.value / 100 * bbox_diagonal : goal.value;
}

double expected_bytes(const Goal& goal, std::size_t input_vertices, double bbox_diagonal) {
  switch (goal.kind) {
    case Goal::Kind::kSize:
      return goal.value;
    case Goal::Kind::kBitsPerInputVertex:
      return goal.value * static_cast<double>(input_vertices) / 8;
    case Goal::Kind::kBitsPerSemiRegularVertex:
      // Where nothing else is asked for, there are about as many of these as of the scan's.
      return goal.value * static_cast<double>(input_vertices) / 8;
    case Goal::Kind::kQuality:
      return usual_bytes(step_of_quality(goal.value));
    case Goal::Kind::kPsnr:
      return usual_bytes(usual_step(goal.value));
    case Goal::Kind::kMaxError:
    case Goal::Kind::kMaxErrorPercent: {
      const double share = allowed_error(goal, bbox_diagonal) / bbox_diagonal;
      return usual_bytes(usual_step(20 * std::log10(kUsualMaximumPerRms / share)));
    }
  }
  return 0;
}

RemeshSettings for_size(RemeshSettings settings, double bytes, std::size_t input_vertices) {
  bytes = std::clamp(bytes, 1.0, 1e9);
  const double most_of_scan = std::max(kMostOfScan * static_cast<double>(input_vertices), 4.0);
  const double least =
      std::clamp(std::min(kBasePerRootByte * std::sqrt(bytes), kMostByRate), 4.0, most_of_scan);
  settings.least_base_vertices = static_cast<int>(least);
  settings.most_base_vertices =
      static_cast<int>(std::max(least, kMostBaseShare * bytes / kBytesPerBaseVertex));
  settings.least_triangles = static_cast<std::size_t>(kTrianglesPerByte * bytes);
  return settings;
}

}  // namespace nacre::app
