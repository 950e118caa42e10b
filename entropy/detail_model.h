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

/// Neighbourhood of one detail, reduced to small numbers.
struct DetailContext {
  std::uint32_t detail = 0;
  int kind = 0;          ///< 0, 1: first, second half of a coarser edge; 2: edge inside a triangle
  bool is_quiet = true;  ///< nothing but zeros around
  bool is_boundary = false;
  int near = 0, far = 0, beside = 0;      ///< sums of magnitudes: first ring's, second's, the rest
  int parent = 0, uncle = 0, cousin = 0;  ///< magnitudes around in the coarser band, 1/256 steps
  int inherited = 0;                      ///< what they lead to expect, 1/256 steps
  int expected = 0;                       ///< magnitude expected from all, 1/256 steps
  int mean = 0;                           ///< value expected, 1/256 steps
  std::array<int, 7> sums{};  ///< signed: near, far, beside, far beside, parent, uncle, cousin
  int tangential = 0;         ///< tangential magnitudes around
};

/// Statistics of all bands so far, and the details of this band so far and of the last one.
class DetailModel {
 public:
  DetailModel();

  /// The band's details start as zeros, and are so if none is set; those of the band before become
  /// the coarser ones.
  void begin_band(const BandPlace& place);

  /// Context of detail e; details 0 .. e-1 are known.
  [[nodiscard]] DetailContext look(std::uint32_t e) const;
  void set(std::uint32_t e, const DetailPoint& point);

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
  /// Counters of one kind of bit, by context; and the weights of the contexts.
  struct BitKind {
    std::vector<std::vector<BitCounter>> tables;
    std::vector<MixerWeights> mixers;
  };
  struct Ring;

  static BitKind make_kind(std::initializer_list<std::size_t> table_sizes, std::size_t mixers);
  void look_in_band(std::uint32_t e, Ring& ring) const;
  void look_below(std::uint32_t e, DetailContext& context) const;

  BandPlace place_;
  std::uint32_t inner_begin_ = 0;  ///< first edge that is not half of a coarser one
  std::int64_t ratio_ = 256;       ///< coarser step / step, in 1/256
  std::int32_t average_ = 512;     ///< recent magnitudes, in 1/256 steps
  // Magnitudes are clamped to kLargestSeen here.
  std::vector<std::int32_t> normal_, coarser_normal_, tangential_, coarser_tangential_;
  std::vector<BitCounter> quiet_;
  BitKind zero_, sign_, magnitude_, tangential_flag_, tangential_zero_, tangential_sign_,
      tangential_magnitude_;
};

}  // namespace nacre::entropy
