// SPDX-License-Identifier: Apache-2.0
//
// Read me first: the points of L1 norm K with m = |t1| + |t2| >= 1 lie on diamonds of 4m points,
// two of them (z = ±(K - m)) for each m < K and one (z = 0) for m = K. The diamonds below m hold 8
// (1 + .. + (m - 1)) = 4m(m - 1) points, all of them 4K². So m follows from a rank by one square
// root, for any K and without tables.
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <string>

#include "quant/quant.h"

namespace nacre::quant {
namespace {

// No point has a larger norm, so 4K² < 2^54 and every intermediate below fits in 64 bits.
constexpr std::int64_t kMaxNorm = 3 * std::int64_t{kMaxComponent};

std::int64_t magnitude(std::int32_t component) { return std::abs(std::int64_t{component}); }

// floor(sqrt(n)) for 0 <= n < 2^60; the double root may be off by one either way.
std::int64_t integer_sqrt(std::int64_t n) {
  auto root = static_cast<std::int64_t>(std::sqrt(static_cast<double>(n)));
  while (root * root > n) --root;
  while ((root + 1) * (root + 1) <= n) ++root;
  return root;
}

// The largest m >= 1 with 4m(m - 1) <= rank, that is (2m - 1)² <= 4 floor(rank / 4) + 1.
std::int64_t tangential_norm_of_rank(std::int64_t rank) {
  return (1 + integer_sqrt(rank / 4 * 4 + 1)) / 2;
}

Error corrupt(const char* what, std::size_t vector) {
  return {ErrorCode::kCorruptStream, std::string("product code: ") + what, vector};
}

bool is_possible(const LatticePoint& point) {
  return magnitude(point[0]) <= kMaxComponent && magnitude(point[1]) <= kMaxComponent &&
         magnitude(point[2]) <= kMaxComponent;
}

}  // namespace

std::int64_t rank_on_shell(const LatticePoint& point) {
  const std::int64_t t1 = point[1];
  const std::int64_t t2 = point[2];
  const std::int64_t m = magnitude(point[1]) + magnitude(point[2]);
  assert(m >= 1 && is_possible(point));
  // Around the diamond: (m, 0) → (0, m) → (-m, 0) → (0, -m), m points a side.
  std::int64_t around = 0;
  if (t1 > 0 && t2 >= 0) {
    around = t2;
  } else if (t1 <= 0 && t2 > 0) {
    around = m - t1;
  } else if (t1 < 0 && t2 <= 0) {
    around = 2 * m - t2;
  } else {
    around = 3 * m + t1;
  }
  return 4 * m * (m - 1) + (point[0] < 0 ? 4 * m : 0) + around;
}

LatticePoint unrank_on_shell(std::int64_t norm, std::int64_t rank) {
  assert(norm >= 1 && norm <= kMaxNorm && rank >= 0 && rank < 4 * norm * norm);
  const std::int64_t m = tangential_norm_of_rank(rank);
  std::int64_t around = rank - 4 * m * (m - 1);
  std::int64_t z = norm - m;
  if (around >= 4 * m) {
    around -= 4 * m;
    z = -z;
  }
  const std::int64_t i = around % m;
  std::int64_t t1 = 0;
  std::int64_t t2 = 0;
  switch (around / m) {
    case 0:
      t1 = m - i;
      t2 = i;
      break;
    case 1:
      t1 = -i;
      t2 = m - i;
      break;
    case 2:
      t1 = i - m;
      t2 = -i;
      break;
    default:
      t1 = i;
      t2 = i - m;
      break;
  }
  return {static_cast<std::int32_t>(z), static_cast<std::int32_t>(t1),
          static_cast<std::int32_t>(t2)};
}

ProductCode to_product_code(std::span<const LatticePoint> points) {
  ProductCode code;
  code.prefix.reserve(points.size());
  for (const LatticePoint& point : points) {
    assert(is_possible(point));
    if (point[1] == 0 && point[2] == 0) {
      code.prefix.push_back(point[0]);
      if (point[0] != 0) code.suffix.push_back(0);
    } else {
      code.prefix.push_back(magnitude(point[0]) + magnitude(point[1]) + magnitude(point[2]));
      code.suffix.push_back(1 + rank_on_shell(point));
    }
  }
  return code;
}

Result<std::vector<LatticePoint>> from_product_code(const ProductCode& code) {
  std::vector<LatticePoint> points;
  points.reserve(code.prefix.size());
  std::size_t suffixes_used = 0;
  for (const std::int64_t prefix : code.prefix) {
    const std::size_t vector = points.size();
    if (prefix == 0) {
      points.push_back({0, 0, 0});
      continue;
    }
    if (suffixes_used == code.suffix.size()) return corrupt("too few suffixes", vector);
    const std::int64_t suffix = code.suffix[suffixes_used++];
    if (suffix == 0) {
      if (prefix < -kMaxComponent || prefix > kMaxComponent) {
        return corrupt("a normal component is too large", vector);
      }
      points.push_back({static_cast<std::int32_t>(prefix), 0, 0});
      continue;
    }
    if (prefix < 0 || prefix > kMaxNorm) return corrupt("impossible norm", vector);
    if (suffix < 0 || suffix > 4 * prefix * prefix) return corrupt("impossible rank", vector);
    points.push_back(unrank_on_shell(prefix, suffix - 1));
    if (!is_possible(points.back())) return corrupt("a component is too large", vector);
  }
  if (suffixes_used != code.suffix.size()) return corrupt("too many suffixes", points.size());
  return points;
}

}  // namespace nacre::quant
