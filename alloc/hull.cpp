// SPDX-License-Identifier: GPL-3.0-or-later
#include "alloc/hull.h"

#include <algorithm>
#include <tuple>

namespace nacre::alloc {
namespace {

double chord(const Sample& a, const Sample& b) {
  return (b.distortion - a.distortion) / (b.bits - a.bits);
}

}  // namespace

std::vector<Sample> lower_hull(std::span<const Sample> samples) {
  std::vector<Sample> sorted(samples.begin(), samples.end());
  std::sort(sorted.begin(), sorted.end(), [](const Sample& a, const Sample& b) {
    return std::tuple(a.bits, a.distortion, -a.step) < std::tuple(b.bits, b.distortion, -b.step);
  });
  std::vector<Sample> hull;
  for (const Sample& s : sorted) {
    if (!hull.empty() && s.distortion >= hull.back().distortion) continue;  // dearer and no better
    while (hull.size() >= 2 && chord(hull[hull.size() - 2], hull.back()) >= chord(hull.back(), s))
      hull.pop_back();
    hull.push_back(s);
  }
  return hull;
}

}  // namespace nacre::alloc
