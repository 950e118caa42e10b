// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "base/semi_regular_mesh.h"
#include "codec/band_coder.h"
#include "codec/rate_control.h"
#include "entropy/connectivity.h"
#include "wavelet/wavelet.h"

/// A whole mesh at one choice of steps. Details are taken open loop, from the mesh as it was, but
/// written in the frames that the decoder will have: see README.md.
namespace nacre::codec {

/// The mesh in the numbering of its decoder, and what its levels add.
struct Prepared {
  entropy::EncodedConnectivity connectivity;
  Topology topology;
  std::vector<Vec3> positions;
  wavelet::Transform transform = wavelet::Transform::kButterfly;
  Pyramid pyramid;  ///< details in the frames of the undistorted mesh
  /// Details as vectors of model space, per band; empty for a transform whose frames the encoder
  /// cannot follow (Loop): its details stay as the pyramid has them.
  std::vector<std::vector<Vec3>> vectors;
  std::vector<Vec3> aims;  ///< EncodeOptions::aims in the decoder's numbering, or empty

  /// The finest mesh as it should be.
  [[nodiscard]] const std::vector<Vec3>& surface() const { return aims.empty() ? positions : aims; }
};

/// Renumbers the mesh and takes its wavelet transform.
///
/// Errors   kBadInput, kLimitExceeded, kNoConvergence: those of the stages.
/// Every vertex that a band adds, less its butterfly prediction; of each band.
[[nodiscard]] std::vector<std::vector<Vec3>> detail_vectors(const Topology& topology,
                                                            std::span<const Vec3> positions);

[[nodiscard]] Result<Prepared> prepare(const SemiRegularMesh& mesh, wavelet::Transform transform,
                                       std::span<const Vec3> aims = {});

/// The geometry at one choice of steps: what is written and what the decoder will see.
struct CodedGeometry {
  Steps steps;
  CodedBase base;
  std::vector<CodedBand> bands;
  // Of profile paper, per band: as given to its quantiser, and as the decoder will have them.
  std::vector<std::vector<Vec3>> details;
  std::vector<std::vector<Frame>> frames;
  double error = 0;           ///< mean squared error per finest vertex of the decoded mesh
  std::vector<Vec3> decoded;  ///< of profile best: the decoded mesh
};

/// Codes level by level, each band in the frames of the decoded coarser mesh.
[[nodiscard]] Result<CodedGeometry> code_geometry(const Prepared& prepared, const Steps& steps,
                                                  const BandCoderOptions& options);

/// Squared error on the finest mesh per squared error in each part (the base, then the bands), for
/// the very errors of this coding: each part's alone is carried to the finest level, and the gains
/// are scaled so that all together account for `coded.error`. Parts without error keep `gains`.
[[nodiscard]] std::vector<double> gains_of_errors(const Prepared& prepared,
                                                  const CodedGeometry& coded,
                                                  std::vector<double> gains);

}  // namespace nacre::codec
