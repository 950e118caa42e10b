// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "alloc/alloc.h"

/// A band of Laplacian details with small tangential parts, its dead-zone quantiser, and the rate
/// of an adaptive coder of zero flags, signs and magnitudes: real samples without the real coder.
namespace nacre::alloc {

inline constexpr double kInf = std::numeric_limits<double>::infinity();

inline double uniform(std::mt19937_64& engine) {
  return (static_cast<double>(engine() >> 11) + 0.5) * 0x1p-53;
}

class LaplacianBand {
 public:
  LaplacianBand(std::size_t vertex_count, double scale, double tangential,
                std::mt19937_64& engine) {
    for (auto& component : details_) {
      for (std::size_t i = 0; i < vertex_count; ++i) {
        const double u = uniform(engine) - 0.5;
        component.push_back(std::copysign(scale * std::log(1 - 2 * std::abs(u)), u));
      }
      scale = &component == &details_[0] ? scale * tangential : scale;
    }
  }
  [[nodiscard]] double count() const { return static_cast<double>(details_[0].size()); }
  [[nodiscard]] double energy() const {
    double sum = 0;
    for (const auto& component : details_)
      for (const double x : component) sum += x * x;
    return sum / count();
  }

  [[nodiscard]] Sample code(double step) const {
    if (step == kInf) return {kInf, 0, energy()};
    double error = 0, bits = 16;  // 16: what a coder spends on starting and ending
    for (const auto& component : details_) {
      double nonzero = 0, more = 0;
      for (const double x : component) {
        const double level = std::floor(std::abs(x) / step + 1.0 / 3);
        error += (std::abs(x) - level * step) * (std::abs(x) - level * step);
        nonzero += level > 0;
        more += std::max(level - 1, 0.0);
      }
      bits += flags(nonzero + 0.5, count() + 1) + nonzero + flags(more + 0.5, more + nonzero + 1);
    }
    return {step, bits / count(), error / count()};
  }

  /// 24 steps over four decades, and "not coded".
  [[nodiscard]] std::vector<Sample> samples() const {
    std::vector<Sample> result{code(kInf)};
    for (int k = 0; k < 24; ++k)
      result.push_back(code(10 * std::sqrt(energy()) * std::pow(10, -4 * k / 23.0)));
    return result;
  }

 private:
  static double flags(double ones, double all) {
    const double p = ones / all;
    return -all * (p * std::log2(p) + (1 - p) * std::log2(1 - p));
  }
  std::array<std::vector<double>, 3> details_;
};

}  // namespace nacre::alloc
