// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/rate_curve.h"
#include "bench/remesh_cache.h"
#include "codec/codec.h"

/// nacre's own points on a rate-distortion curve.
namespace nacre::bench {

/// One profile at one size: decoded from its bytes and measured against the raw scan.
struct CodedPoint {
  codec::Profile profile = codec::Profile::kBest;
  std::size_t target_bytes = 0;
  std::optional<Error> error;
  RatePoint point;
  codec::EncodeReport report;
};

/// Every profile at every size; in parallel, in order of profile, then size. `meshes`: one for each
/// size; none: the scan's own for all.
[[nodiscard]] std::vector<CodedPoint> code_points(const PreparedScan& scan,
                                                  const std::vector<codec::Profile>& profiles,
                                                  const std::vector<std::size_t>& sizes,
                                                  std::size_t samples,
                                                  const std::vector<SemiRegularMesh>& meshes = {});

/// Profile best at every size as `nacre encode --size` has it, with whatever mesh it takes.
[[nodiscard]] std::vector<CodedPoint> command_points(const PreparedScan& scan,
                                                     const std::string& file,
                                                     const std::string& nacre,
                                                     const std::vector<std::size_t>& sizes,
                                                     std::size_t samples);

/// The points of one profile without errors.
[[nodiscard]] std::vector<RatePoint> curve_of(const std::vector<CodedPoint>& points,
                                              codec::Profile profile);

/// Writes text to a file, or says on stderr why not.
void write_text(const std::filesystem::path& file, const std::string& text);

}  // namespace nacre::bench
