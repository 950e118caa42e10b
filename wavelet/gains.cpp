// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cstdint>

#include "base/parallel.h"
#include "wavelet/refine.h"
#include "wavelet/wavelet.h"

namespace nacre::wavelet {
namespace {

// ---- The regular lattice ------------------------------------------------------------------------
// E_k, the energy of the k times refined impulse, is entry 0 of that function's autocorrelation
// r_k, and refinement acts on autocorrelations linearly: r_{k+1}[n] = Σ_m A[n - 2m] r_k[m], where A
// is the mask's. Entries beyond A's own support never reach entry 0 again, so a small fixed array
// stands for an impulse response of any size, without error.

struct Lattice {
  int x = 0, y = 0;
};
Lattice operator+(Lattice a, Lattice b) { return {a.x + b.x, a.y + b.y}; }
Lattice operator-(Lattice a, Lattice b) { return {a.x - b.x, a.y - b.y}; }

constexpr int kMaskRadius = 4;  // no mask here reaches further than 4 fine steps
constexpr int kRadius = 2 * kMaskRadius;
constexpr int kSide = 2 * kRadius + 1;

/// Values at lattice points within kRadius of 0 in both coordinates; 0 elsewhere.
class Patch {
 public:
  [[nodiscard]] double get(Lattice p) const {
    return std::max(std::abs(p.x), std::abs(p.y)) <= kRadius ? values_[index(p)] : 0.0;
  }
  void add(Lattice p, double value) { values_[index(p)] += value; }

 private:
  static std::size_t index(Lattice p) {
    return static_cast<std::size_t>((p.y + kRadius) * kSide + p.x + kRadius);
  }
  std::array<double, kSide * kSide> values_{};
};

template <class Visit>
void for_each_point(int radius, const Visit& visit) {
  for (int y = -radius; y <= radius; ++y)
    for (int x = -radius; x <= radius; ++x) visit(Lattice{x, y});
}

constexpr std::array<Lattice, 6> kNeighbours = {
    {{1, 0}, {1, 1}, {0, 1}, {-1, 0}, {-1, -1}, {0, -1}}};

/// The once refined impulse. The coarse point p lies at the fine point 2p.
Patch mask(Transform transform) {
  Patch h;
  const auto add = [&](Lattice fine_minus_coarse, double weight) {
    h.add(fine_minus_coarse, weight);
  };
  // The midpoint of edge 0 - d is the fine point d; its stencil point q weighs in at d - 2q.
  for (std::size_t i = 0; i < 3; ++i) {
    const Lattice d = kNeighbours[i], zero{};
    const Lattice c = kNeighbours[i + 1], b = kNeighbours[(i + 5) % 6];
    const auto weigh = [&](Lattice q, double weight) { add(d - (q + q), weight); };
    const bool loop = transform == Transform::kLoop;
    for (const Lattice q : {zero, d}) weigh(q, loop ? 3.0 / 8 : 1.0 / 2);
    for (const Lattice q : {c, b}) weigh(q, 1.0 / 8);
    if (loop) continue;
    for (const Lattice q : {c - d, b - d, d + c, d + b}) weigh(q, -1.0 / 16);
  }
  if (transform == Transform::kLoop) {
    add({}, 5.0 / 8);
    for (const Lattice d : kNeighbours) add(d + d, 1.0 / 16);
  } else {
    add({}, 1.0);
  }
  return h;
}

Patch autocorrelation(const Patch& h) {
  Patch result;
  for_each_point(kRadius, [&](Lattice lag) {
    for_each_point(kMaskRadius, [&](Lattice p) { result.add(lag, h.get(p) * h.get(p + lag)); });
  });
  return result;
}

// ---- A given mesh -------------------------------------------------------------------------------

constexpr std::size_t kWantedSamples = 16384;  // ±1 values per band: about 2 % standard error
constexpr std::size_t kMaxRounds = 16;         // three signals each

/// [Steele2014] SplitMix64: the same signs on every machine.
std::uint64_t next_random(std::uint64_t& state) {
  std::uint64_t z = (state += 0x9E3779B97F4A7C15u);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

double energy(std::span<const Vec3> values) {
  double sum = 0;
  for (const Vec3& v : values) sum += dot(v, v);
  return sum;
}

/// Energy on the finest mesh of three random ±1 signals on the vertices first .. end of `level`.
double refined_energy(const Topology& topology, const Refiner& refiner, int level,
                      std::uint32_t first, std::uint64_t seed) {
  std::vector<Vec3> signal(topology.level(level).vertex_count, Vec3::Zero());
  for (std::size_t v = first; v < signal.size(); ++v) {
    const std::uint64_t bits = next_random(seed);
    for (int c = 0; c < 3; ++c) signal[v][c] = ((bits >> c) & 1) != 0 ? 1.0 : -1.0;
  }
  for (int j = level; j < topology.level_count(); ++j) signal = refiner.predict(j, signal);
  return energy(signal);
}

}  // namespace

Gains regular_gains(int level_count, Transform transform) {
  const Patch A = autocorrelation(mask(transform));
  Patch r;
  r.add({}, 1.0);
  std::vector<double> E = {1.0};  // E[k]: after k refinements
  for (int k = 0; k < level_count; ++k) {
    Patch next;
    for_each_point(kRadius, [&](Lattice n) {
      for_each_point(kRadius, [&](Lattice m) { next.add(n, A.get(n - (m + m)) * r.get(m)); });
    });
    r = next;
    E.push_back(r.get({}));
  }
  // The base is refined level_count times, band j only level_count - 1 - j times.
  Gains gains;
  gains.energy.push_back(E.back());
  for (int j = 0; j < level_count; ++j)
    gains.energy.push_back(E[static_cast<std::size_t>(level_count - 1 - j)]);
  return gains;
}

Gains measured_gains(const Topology& topology, Transform transform) {
  const Refiner refiner(topology, transform);
  Gains gains;
  for (int band = -1; band < topology.level_count(); ++band) {
    const std::uint32_t first = band < 0 ? 0 : topology.level(band).vertex_count;
    const std::size_t size = topology.level(band + 1).vertex_count - first;
    if (band + 1 == topology.level_count() || size == 0) {
      gains.energy.push_back(1.0);  // nothing is refined any further
      continue;
    }
    const std::size_t rounds = std::clamp<std::size_t>(kWantedSamples / (3 * size), 1, kMaxRounds);
    std::vector<double> sums(rounds);
    parallel_for_each_index(
        rounds,
        [&](std::size_t i) {
          const std::uint64_t seed = (static_cast<std::uint64_t>(band + 1) << 32) + i;
          sums[i] = refined_energy(topology, refiner, band + 1, first, seed);
        },
        1);
    double total = 0;
    for (const double sum : sums) total += sum;
    gains.energy.push_back(total / static_cast<double>(3 * size * rounds));
  }
  return gains;
}

}  // namespace nacre::wavelet
