// SPDX-License-Identifier: Apache-2.0
//
// Read me first: a residual is coded coordinate by coordinate, the one closest to the surface
// normal last. What is already known of the residual bends the expectation of the coordinates that
// follow, as if residuals were normally distributed with a smaller variance along the normal: the
// gain of a local frame, with integers, and without rounding a rotation.
#include <algorithm>
#include <bit>
#include <cassert>
#include <cstdlib>
#include <utility>

#include "entropy/closed_mesh.h"
#include "entropy/connectivity.h"
#include "entropy/position_prediction.h"
#include "entropy/symbol_io.h"

namespace nacre::entropy {
namespace {

// Variance along the normal over what the tangential variance has more than it, in 1/64.
constexpr std::int64_t kNormalSpread = 24;

// A magnitude is told by its half-octave relative to that of the local edge length: class 0 is all
// that is below kBelow half-octaves under it, then one class each, then an escape.
constexpr int kBelow = 8;
constexpr int kClasses = 17;

// Contexts of the classes.
constexpr std::size_t kPlain = 0;   // no normal known
constexpr std::size_t kFirst = 1;   // first coordinate, by neighbours known: 2, 3, more
constexpr std::size_t kSecond = 4;  // by whether the first had a class of 8 or more
constexpr std::size_t kSteep = 6;   // third, by the larger class before: below 2, 4, 6, 8, or more
constexpr std::size_t kFlat = 11;   // the same where the normal is close to the third axis
constexpr std::size_t kContexts = 16;

constexpr std::uint32_t kIncrement = 12;
// Initial frequencies: shares, in thousandths, on the meshes that kWeights was fitted to.
constexpr std::uint16_t kFrequencies[kContexts][kClasses] = {
    {310, 81, 59, 98, 50, 81, 45, 63, 54, 28, 32, 23, 23, 32, 10, 10, 2},
    {193, 75, 101, 129, 150, 139, 106, 59, 28, 10, 5, 2, 2, 2, 2, 2, 2},
    {222, 88, 100, 130, 139, 134, 94, 60, 21, 7, 2, 2, 2, 2, 2, 2, 2},
    {263, 107, 111, 128, 126, 116, 96, 29, 12, 8, 2, 2, 2, 2, 2, 2, 2},
    {258, 94, 122, 126, 134, 117, 83, 40, 15, 6, 3, 2, 2, 2, 2, 2, 2},
    {167, 61, 88, 88, 96, 114, 133, 91, 64, 46, 30, 11, 6, 3, 2, 2, 2},
    {516, 142, 104, 78, 51, 49, 40, 14, 2, 2, 2, 2, 2, 2, 2, 2, 2},
    {423, 130, 111, 133, 83, 61, 32, 15, 7, 2, 2, 2, 2, 2, 2, 2, 2},
    {330, 117, 123, 125, 111, 89, 56, 36, 7, 4, 2, 2, 2, 2, 2, 2, 2},
    {223, 62, 118, 134, 119, 122, 122, 59, 31, 4, 2, 2, 2, 2, 2, 2, 2},
    {92, 44, 56, 88, 107, 143, 135, 88, 123, 64, 17, 33, 5, 2, 2, 2, 2},
    {599, 97, 98, 75, 62, 28, 25, 8, 4, 2, 2, 2, 2, 2, 2, 2, 2},
    {552, 108, 91, 102, 76, 30, 21, 11, 6, 2, 2, 2, 2, 2, 2, 2, 2},
    {470, 101, 116, 101, 87, 54, 38, 21, 6, 2, 2, 2, 2, 2, 2, 2, 2},
    {384, 100, 109, 90, 105, 94, 61, 28, 17, 3, 5, 2, 2, 2, 2, 2, 2},
    {262, 89, 84, 84, 78, 99, 86, 76, 53, 45, 16, 9, 14, 3, 2, 2, 2}};

/// The least magnitude of half-octave h >= 2: 2^(h/2), halfway between two of these for odd h.
constexpr std::int64_t octave_start(int h) {
  return h % 2 == 0 ? std::int64_t{1} << (h / 2) : std::int64_t{3} << (h / 2 - 1);
}

/// The axes by how far the normal points along them, least first.
std::array<std::size_t, 3> order_axes(const Wide3& normal) {
  std::array<std::size_t, 3> axes = {0, 1, 2};
  std::stable_sort(axes.begin(), axes.end(), [&](std::size_t i, std::size_t k) {
    return std::abs(normal[i]) < std::abs(normal[k]);
  });
  return axes;
}

/// Scaled down to 10 bits a component: enough for a direction, and products stay below 2^60.
Wide3 shorten(Wide3 normal) {
  std::uint64_t largest = 0;
  for (const std::int64_t x : normal)
    largest = std::max(largest, static_cast<std::uint64_t>(std::abs(x)));
  const int excess = std::max(0, static_cast<int>(std::bit_width(largest)) - 10);
  for (std::int64_t& x : normal) x /= std::int64_t{1} << excess;
  return normal;
}

template <class Io>
class PositionCoder {
 public:
  PositionCoder(Io& io, int bits) : io_(io), bits_(bits) {
    for (const auto& frequencies : kFrequencies) classes_.emplace_back(frequencies, kIncrement);
  }

