// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/result.h"
#include "base/topology.h"
#include "entropy/adaptive_bit.h"
#include "entropy/arithmetic.h"

/// Quantised details ↔ bytes by variance classes: each component's scale is estimated from what is
/// decoded around it, and every class has statistics of its own. The comparator of profile eqmc;
/// see README.md.
namespace nacre::entropy {

/// (normal, across, along), in steps.
using EqPoint = std::array<std::int32_t, 3>;

inline constexpr std::int32_t kMaxEqMagnitude = 1 << 24;
/// Reconstruction offsets: of magnitudes 1, 2, and more.
inline constexpr int kLeastEqShrink = -8, kMostEqShrink = 7;

/// Where a band lies. Pointers stay the caller's.
struct EqPlace {
  const LevelTopology* level = nullptr;    ///< its details are those of this level's edges
  const LevelTopology* coarser = nullptr;  ///< the level below; none for band 0
  int band = 0;
};

/// The variance classes: what is known of a component before it is coded.
class EqModel {
 public:
  /// Statistics of one class; the classes of a tangential part are apart from the normal's.
  struct Class {
    AdaptiveBit nonzero;
    std::array<AdaptiveBit, 25> longer;      ///< bit length of the magnitude above i + 1
    std::array<AdaptiveBit, 25> upper_half;  ///< second bit of the magnitude, by length
    std::array<AdaptiveBit, 2> third_bit;    ///< of lengths above 2, by the second bit
  };

  EqModel();
  /// The band's components start as zeros; those of the band before become the coarser ones.
  void begin_band(const EqPlace& place);
  /// The class of component c of detail e; components c of details before e are known.
  [[nodiscard]] Class& look(std::uint32_t e, std::size_t c);
  void set(std::uint32_t e, std::size_t c, std::int32_t value);

 private:
  [[nodiscard]] std::uint32_t parent(std::uint32_t e) const;

  EqPlace place_;
  std::uint32_t inner_begin_ = 0;  ///< first edge that is not half of a coarser one
  std::array<std::vector<std::int32_t>, 3> magnitude_, coarser_;
  std::vector<Class> classes_;
};

struct EqBand {
  std::vector<EqPoint> points;
  std::array<int, 3> shrink_32nds{};
};

/// Decodes one band. An empty payload is a band of zeros. `model` goes from band to band.
///
/// Errors   kCorruptStream: any bytes that EqEncoder does not write.
[[nodiscard]] Result<EqBand> decode_eq_band(std::span<const std::uint8_t> payload,
                                            const EqPlace& place, EqModel& model);

/// Encoder. All details' normal components, then all their parts across, then those along.
class EqEncoder {
 public:
  EqEncoder(EqModel& model, const EqPlace& place) : model_(model) { model_.begin_band(place); }

  [[nodiscard]] EqModel::Class& look(std::uint32_t e, std::size_t c) { return model_.look(e, c); }
  /// Bits that a value would take in a class, in 1/4096 of a bit.
  [[nodiscard]] static std::uint64_t cost(const EqModel::Class& statistics, std::int32_t value);
  void put(EqModel::Class& statistics, std::uint32_t e, std::size_t c, std::int32_t value);
  [[nodiscard]] std::vector<std::uint8_t> finish(const std::array<int, 3>& shrink_32nds);

 private:
  EqModel& model_;
  ArithmeticEncoder coder_;
};

}  // namespace nacre::entropy
