// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "codec/codec.h"
#include "codec/geometry_coder.h"

namespace nacre::codec {

/// encode() with Profile::kEqmc, for checked arguments: variance classes, each with its
/// rate-distortion-optimal quantiser, at the finest common step that fits the size.
[[nodiscard]] Result<Encoded> encode_eqmc(const SemiRegularMesh& mesh, const EncodeOptions& options,
                                          const RunContext& context, const Prepared& prepared);

}  // namespace nacre::codec
