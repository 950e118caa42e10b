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

/// The details of the first `levels` bands of a stream of profile best; section 16 of the document.
///
/// Errors   kCorruptStream; `where` is the section's offset.
[[nodiscard]] Result<std::vector<wavelet::SparseBand>> decode_best_bands(
    std::span<const std::uint8_t> bytes, const StreamLayout& layout, const Topology& topology,
    int levels);

/// Quantised details as the decoder reconstructs them.
[[nodiscard]] wavelet::SparseBand reconstruct(const entropy::DetailBand& band, double step);

}  // namespace nacre::codec
