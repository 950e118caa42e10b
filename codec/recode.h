// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "codec/codec.h"

/// Coding without a search: with the steps that one has chosen, perhaps changed since.
namespace nacre::codec {

/// What a search decides, of profile best or paper.
struct StepChoice {
  Profile profile = Profile::kBest;
  wavelet::Transform transform = wavelet::Transform::kButterfly;
  /// Indices of the base's grid step and of each band's (2^(index / 32) model units); kNotCoded
  /// (band_coder.h) for a band that is left out.
  std::vector<int> steps;
  double theta_degrees = 1;                ///< paper
  double lambda = 0;                       ///< best: squared error that a bit is worth
  std::vector<std::vector<Vec3>> targets;  ///< best: as Encoded::targets
};

/// What encode() chose for this mesh. Errors   kUnsupportedVersion: another profile.
[[nodiscard]] Result<StepChoice> choice_of(const Encoded& encoded, const EncodeOptions& options);

/// Ensures  the bytes are those of encode(), given what choice_of() says of them.
/// Errors   kBadInput: the choice does not fit the mesh, or a step is out of range.
[[nodiscard]] Result<Encoded> encode_with_steps(const SemiRegularMesh& mesh,
                                                const StepChoice& choice);

}  // namespace nacre::codec
