// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "base/topology.h"
#include "base/zeroed_allocator.h"
#include "entropy/binary_model.h"

/// What is known about a detail before it is coded: contexts from its band's earlier details and
/// from the coarser band. Decoder and encoder share it; docs/FORMAT.md states every rule.
namespace nacre::entropy {

/// A quantised detail: (normal, across, along), in steps.
using DetailPoint = std::array<std::int32_t, 3>;

inline constexpr std::int32_t kMaxDetail = 1 << 24;  ///< of a component, in magnitude

/// Magnitudes in classes, two to an octave: 1, 2, 3, 4, 5-6, 7-8, 9-12, 13-16, 17-24, ...
inline constexpr int kMagnitudeClasses = 48;
[[nodiscard]] inline int magnitude_class(std::int32_t magnitude) {  // 1 .. kMaxDetail
  if (magnitude <= 4) return magnitude - 1;
  const auto m = static_cast<std::uint32_t>(magnitude - 1);
  const int k = static_cast<int>(std::bit_width(m)) - 1;
  return 2 * k + static_cast<int>((m >> (k - 1)) & 1);
}
[[nodiscard]] inline std::int32_t least_of_class(int c) {
  if (c < 4) return c + 1;
  return ((2 + (c & 1)) << (c / 2 - 1)) + 1;
}
[[nodiscard]] inline int raw_bits_of_class(int c) { return c < 4 ? 0 : c / 2 - 1; }

/// Where a band lies. Pointers stay the caller's.
struct BandPlace {
  const LevelTopology* level = nullptr;    ///< its details are those of this level's edges
  const LevelTopology* coarser = nullptr;  ///< the level below; none for band 0
  int band = 0;
  int coarser_step_excess =
      0;  ///< step index of the coarser band less this one's; 0 if it has none
};

/// Details come in blocks of so many, the last one perhaps shorter.
inline constexpr std::uint32_t kBlockDetails = 64;

/// Groups of neighbours whose magnitudes and signs are told apart.
enum DetailGroup : std::size_t { kNear, kFar, kBeside, kBeyond, kParents, kOthers };

/// What non-zero details around one detail have left at it; one of them adds all its numbers at
/// once, each wrapping around on its own.
struct alignas(16) Surroundings {
  enum Sum : std::size_t {
    kBand,    ///< magnitude expected from its own band, 1/256 steps
    kBelow,   ///< from the coarser band, 1/4096 steps; in band 0: weight known
    kMean,    ///< value expected, 1/4096 steps
    kParent,  ///< magnitudes, twice a half's parent
  };
  /// Counts: magnitudes of the first four groups, each up to 15; values of all six, each up to
  /// ±10; tangential magnitudes.
  static constexpr std::size_t kFew = 0, kSigns = 4, kTangential = 10;

  std::array<std::uint32_t, 4> sums;
  std::array<std::uint8_t, 16> counts;

  void add(const Surroundings& other) {
    // Vectors of the compiler's own: it does not see by itself that this is two instructions.
    using Four [[gnu::vector_size(16)]] = std::uint32_t;
    using Sixteen [[gnu::vector_size(16)]] = std::uint8_t;
    add_as<Four>(other.sums.data(), sums.data());
    add_as<Sixteen>(other.counts.data(), counts.data());
  }
  [[nodiscard]] std::int32_t sum(Sum which) const { return static_cast<std::int32_t>(sums[which]); }
  [[nodiscard]] int few(DetailGroup group) const { return counts[kFew + group]; }
  [[nodiscard]] int sign(DetailGroup group) const {
    return static_cast<std::int8_t>(counts[kSigns + group]);
  }
  [[nodiscard]] int parent() const { return static_cast<int>(sums[kParent] & 0xFFFFu); }
  [[nodiscard]] int tangential() const { return counts[kTangential]; }

