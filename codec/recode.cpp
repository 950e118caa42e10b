// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/recode.h"

#include <cmath>
#include <limits>
#include <new>
#include <numbers>
#include <optional>
#include <string>

#include "codec/assemble.h"
#include "codec/best_coder.h"
#include "codec/best_encode.h"
#include "codec/best_targets.h"
#include "codec/stream_reader.h"

namespace nacre::codec {
namespace {

Error bad(const std::string& what, std::size_t where = 0) {
  return {ErrorCode::kBadInput, what, where};
}

bool is_possible(Profile profile) {
  return profile == Profile::kBest || profile == Profile::kPaper;
}

Result<void> check_targets(const Prepared& prepared, const StepChoice& choice) {
  if (choice.targets.empty()) return {};
  const int levels = prepared.topology.level_count();
  if (choice.targets.size() != static_cast<std::size_t>(levels) + 1)
    return bad("a level has no target");
  for (int j = 0; j <= levels; ++j) {
    const auto& targets = choice.targets[static_cast<std::size_t>(j)];
    const std::size_t count =
        j == 0 ? prepared.topology.level(0).vertex_count : prepared.topology.band_size(j - 1);
    const auto where = static_cast<std::size_t>(j);
    const std::string level = "level " + std::to_string(j);
    if (targets.size() != count)
      return bad(level + " needs a target per vertex, " + std::to_string(count), where);
    for (const Vec3& p : targets)
      if (!p.allFinite()) return bad("a target of " + level + " is not finite", where);
  }
  return {};
}

/// Whether the base that is coded, the mesh's or the first target, has a place on its grid.
Result<void> check_base(const Prepared& prepared, const StepChoice& choice) {
  const auto& base =
      choice.targets.empty() ? prepared.pyramid.base_positions : choice.targets.front();
  const double most = static_cast<double>(kMaxGridCorner) * step_size(choice.steps[0]);
  for (std::size_t v = 0; v < base.size(); ++v)
    if (base[v].cwiseAbs().maxCoeff() > most)
      return bad("the base's step is too fine for its coordinates", v);
  const int bits = grid_bits_at(base, choice.steps[0]);
  if (bits <= kMaxGridBits) return {};
  return bad("the base's step asks for " + std::to_string(bits) + " bits per coordinate, " +
             std::to_string(kMaxGridBits) + " are possible");
}

Result<void> check(const Prepared& prepared, const StepChoice& choice) {
  const auto levels = static_cast<std::size_t>(prepared.topology.level_count());
  if (!is_possible(choice.profile)) return bad("steps can be given to profiles best and paper");
  if (choice.steps.size() != levels + 1)
    return bad("a mesh of " + std::to_string(levels) + " levels needs " +
               std::to_string(levels + 1) + " steps, " + std::to_string(choice.steps.size()) +
               " are there");
  for (std::size_t i = 0; i < choice.steps.size(); ++i) {
    const int step = choice.steps[i];
    if (i > 0 && step == kNotCoded) continue;
    if (step < -kMaxStepIndex || step > kMaxStepIndex)
      return bad("the index of step " + std::to_string(i) + " must lie in -6400 .. 6400", i);
  }
  if (!(choice.lambda >= 0) || !std::isfinite(choice.lambda)) return bad("lambda is no number");
  if (!(choice.theta_degrees >= 0) || choice.theta_degrees > 90)
    return bad("the cone's angle must lie in 0 .. 90 degrees");
  if (const auto ok = check_targets(prepared, choice); !ok) return ok;
  return check_base(prepared, choice);
}

Result<CodedGeometry> code(const Prepared& prepared, const StepChoice& choice) {
  if (choice.profile == Profile::kPaper) {
    BandCoderOptions options;
    options.theta_rad = choice.theta_degrees * (std::numbers::pi / 180);
    return code_geometry(prepared, choice.steps, options);
  }
  std::optional<SurfaceWeights> weights;
  if (choice.transform == wavelet::Transform::kButterfly) weights = surface_weights(prepared);
  BestSettings settings;
  settings.steps = choice.steps;
  settings.lambda = choice.lambda;
  if (weights) settings.weights = &*weights;
  if (weights && !choice.targets.empty()) {
    settings.targets = &choice.targets;
    weights->normals = target_normals(prepared.topology, choice.targets);
  }
  return code_best(prepared, settings, best_gains(prepared));
}

}  // namespace

Result<StepChoice> choice_of(const Encoded& encoded, const EncodeOptions& options) {
  const auto layout = read_layout(encoded.bytes);
  if (!layout) return layout.error();
  const Header& header = layout->header;
  if (!is_possible(header.profile))
    return Error{ErrorCode::kUnsupportedVersion,
                 "profile " + std::string(profile_name(header.profile)) +
                     " has no steps that could be given back; best and paper have",
                 0};
  StepChoice choice;
  choice.profile = header.profile;
  choice.transform = header.transform;
  choice.theta_degrees = options.theta_degrees;
  choice.steps = {header.grid_step_index};
  for (int j = 0; j < header.levels; ++j) {
    const auto band = static_cast<std::size_t>(j);
    const bool is_coded = band < header.bands.size() && header.bands[band].payload_bytes > 0;
    choice.steps.push_back(is_coded ? header.bands[band].step_index : kNotCoded);
  }
  if (header.profile == Profile::kBest) choice.lambda = -encoded.report.lambda;
  choice.targets = encoded.targets;
  return choice;
}

Result<Encoded> encode_with_steps(const SemiRegularMesh& mesh, const StepChoice& choice) {
  try {
    const auto prepared = prepare(mesh, choice.transform);
    if (!prepared) return prepared.error();
    if (const auto ok = check(*prepared, choice); !ok) return ok.error();
    const auto coded = code(*prepared, choice);
    if (!coded) return coded.error();
    auto bytes = assemble(*prepared, *coded, choice.profile, mesh.origin);
    EncodeReport report = describe(*prepared, *coded, bytes.size());
    report.lambda = -choice.lambda;
    report.predicted_distortion = coded->error;
    auto encoded = verified(*prepared, std::move(report), std::move(bytes));
    if (encoded) encoded->targets = choice.targets;
    return encoded;
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kLimitExceeded, "not enough memory to encode the mesh", 0};
  }
}

}  // namespace nacre::codec
