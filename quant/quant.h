// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/geometry.h"
#include "base/result.h"

/// Detail vectors ↔ points of the Z³ lattice ↔ product-code integers. See README.md.
namespace nacre::quant {

/// (normal, tangent 1, tangent 2) in units of the step.
using LatticePoint = std::array<std::int32_t, 3>;

/// No component of a lattice point may be larger: keeps every norm and index inside 64 bits.
inline constexpr std::int32_t kMaxComponent = 1 << 24;

struct QuantizerOptions {
  double step = 1.0;            ///< γ: edge of the lattice cell, model units, > 0
  double tangential_ratio = 1;  ///< tangential step / normal step, >= 1; the paper's Z³ has 1
  /// Half-width of a component's zero cell in steps, 0.5 (none) .. 1 excluded. Only the cell of ±1
  /// gives way: it is [dead_zone, 1.5), and [n - 0.5, n + 0.5) is that of n for n >= 2.
  double dead_zone = 0.6;
  /// Θ: half-angle of the cone, default 1°. 0 or less: no cone; π/2 or more: everything is inside.
  double theta_rad = 0.0174532925199432957692;
};

/// Encoder. Vectors inside the cone lose their tangential part; then each is quantised to Z³.
/// Details are in model units.
///
/// Ensures  (1) |component| <= kMaxComponent: larger ones are clamped, and so are infinite ones; a
///              component that is not a number gives 0
///          (2) a detail with zero tangential part gives a point with zero tangential part
///          (3) points[i] depends on details[i] and the options only
/// Source   [LVQ] section 3.2.
[[nodiscard]] std::vector<LatticePoint> quantize(std::span<const Vec3> details,
                                                 const QuantizerOptions& options);

/// Decoder: the lattice point, moved toward zero by `shrink` steps where the component is not 0.
/// Component c != 0 becomes ±((|c| - shrink) * s) with the sign of c, where s = step for the normal
/// and s = step * tangential_ratio for the tangents: in doubles, in this order. 0 becomes +0.
/// shrink in [0, 0.5].
[[nodiscard]] std::vector<Vec3> dequantize(std::span<const LatticePoint> points, double step,
                                           double tangential_ratio = 1, double shrink = 0);

/// The same with a shrink for each of the magnitudes 1, 2, and more; each in [-0.5, 0.5].
[[nodiscard]] std::vector<Vec3> dequantize(std::span<const LatticePoint> points, double step,
                                           double tangential_ratio,
                                           const std::array<double, 3>& shrinks);

/// The product code of a band, as two integer sequences that are coded apart.
///
/// prefix[i]  0 for the null vector; z if the tangential part is 0 (any sign); else the L1 norm K.
/// suffix     one entry per non-null vector, in order: 0 if the tangential part is 0, else
///            1 + rank, rank in [0, 4K²), of the vector among those of norm K with a tangential
///            part, by increasing |t1| + |t2| ([LVQ] 3.2; CODING: (0, 0, ±K) need no index).
struct ProductCode {
  std::vector<std::int64_t> prefix;
  std::vector<std::int64_t> suffix;
};

/// |component| <= kMaxComponent. Norms are below 2^26, so suffixes are below 2^54.
[[nodiscard]] ProductCode to_product_code(std::span<const LatticePoint> points);

/// Ensures  accepted if and only if to_product_code() gives exactly `code` for the result.
/// Errors   kCorruptStream if a norm, a rank or a length is impossible; `where` is the vector.
[[nodiscard]] Result<std::vector<LatticePoint>> from_product_code(const ProductCode& code);

/// Position of a vector with a tangential part among those of its L1 norm, in closed form: ordered
/// by m = |t1| + |t2|, then z > 0 before z < 0, then around the diamond |t1| + |t2| = m from (m, 0)
/// by way of (0, m). README.md has the formula.
[[nodiscard]] std::int64_t rank_on_shell(const LatticePoint& point);
/// Inverse of rank_on_shell(); norm >= 1, 0 <= rank < 4 norm².
[[nodiscard]] LatticePoint unrank_on_shell(std::int64_t norm, std::int64_t rank);

}  // namespace nacre::quant