  /// Codes `point`, or reads it. False if what was read is outside the grid.
  [[nodiscard]] bool code(const Prediction& p, GridPoint& point) {
    if (p.neighbours == 0) {
      for (std::int32_t& x : point)
        x = static_cast<std::int32_t>(code_long_bits(io_, static_cast<std::uint32_t>(x), bits_));
      return true;
    }
    const std::int64_t size = std::int64_t{1} << bits_;
    const Wide3 normal = shorten(p.normal);
    const std::array<std::size_t, 3> axes = order_axes(normal);
    const std::int64_t n2 = squared(normal);
    std::int64_t lean = 0;  // normal · residual so far
    int loudest = 0;        // largest class so far
    for (std::size_t rank = 0; rank < 3; ++rank) {
      const std::size_t k = axes[rank];
      const std::int64_t n = normal[k];
      std::int64_t expected = p.point[k];
      if (rank == 1 && n2 > 0) {
        const std::int64_t first = normal[axes[0]];
        expected -= divide(64 * n * lean, (64 + kNormalSpread) * n2 - 64 * first * first);
      } else if (rank == 2 && n2 > 0) {
        expected -= divide(64 * n * lean, 64 * n * n + kNormalSpread * n2);
      }
      expected = std::clamp<std::int64_t>(expected, 0, size - 1);
      AdaptiveModel& classes = classes_[context(p, rank, loudest, 10 * n * n > 7 * n2)];
      const std::int64_t x = expected + residual(point[k] - expected, p.scale, classes, loudest);
      if (x < 0 || x >= size) return false;
      point[k] = static_cast<std::int32_t>(x);
      lean += n * (x - p.point[k]);
    }
    return true;
  }

 private:
  static std::size_t context(const Prediction& p, std::size_t rank, int loudest, bool flat) {
    if (p.normal == Wide3{}) return kPlain;
    if (rank == 0) return kFirst + static_cast<std::size_t>(std::max(p.neighbours, 2) - 2);
    if (rank == 1) return kSecond + (loudest >= 8 ? 1 : 0);
    return (flat ? kFlat : kSteep) + static_cast<std::size_t>(std::min(loudest / 2, 4));
  }

  std::int64_t residual(std::int64_t e, int scale, AdaptiveModel& classes, int& loudest) {
    const int base = std::max(scale - kBelow, 2);
    const std::int64_t magnitude = std::abs(e);
    int symbol = 0;
    while (symbol < kClasses - 1 && magnitude >= octave_start(base + symbol)) ++symbol;
    symbol = io_.symbol(symbol, classes);
    loudest = std::max(loudest, symbol);
    const std::int64_t low = symbol == 0 ? 0 : octave_start(base + symbol - 1);
    const auto above = static_cast<std::uint32_t>(std::max<std::int64_t>(magnitude - low, 0));
    std::int64_t coded = low;
    if (symbol == kClasses - 1) {
      coded += code_number(io_, above, escape_);
    } else {
      coded +=
          code_uniform(io_, above, static_cast<std::uint32_t>(octave_start(base + symbol) - low));
    }
    if (coded == 0) return 0;
    return io_.bits(e < 0 ? 1 : 0, 1) == 1 ? -coded : coded;
  }

  Io& io_;
  int bits_;
  std::vector<AdaptiveModel> classes_;
  AdaptiveModel escape_{32};
};

template <class Io>
bool code_positions(Io& io, const ClosedMesh& mesh, int bits, std::uint32_t reach,
                    std::span<GridPoint> points) {
  reach = io.bits(reach, 2);
  // As if V vertices were spread over a square of the grid's side, 2^(2 bits + 1) / V a squared
  // edge.
  const int default_scale =
      std::max(2, 2 * bits + 3 - static_cast<int>(std::bit_width(mesh.vertex_count)));
  PositionOrder order(mesh);
  PositionCoder<Io> coder(io, bits);
  for (std::uint32_t v = order.next(); v != kNone; v = order.next()) {
    const Prediction p = predict_position(order, points, v, bits, default_scale, kReaches[reach]);
    if (!coder.code(p, points[v]) || io.failed()) return false;
    order.finish(v);
  }
  return true;
}

}  // namespace

std::vector<std::uint8_t> encode_base_positions(std::span<const GridPoint> points,
                                                const Connectivity& connectivity, int bits) {
  assert(points.size() == connectivity.vertex_count && bits >= 1 && bits <= 24);
  const Result<ClosedMesh> mesh = close_mesh(connectivity.triangles, connectivity.vertex_count);
  assert(mesh.has_value());
  std::vector<std::uint8_t> best;
  if (!mesh || points.empty()) return best;
  std::vector<GridPoint> copy(points.begin(), points.end());
  for (std::uint32_t reach = 0; reach < kReaches.size(); ++reach) {
    SymbolWriter writer;
    const bool ok = code_positions(writer, *mesh, bits, reach, copy);
    assert(ok);
    static_cast<void>(ok);
    std::vector<std::uint8_t> bytes = writer.finish();
    if (reach == 0 || bytes.size() < best.size()) best = std::move(bytes);
  }
  return best;
}

Result<std::vector<GridPoint>> decode_base_positions(std::span<const std::uint8_t> bytes,
                                                     const Connectivity& connectivity, int bits) {
  const Error corrupt{ErrorCode::kCorruptStream, "base positions do not decode to grid points", 0};
  if (bits < 1 || bits > 24) return corrupt;
  const Result<ClosedMesh> mesh = close_mesh(connectivity.triangles, connectivity.vertex_count);
  if (!mesh) return corrupt;
  SymbolReader reader(bytes);
  std::vector<GridPoint> points(connectivity.vertex_count);
  if (points.empty()) return bytes.empty() ? Result<std::vector<GridPoint>>(points) : corrupt;
  if (!code_positions(reader, *mesh, bits, 0, points) || !reader.ends_exactly()) return corrupt;
  return points;
}

}  // namespace nacre::entropy
