// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "entropy/arithmetic.h"

namespace nacre::entropy {

/// Valences with a symbol of their own: kFirstValence and on; the last symbol is an escape.
inline constexpr std::uint32_t kFirstValence = 3;
inline constexpr std::uint32_t kValenceSymbols = 13;
/// No valence an encoder writes is larger: half-edges fit in 32 bits.
inline constexpr std::uint32_t kMaxValence = 1u << 30;

enum ComponentKind : int { kNoComponent = 0, kClosedComponent = 1, kOpenComponent = 2 };

/// Adaptive models of a coded connectivity, as they stand before the first symbol.
struct ConnectivityModels {
  ConnectivityModels();

  AdaptiveModel component;  ///< ComponentKind
  AdaptiveModel loops;      ///< boundary loops of an open component, less one
  AdaptiveModel dummy;      ///< valences of dummies
  AdaptiveModel large;      ///< escaped valences
  AdaptiveModel is_dummy;   ///< asked of a new vertex while dummies are left
  AdaptiveModel joins;      ///< asked where a join is possible
  AdaptiveModel valence;
  AdaptiveModel boundary;  ///< valences of vertices found from a dummy
};

}  // namespace nacre::entropy
