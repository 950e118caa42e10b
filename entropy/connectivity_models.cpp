// SPDX-License-Identifier: Apache-2.0
#include "entropy/connectivity_models.h"

namespace nacre::entropy {
namespace {

// Initial frequencies. The two valence tables are twice the rounded shares, in thousandths and
// halved, of the valences met in CGAL edge-collapse (Garland-Heckbert) simplifications of bunny,
// mask, laurana, fandisk, conrod, doll_face, maneki_neko and rangemap to 50 .. 1000 vertices.
// Horse, venus, igea, elephant and rockerarm were left out, to measure on. They weigh as much as 60
// observations; more, or faster adaptation, measured worse.
constexpr std::uint32_t kIncrement = 16;
constexpr std::uint16_t kValences[kValenceSymbols] = {16, 80, 254, 336, 196, 74, 24,
                                                      8,  4,  2,   2,   2,   4};
// A boundary vertex counts the edge to its dummy, too.
constexpr std::uint16_t kBoundaryValences[kValenceSymbols] = {226, 268, 248, 140, 62, 30, 12,
                                                              6,   6,   2,   2,   2,  2};
constexpr std::uint16_t kJoins[] = {300, 2};
constexpr std::uint16_t kDummies[] = {300, 16};
constexpr std::uint16_t kComponents[] = {40, 30, 10};

}  // namespace

ConnectivityModels::ConnectivityModels()
    : component(kComponents, 32),
      loops(32),
      dummy(32),
      large(32),
      is_dummy(kDummies, kIncrement),
      joins(kJoins, kIncrement),
      valence(kValences, kIncrement),
      boundary(kBoundaryValences, kIncrement) {}

}  // namespace nacre::entropy
