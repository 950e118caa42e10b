// SPDX-License-Identifier: Apache-2.0
#include "wavelet/turn.h"

#include <array>
#include <cassert>

namespace nacre::wavelet {
namespace {

constexpr double kQuarterPi = 0x1.921fb54442d18p-1;

// (-1)^n / (2n)! and (-1)^n / (2n + 1)!, highest first; the factorials are exact doubles, so each
// quotient is one correctly rounded division. Truncation at x = π/4 is below 3e-18.
constexpr std::array<double, 9> kCosTerms = {1.0 / 20922789888000.0,
                                             -1.0 / 87178291200.0,
                                             1.0 / 479001600.0,
                                             -1.0 / 3628800.0,
                                             1.0 / 40320.0,
                                             -1.0 / 720.0,
                                             1.0 / 24.0,
                                             -1.0 / 2.0,
                                             1.0};
constexpr std::array<double, 9> kSinTerms = {1.0 / 355687428096000.0,
                                             -1.0 / 1307674368000.0,
                                             1.0 / 6227020800.0,
                                             -1.0 / 39916800.0,
                                             1.0 / 362880.0,
                                             -1.0 / 5040.0,
                                             1.0 / 120.0,
                                             -1.0 / 6.0,
                                             1.0};

double horner(const std::array<double, 9>& terms, double y) {
  double sum = terms[0];
  for (std::size_t i = 1; i < terms.size(); ++i) sum = sum * y + terms[i];
  return sum;
}

}  // namespace

CosSin turn(std::uint32_t numerator, std::uint32_t denominator) {
  assert(numerator < denominator);
  const std::uint64_t eighths = 8 * static_cast<std::uint64_t>(numerator);
  const std::uint64_t octant = eighths / denominator;
  const std::uint64_t rest = eighths % denominator;
  // Odd octants are measured back from their far end, so that x stays within [0, π/4].
  const std::uint64_t part = octant % 2 == 0 ? rest : denominator - rest;
  const double x = kQuarterPi * (static_cast<double>(part) / static_cast<double>(denominator));
  const double c = horner(kCosTerms, x * x);
  const double s = x * horner(kSinTerms, x * x);
  switch (octant) {
    case 0:
      return {c, s};
    case 1:
      return {s, c};
    case 2:
      return {-s, c};
    case 3:
      return {-c, s};
    case 4:
      return {-c, -s};
    case 5:
      return {-s, -c};
    case 6:
      return {s, -c};
    default:
      return {c, -s};
  }
}

}  // namespace nacre::wavelet
