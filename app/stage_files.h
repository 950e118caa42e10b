// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <vector>

#include "app/stage.h"
#include "codec/recode.h"
#include "codec/symbols.h"
#include "remesh/remesh.h"

/// The values of a run ↔ the payloads of its stages. Arrays are exact (.npy); a PLY beside them can
/// be edited instead: where the arrays are as written and the PLY is not, its vertices count, but
/// those that it has where it was written keep the arrays' digits.
namespace nacre::app {

/// What later stages report of earlier ones.
struct StageFacts {
  remesh::CleanReport clean;
  std::vector<remesh::BandReport> bands;
  std::vector<remesh::PieceReport> pieces;
  int levels = 0;
  bool is_kept = false;  ///< see remesh::MappedScan
  wavelet::Transform transform = wavelet::Transform::kButterfly;  ///< of the coefficients
};
[[nodiscard]] std::string to_text(const StageFacts& facts);
/// What is missing or of the wrong kind stays as it is by default.
[[nodiscard]] StageFacts facts_from(const std::string& text);

/// positions.npy, triangles.npy, origin.npy
[[nodiscard]] StageFiles files_of(const Scan& scan);
[[nodiscard]] StageFiles files_of(const remesh::CleanScan& cleaned);
[[nodiscard]] StageFiles base_files_of(const Scan& scan, const remesh::BaseMesh& base);
[[nodiscard]] StageFiles files_of(const Scan& scan, const remesh::Parameterisation& map);
[[nodiscard]] StageFiles files_of(const SemiRegularMesh& mesh);
/// With band-0.npy and so on, details as wavelet::analyze() has them in the mesh's own numbering.
[[nodiscard]] Result<StageFiles> coefficient_files_of(const SemiRegularMesh& mesh,
                                                      wavelet::Transform transform);
/// band-0.npy and so on: bits per vertex, distortion, step of each sample.
[[nodiscard]] StageFiles files_of(const codec::EncodeReport& report);
[[nodiscard]] StageFiles files_of(const codec::StepChoice& choice);
/// header.bin states what the other files do not.
[[nodiscard]] StageFiles symbol_files_of(const codec::StreamSymbols& symbols,
                                         std::span<const std::uint8_t> stream);

/// Errors of all: kUnreadableFile, a file that is missing or is not what it should be;
///          kGeometryRefused, values that do not fit together.
[[nodiscard]] Result<Scan> scan_from(const StageFolder& stage);
/// An edited one is cleaned once more. Errors   also those of remesh::clean().
[[nodiscard]] Result<remesh::CleanScan> clean_from(const StageFolder& stage,
                                                   const remesh::RepairPolicy& policy);
[[nodiscard]] Result<remesh::MappedScan> mapped_from(const StageFolder& stage);
/// Base vertices that were moved in 03-base move in the map to the nearest point of the scan.
[[nodiscard]] Result<void> move_base(const StageFolder& stage, remesh::MappedScan& mapped);
/// Of 05-normal-mesh and 06-coefficients.
[[nodiscard]] Result<SemiRegularMesh> mesh_from(const StageFolder& stage);
[[nodiscard]] Result<codec::StepChoice> choice_from(const StageFolder& stage);
[[nodiscard]] Result<codec::StreamSymbols> symbols_from(const StageFolder& stage);

}  // namespace nacre::app
