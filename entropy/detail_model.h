// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/topology.h"
#include "entropy/binary_model.h"

/// What is known about a detail before it is coded: contexts from its band's earlier details and
/// from the coarser band. Decoder and encoder share it; docs/FORMAT.md states every rule.
namespace nacre::entropy {

/// A quantised detail: (normal, across, along), in steps.
using DetailPoint = std::array<std::int32_t, 3>;

inline constexpr std::int32_t kMaxDetail = 1 << 24;  ///< of a component, in magnitude

/// Magnitudes in classes, two to an octave: 1, 2, 3, 4, 5-6, 7-8, 9-12, 13-16, 17-24, ...
[[nodiscard]] int magnitude_class(std::int32_t magnitude);  ///< magnitude in 1 .. kMaxDetail
[[nodiscard]] std::int32_t least_of_class(int magnitude_class);
[[nodiscard]] int raw_bits_of_class(int magnitude_class);
inline constexpr int kMagnitudeClasses = 48;

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

/// Neighbourhood of one detail, reduced to small numbers.
struct DetailContext {
  std::uint32_t detail = 0;
  bool is_quiet = true;  ///< nothing but zeros around
  bool is_faint = true;  ///< nothing but zeros in the first ring and at the parents
  int kind = 0;          ///< 0, 1: first, second half of a coarser edge; 2: edge inside a triangle
  int expected = 0;      ///< magnitude expected from all, 1/256 steps
  int mean = 0;          ///< value expected, 1/256 steps
  int expected_bin = 0, inherited_bin = 0, parent_bin = 0;
  int near = 0, far = 0, beside = 0, beyond = 0;  ///< small numbers for sums of magnitudes
  int first = 0;                                  ///< the same for near and beside together
  std::array<std::int8_t, 6> signs{};             ///< sums of small values by group
  int tangential = 0;                             ///< tangential magnitudes around, up to 255
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
  [[nodiscard]] DetailContext look(std::uint32_t e) const;
  /// Every detail of band 0, in order; of other bands those that are not zero.
  void set(std::uint32_t e, const DetailPoint& point);

  /// Whether details of a block that are quiet may be other than zero.
  [[nodiscard]] MixedBit quiet_may_rise(bool has_active);
  /// Whether a block's details may have tangential parts.
  [[nodiscard]] MixedBit block_has_tangential(bool last_block_has);
  [[nodiscard]] MixedBit is_nonzero(const DetailContext& context);
  [[nodiscard]] MixedBit is_negative(const DetailContext& context);
  /// Whether the magnitude's class is above `magnitude_class`, given that it is not below.
  [[nodiscard]] MixedBit is_above(const DetailContext& context, bool negative, int magnitude_class);

  /// All counters in the order of the format: for learning their starts.
  [[nodiscard]] std::span<const BitCounter> counters() const { return counters_; }

  [[nodiscard]] MixedBit has_tangential(const DetailContext& context, bool normal_is_zero);
  /// Component 0: across, 1: along.
  [[nodiscard]] MixedBit tangential_is_nonzero(const DetailContext& context, int component);
  [[nodiscard]] MixedBit tangential_is_negative(const DetailContext& context, int component);
  [[nodiscard]] MixedBit tangential_is_above(const DetailContext& context, int component,
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

  /// What non-zero details around one detail have left at it.
  struct Around {
    std::int32_t band = 0;     ///< magnitude expected from its own band, 1/256 steps
    std::int32_t below = 0;    ///< from the coarser band, 1/4096 steps; in band 0: weight known
    std::int32_t mean = 0;     ///< value expected, 1/4096 steps
    std::uint16_t parent = 0;  ///< magnitudes, twice a half's parent
    std::array<std::uint8_t, 4> few{};   ///< magnitudes by group, each up to 15
    std::array<std::int8_t, 6> signs{};  ///< values by group, each up to ±10
    std::uint8_t tangential = 0;
  };
  struct Nonzero {
    std::uint32_t detail = 0;
    std::int16_t normal = 0;  // clamped
    std::uint8_t tangential = 0;
  };

  void spread_in_band(const Nonzero& source);
  void add_in_band(const Nonzero& source, std::uint32_t target, int ring);
  void spread_below(const Nonzero& source);
  void add_below(const Nonzero& source, std::uint32_t target, int role);
  [[nodiscard]] BitCounter& counter(const CounterTable& table, int index) {
    return counters_[table.begin + static_cast<std::size_t>(index)];
  }
  [[nodiscard]] int kind_of(std::uint32_t e) const {
    return place_.coarser == nullptr ? 0 : (e < inner_begin_ ? static_cast<int>(e & 1) : 2);
  }
  [[nodiscard]] int level() const { return place_.band < kLevels ? place_.band : kLevels - 1; }

  BandPlace place_;
  std::uint32_t inner_begin_ = 0;  ///< first edge that is not half of a coarser one
  std::int32_t ratio_ = 256;       ///< coarser step / step, in 1/256
  std::array<std::array<std::int32_t, 3>, 3> inherited_weights_{}, inherited_value_weights_{};
  std::int32_t average_ = 512;  ///< recent magnitudes of band 0, in 1/256 steps
  std::vector<Around> around_;  ///< per detail of the band
  std::vector<std::uint64_t> active_;
  std::vector<Nonzero> nonzero_, coarser_nonzero_;
  std::array<BitCounter, kCounters> counters_;
  Weights weights_;
};

}  // namespace nacre::entropy