 private:
  template <class Vector>
  static void add_as(const void* what, void* to) {
    Vector sum, more;
    std::memcpy(&sum, to, sizeof sum);
    std::memcpy(&more, what, sizeof more);
    sum += more;
    std::memcpy(to, &sum, sizeof sum);
  }
};

/// Neighbourhood of one detail, reduced to small numbers. Good until details after it are set.
struct DetailContext {
  std::uint32_t detail = 0;
  bool is_quiet = true;  ///< nothing but zeros around
  bool is_faint = true;  ///< nothing but zeros in the first ring and at the parents
  int kind = 0;          ///< 0, 1: first, second half of a coarser edge; 2: edge inside a triangle
  int mean = 0;          ///< value expected, 1/256 steps
  int expected_bin = 0;  ///< magnitude expected from all, in bins of 1/256 steps
  int inherited = 0;     ///< magnitude expected from the coarser band, 1/256 steps
  const Surroundings* around = nullptr;
};

/// Counters of one context of one bit: a range of all of them.
struct CounterTable {
  std::size_t begin = 0, size = 0;
  [[nodiscard]] constexpr std::size_t end() const { return begin + size; }
};

/// Statistics of all bands so far, and what is known of this band.
class DetailModel {
 public:
  enum class Start : std::uint8_t { kLearnt, kBlank };
  explicit DetailModel(Start start = Start::kLearnt);

  /// Starts a band whose details are zeros until set() says otherwise; those of the band before
  /// become the coarser ones.
  void begin_band(const BandPlace& place);
  /// The same for a band without payload: all zeros, no look().
  void skip_band(const BandPlace& place);

  /// Bit i: detail 64 block + i is not quiet, as far as is known now.
  [[nodiscard]] std::uint64_t active(std::uint32_t block) const { return active_[block]; }
  /// The same if none of the block's details were quiet.
  [[nodiscard]] std::uint64_t all_of(std::uint32_t block) const {
    const std::size_t left = around_.size() - std::size_t{block} * kBlockDetails;
    return left >= kBlockDetails ? ~std::uint64_t{0} : (std::uint64_t{1} << left) - 1;
  }
  /// Context of detail e; details 0 .. e-1 are known.
  [[nodiscard]] inline DetailContext look(std::uint32_t e) const;
  /// Every detail of band 0, in order; of other bands those that are not zero.
  void set(std::uint32_t e, const DetailPoint& point);

  /// Whether details of a block that are quiet may be other than zero.
  [[nodiscard]] inline SingleBit quiet_may_rise(bool has_active);
  /// Whether a block's details may have tangential parts.
  [[nodiscard]] inline SingleBit block_has_tangential(bool last_block_has);
  /// The first of a faint detail, the second of others.
  [[nodiscard]] inline SingleBit faint_is_nonzero(const DetailContext& context);
  [[nodiscard]] inline MixedBit<7> is_nonzero(const DetailContext& context);
  [[nodiscard]] inline MixedBit<4> is_negative(const DetailContext& context);
  /// Whether the magnitude's class is above `magnitude_class`, given that it is not below.
  [[nodiscard]] inline MixedBit<6> is_above(const DetailContext& context, bool negative,
                                            int magnitude_class);

  /// All counters in the order of the format: for learning their starts.
  [[nodiscard]] std::span<const BitCounter> counters() const { return counters_; }

  [[nodiscard]] inline MixedBit<3> has_tangential(const DetailContext& context,
                                                  bool normal_is_zero);
  /// Component 0: across, 1: along.
  [[nodiscard]] inline MixedBit<2> tangential_is_nonzero(const DetailContext& context,
                                                         int component);
  [[nodiscard]] inline SingleBit tangential_is_negative(const DetailContext& context,
                                                        int component);
  [[nodiscard]] inline MixedBit<2> tangential_is_above(const DetailContext& context, int component,
                                                       int magnitude_class);

 private:
  static constexpr int kLevels = 8;  // bands that are told apart

