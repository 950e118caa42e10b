// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "codec/codec.h"
#include "codec/geometry_coder.h"

namespace nacre::codec {

/// What the steps of the base and the bands are shared out by; see the top of best_encode.cpp.
[[nodiscard]] std::vector<double> best_gains(const Prepared& prepared);

/// encode() with Profile::kBest, for checked arguments.
[[nodiscard]] Result<Encoded> encode_best(const SemiRegularMesh& mesh, const EncodeOptions& options,
                                          const RunContext& context, const Prepared& prepared);

}  // namespace nacre::codec
