// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <vector>

#include "codec/decode.h"
#include "codec/stream_reader.h"
#include "entropy/estimation_quantisation.h"
#include "entropy/zerotree.h"

/// How details of profiles nmc and eqmc are made again from their integers, for the decoder and for
/// the encoder, which looks at what it has made. No part of the decoding half.
namespace nacre::codec {

/// DecodeOptions::comparators.
///
/// Errors   kCorruptStream, kLimitExceeded; kBadInput for other profiles.
[[nodiscard]] Result<std::vector<std::vector<Vec3>>> decode_comparator_bands(
    std::span<const std::uint8_t> bytes, const StreamLayout& layout, const Topology& topology,
    int levels, std::uint64_t max_vertices);

/// Steps of nmc's bands as indices: those of the finest band less this, for `levels_above` finer
/// bands: 16 log2 of the butterfly's gain on the regular lattice, rounded.
[[nodiscard]] int zerotree_step_offset(int levels_above);

/// Quantiser parameters of nmc, the first two bytes of its payload.
struct ZerotreeInfo {
  /// Where a magnitude is taken to lie in the range left open, (8 + it) / 32 of it: of magnitudes
  /// known to their first bit only, and of others. 0 .. 15.
  std::array<int, 2> centres = {8, 8};
  int ratio_quarters = 0;  ///< tangential step / step = 1 + it / 4; 0 .. 63
};

/// Details of all bands; `finest_step_index` is the finest band's.
[[nodiscard]] std::vector<std::vector<Vec3>> zerotree_details(const entropy::ZerotreeBands& bands,
                                                              const ZerotreeInfo& info,
                                                              int finest_step_index);

/// Details of one band of eqmc.
[[nodiscard]] std::vector<Vec3> eq_details(const entropy::EqBand& band, int step_index,
                                           int ratio_quarters);

}  // namespace nacre::codec
