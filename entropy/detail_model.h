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

/// Statistics of all bands so far, and what is known of this band.
class DetailModel {
 public:
  DetailModel();

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

  [[nodiscard]] MixedBit has_tangential(const DetailContext& context, bool normal_is_zero);
  /// Component 0: across, 1: along.
  [[nodiscard]] MixedBit tangential_is_nonzero(const DetailContext& context, int component);
  [[nodiscard]] MixedBit tangential_is_negative(const DetailContext& context, int component);
  [[nodiscard]] MixedBit tangential_is_above(const DetailContext& context, int component,
                                             int magnitude_class);

 private:
  static constexpr int kLevels = 8;  // bands that are told apart

  /// All counters and weights; flat, so that a model is copied in one go.
  struct Statistics {
    std::array<BitCounter, 2 * kLevels> rise, block_tangential;
    std::array<BitCounter, 3 * kLevels> quiet;
    std::array<BitCounter, 96 * kLevels> faint;
    std::array<BitCounter, 96> zero0;
    std::array<BitCounter, 512> zero1;
    std::array<BitCounter, 432> zero2, zero3;
    std::array<BitCounter, 288> zero4;
    std::array<BitCounter, 576> zero5;
    std::array<BitCounter, 768> zero6, sign1;
    std::array<BitCounter, 96> sign0;
    std::array<BitCounter, 375> sign2;
    std::array<BitCounter, 243> sign3;
    std::array<BitCounter, 128> above0;
    std::array<BitCounter, 960> above1;
    std::array<BitCounter, 480> above2;
    std::array<BitCounter, 576> above3;
    std::array<BitCounter, 2160> above4;
    std::array<BitCounter, 4096> above5;
    std::array<BitCounter, 48> tangential0;
    std::array<BitCounter, 64> tangential1;
    std::array<BitCounter, 32> tangential2;
    std::array<BitCounter, 16> tangential_zero0;
    std::array<BitCounter, 12> tangential_zero1;
    std::array<BitCounter, 4> tangential_sign;
    std::array<BitCounter, 2 * kMagnitudeClasses> tangential_above0;
    std::array<BitCounter, 8 * kMagnitudeClasses> tangential_above1;
    std::array<MixerWeights, 48> zero_weights;
    std::array<MixerWeights, 3> sign_weights;
    std::array<MixerWeights, 4> above_weights;
    std::array<MixerWeights, 2> tangential_weights;
    MixerWeights tangential_zero_weights, tangential_above_weights;
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
  Statistics statistics_;
};

}  // namespace nacre::entropy
