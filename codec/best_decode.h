// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/topology.h"
#include "codec/stream_reader.h"
#include "entropy/detail_coder.h"
#include "wavelet/wavelet.h"

namespace nacre::codec {

/// The details of a band of profile best from its payload; section 16 of the document. Bands are
/// decoded in order with the same `model`.
///
/// Errors   kCorruptStream; `where` is the section's offset.
[[nodiscard]] Result<wavelet::SparseBand> decode_best_band(std::span<const std::uint8_t> payload,
                                                           const StreamLayout& layout,
                                                           const Topology& topology, int band,
                                                           entropy::DetailModel& model);

/// Quantised details as the decoder reconstructs them.
[[nodiscard]] wavelet::SparseBand reconstruct(const entropy::DetailBand& band, double step);

}  // namespace nacre::codec
