// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "app/options.h"

/// What a file shall be, and what that asks of the mesh before anything is coded.
namespace nacre::app {

/// The largest error is usually about so many times the root mean square.
inline constexpr double kUsualMaximumPerRms = 20;

/// "--size 6000", "--psnr 75": the option that asks for it.
[[nodiscard]] std::string option_of(const Goal& goal);
/// "size", "psnr", ...: for scripts.
[[nodiscard]] std::string_view name_of(Goal::Kind kind);

/// What qualities mean: the step that an error on the finest mesh is quantised with, as a share of
/// the bounding box diagonal. It halves every 12.5 points, from 2^-4 at 0 to 2^-12 at 100.
[[nodiscard]] double step_of_quality(double quality);
/// What profile best usually makes of steps (bench/quality_table): PSNR and bytes of the whole
/// file; and the step for a PSNR.
[[nodiscard]] double usual_psnr_db(double relative_step);
[[nodiscard]] double usual_bytes(double relative_step);
[[nodiscard]] double usual_step(double psnr_db);

/// The maximum error that a goal on it allows, model units.
[[nodiscard]] double allowed_error(const Goal& goal, double bbox_diagonal);

/// Size of the file that a goal leads to: known, or what is usual.
[[nodiscard]] double expected_bytes(const Goal& goal, std::size_t input_vertices,
                                    double bbox_diagonal);

/// The mesh for a file of about this size: a base of 3.6 sqrt(bytes) vertices up to 480, more if
/// the shape asks for it and a fifth of the file can pay for it; 33 triangles for a byte on its
/// finest level. Settings that the user made stay. (docs/decisions/0009-base-and-levels-by-rate.md)
[[nodiscard]] RemeshSettings for_size(RemeshSettings settings, double bytes,
                                      std::size_t input_vertices);

}  // namespace nacre::app
