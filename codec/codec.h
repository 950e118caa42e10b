// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "alloc/alloc.h"
#include "base/run_context.h"
#include "base/semi_regular_mesh.h"
#include "codec/decode.h"

/// Semi-regular mesh ↔ bytes: the stages put together, and the container. See README.md and
/// docs/FORMAT.md.
namespace nacre::codec {

/// How long profile best may search.
enum class Effort : std::uint8_t {
  kNormal,
  kFast,  ///< in half the time or less, for a few per cent more bytes
};

struct EncodeOptions {
  Profile profile = Profile::kPaper;
  wavelet::Transform transform = wavelet::Transform::kButterfly;
  /// The whole file's size, never exceeded. This or `step` is required.
  std::size_t target_bytes = 0;
  /// The quality instead of the size: what an error on the finest mesh is quantised with, model
  /// units. Profile best only. Steps beyond what the mesh can make use of count as the last that
  /// does.
  double step = 0;
  double theta_degrees = 1.0;
  /// Bits per base coordinate, 6 .. 20; 0: chosen with the rate.
  int base_bits = 0;
  Effort effort = Effort::kNormal;
  /// Where the vertices would better be, one for each, relative to the mesh's origin; none: where
  /// they are. Profile best only, butterfly only. Must outlive the call.
  std::span<const Vec3> aims = {};
};

struct BandReport {
  std::size_t vertices = 0;
  double gain = 0;                  ///< E_i
  double step = 0;                  ///< model units; 0 where the band is not coded
  double bits = 0;                  ///< of the band's section, whole
  double normal_only_fraction = 0;  ///< of the quantised details
  double distortion = 0;            ///< measured mean squared error per vertex of the band
  std::vector<alloc::Sample> samples;
};

struct EncodeReport {
  std::size_t bytes = 0, bytes_header = 0, bytes_base = 0;
  std::size_t bytes_base_connectivity = 0, bytes_base_positions = 0;
  int base_bits = 0;
  int levels = 0;  ///< as coded
  std::vector<BandReport> bands;
  double lambda = 0;
  double predicted_distortion = 0;  ///< Σ w_i D_i, mean squared error per finest vertex
  double measured_distortion = 0;   ///< the same on the decoded semi-regular mesh
};

struct Encoded {
  std::vector<std::uint8_t> bytes;
  EncodeReport report;
  /// Of profile best: what each level aimed at, in the decoder's numbering (see best_targets.h);
  /// empty: the mesh itself.
  std::vector<std::vector<Vec3>> targets;
};

/// Errors   kGoalUnreachable when target_bytes cannot hold even the base mesh (the message names
///          the smallest possible size); kBadInput.
[[nodiscard]] Result<Encoded> encode(const SemiRegularMesh& mesh, const EncodeOptions& options,
                                     const RunContext& context = {});

}  // namespace nacre::codec