  static constexpr CounterTable kRise = {0, 2 * kLevels};
  static constexpr CounterTable kBlockTangential = {kRise.end(), 2 * kLevels};
  static constexpr CounterTable kQuiet = {kBlockTangential.end(), 3 * kLevels};
  static constexpr CounterTable kFaint = {kQuiet.end(), 96 * kLevels};
  static constexpr CounterTable kZero0 = {kFaint.end(), 96};
  static constexpr CounterTable kZero1 = {kZero0.end(), 512};
  static constexpr CounterTable kZero2 = {kZero1.end(), 432};
  static constexpr CounterTable kZero3 = {kZero2.end(), 432};
  static constexpr CounterTable kZero4 = {kZero3.end(), 288};
  static constexpr CounterTable kZero5 = {kZero4.end(), 576};
  static constexpr CounterTable kZero6 = {kZero5.end(), 768};
  static constexpr CounterTable kSign1 = {kZero6.end(), 768};
  static constexpr CounterTable kSign0 = {kSign1.end(), 96};
  static constexpr CounterTable kSign2 = {kSign0.end(), 375};
  static constexpr CounterTable kSign3 = {kSign2.end(), 243};
  static constexpr CounterTable kAbove0 = {kSign3.end(), 128};
  static constexpr CounterTable kAbove1 = {kAbove0.end(), 960};
  static constexpr CounterTable kAbove2 = {kAbove1.end(), 480};
  static constexpr CounterTable kAbove3 = {kAbove2.end(), 576};
  static constexpr CounterTable kAbove4 = {kAbove3.end(), 2160};
  static constexpr CounterTable kAbove5 = {kAbove4.end(), 4096};
  static constexpr CounterTable kTangential0 = {kAbove5.end(), 48};
  static constexpr CounterTable kTangential1 = {kTangential0.end(), 64};
  static constexpr CounterTable kTangential2 = {kTangential1.end(), 32};
  static constexpr CounterTable kTangentialZero0 = {kTangential2.end(), 16};
  static constexpr CounterTable kTangentialZero1 = {kTangentialZero0.end(), 12};
  static constexpr CounterTable kTangentialSign = {kTangentialZero1.end(), 4};
  static constexpr CounterTable kTangentialAbove0 = {kTangentialSign.end(), 2 * kMagnitudeClasses};
  static constexpr CounterTable kTangentialAbove1 = {kTangentialAbove0.end(),
                                                     8 * kMagnitudeClasses};
  static constexpr std::size_t kCounters = kTangentialAbove1.end();

  struct Weights {
    std::array<MixerWeights, 48> zero;
    std::array<MixerWeights, 3> sign;
    std::array<MixerWeights, 4> above;
    std::array<MixerWeights, 2> tangential;
    MixerWeights tangential_zero, tangential_above;
  };

  struct Nonzero {
    std::uint32_t detail = 0;
    std::int16_t normal = 0;  // clamped
    std::uint8_t tangential = 0;
  };

  /// What one detail adds to others by their kind, and by where they are: in its own band by ring
  /// (0 the other half, 1 the first, 2 the second), in the finer one by role.
  using Spread = std::array<std::array<Surroundings, 3>, 3>;
  /// Details up to this magnitude have theirs made once for a band.
  static constexpr int kReady = 4;
  using Spreads = std::array<Spread, 2 * kReady + 1>;

  [[nodiscard]] Spread in_band(int normal, bool is_inner) const;
  [[nodiscard]] Spread below(int normal) const;
  void spread_in_band(const Nonzero& source);
  void spread_in_base(const Nonzero& source, const std::array<Surroundings, 3>& spread);
  void spread_from_inner(const Nonzero& source, const std::array<Surroundings, 3>& spread);
  void spread_from_half(const Nonzero& source, const Spread& spread);
  void spread_below(const Nonzero& source);
  [[nodiscard]] BitCounter& counter(const CounterTable& table, int index) {
    return counters_[table.begin + static_cast<std::size_t>(index)];
  }
  [[nodiscard]] int kind_of(std::uint32_t e) const {
    return place_.coarser == nullptr ? 0 : (e < inner_begin_ ? static_cast<int>(e & 1) : 2);
  }
  [[nodiscard]] int level() const { return place_.band < kLevels ? place_.band : kLevels - 1; }

  BandPlace place_;
  std::uint32_t inner_begin_ = 0;   ///< first edge that is not half of a coarser one
  std::int32_t ratio_ = 256;        ///< coarser step / step, in 1/256
  std::int32_t average_ = 512;      ///< recent magnitudes of band 0, in 1/256 steps
  std::array<Spreads, 2> in_band_;  ///< of details that are halves of edges; of inner ones
  Spreads below_;
  std::vector<Surroundings, ZeroedAllocator<Surroundings>> around_;  ///< per detail of the band
  std::vector<std::uint64_t> active_;
  std::vector<Nonzero> nonzero_, coarser_nonzero_;
  std::array<BitCounter, kCounters> counters_;
  Weights weights_;
};

}  // namespace nacre::entropy

#include "entropy/detail_contexts.h"  // the functions declared inline
