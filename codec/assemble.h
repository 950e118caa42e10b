// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "codec/codec.h"
#include "codec/geometry_coder.h"

/// From coded parts to the file, and what can be said of them; for every profile.
namespace nacre::codec {

inline constexpr int kMinBaseBits = 6, kMaxBaseBits = 20;

[[nodiscard]] std::vector<std::uint8_t> assemble(const Prepared& prepared,
                                                 const CodedGeometry& coded, Profile profile,
                                                 const Vec3& origin);

/// A file of these bytes is the smallest there is, and too large.
[[nodiscard]] Error base_too_large(std::size_t smallest_bytes, std::size_t target_bytes);

[[nodiscard]] Error encoding_cancelled();

/// Decodes what was coded and puts the measured distortion into the report: what a decoder has is
/// what is told.
[[nodiscard]] Result<Encoded> verified(const Prepared& prepared, EncodeReport report,
                                       std::vector<std::uint8_t> bytes);

/// All of a report but what only the search knows: gains, samples, slope, prediction.
[[nodiscard]] EncodeReport describe(const Prepared& prepared, const CodedGeometry& coded,
                                    std::size_t file_bytes);

}  // namespace nacre::codec
