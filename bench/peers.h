// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "base/result.h"
#include "bench/rate_curve.h"
#include "bench/remesh_cache.h"

/// What a user has without nacre: simplify, then Draco.
namespace nacre::bench {

struct PeerOptions {
  double min_bytes = 1000, max_bytes = 64000;
  std::size_t samples = 1'000'000;
  /// Keeps what was measured: peers never change. Empty: nothing is kept.
  std::filesystem::path folder;
};

/// One run of the peer.
struct PeerPoint {
  std::size_t triangles = 0;  ///< after simplification
  int position_bits = 0;      ///< draco_encoder -qp
  bool is_simplified = true;
  RatePoint point;
};

/// True if draco_encoder and draco_decoder are on the PATH.
[[nodiscard]] bool has_draco();

/// Edge collapse by [LindstromTurk1998] (CGAL, its defaults) to many sizes, a sixth apart, each
/// coded by Draco at its highest compression with several position precisions about the one that
/// errs as much as the simplification; and the scan itself at all precisions that come out small
/// enough. The points that no smaller one beats, 6 % apart, measured with `samples` each way.
///
/// Errors   those of reading; kBadInput where CGAL makes no mesh of the scan.
[[nodiscard]] Result<std::vector<PeerPoint>> simplify_and_draco(const PreparedScan& scan,
                                                                const PeerOptions& options);

}  // namespace nacre::bench
