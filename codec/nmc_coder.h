// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "codec/codec.h"
#include "codec/geometry_coder.h"

namespace nacre::codec {

/// encode() with Profile::kNmc, for checked arguments: zerotrees of bit planes, cut at the size
/// asked for.
[[nodiscard]] Result<Encoded> encode_nmc(const SemiRegularMesh& mesh, const EncodeOptions& options,
                                         const RunContext& context, const Prepared& prepared);

}  // namespace nacre::codec
