// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "app/picture.h"
#include "codec/codec.h"
#include "remesh/remesh.h"

/// What a command line asks for, as plain values: cli.h makes them, the verbs take them.
namespace nacre::app {

enum class Verbosity : std::uint8_t { kQuiet, kNormal, kVerbose };

/// Options that every verb has.
struct Common {
  Verbosity verbosity = Verbosity::kNormal;
  int threads = 0;         ///< 0: as many as the affinity mask allows
  bool overwrite = false;  ///< -f
};

struct RemeshSettings {
  int levels = 0;         ///< 0: chosen from the scan
  int base_vertices = 0;  ///< 0: chosen from the scan
  remesh::RepairPolicy repair = remesh::RepairPolicy::kSafe;
};

/// The steps of a run that can be written down. A step's folder is named by its place and name:
/// "04-parameterisation". New ones go behind: the places stay.
enum class DumpStage : std::uint8_t { kInput, kClean, kBase, kParameterisation, kNormalMesh };
inline constexpr std::array<std::string_view, 5> kDumpStageNames = {
    "input", "clean", "base", "parameterisation", "normal-mesh"};

struct DumpSettings {
  std::filesystem::path work_dir;  ///< empty: nothing is written down
  std::array<bool, kDumpStageNames.size()> stages{};

  [[nodiscard]] bool wants(DumpStage stage) const {
    return !work_dir.empty() && stages[static_cast<std::size_t>(stage)];
  }
};

struct EncodeCommand {
  std::filesystem::path scan, output;
  std::filesystem::path report;  ///< empty: none
  /// The goal, exactly one of the two. Bits are of the whole file, per input vertex.
  std::optional<std::uint64_t> size_bytes;
  std::optional<double> bits_per_input_vertex;
  codec::Profile profile = codec::Profile::kBest;
  codec::Effort effort = codec::Effort::kNormal;
  wavelet::Transform transform = wavelet::Transform::kButterfly;
  double theta_degrees = 1.0;
  RemeshSettings remesh;
  std::size_t samples = 500'000;  ///< of the measurement, see metric::Options
  Common common;
};

struct DecodeCommand {
  std::filesystem::path stream, output;
  int level = -1;        ///< -1: the finest
  bool partial = false;  ///< accept a stream cut short
  Common common;
};

struct RemeshCommand {
  std::filesystem::path scan, output;
  std::filesystem::path report;  ///< empty: none
  RemeshSettings remesh;
  DumpSettings dump;
  std::size_t samples = 500'000;
  Common common;
};

struct CompareCommand {
  std::filesystem::path a, b;  ///< scans or .ncr files; A is the reference
  std::filesystem::path map;   ///< empty: none
  std::filesystem::path picture;
  View view;                      ///< of the picture
  std::optional<double> map_max;  ///< distance at the top of the colour scale; none: the largest
  std::size_t samples = 500'000;
  bool json = false;
  Common common;
};

struct InfoCommand {
  std::filesystem::path file;
  bool json = false;
  Common common;
};

/// --help or --version: print to stdout and leave with 0.
struct PrintText {
  std::string text;
};

using Command = std::variant<PrintText, EncodeCommand, DecodeCommand, RemeshCommand, CompareCommand,
                             InfoCommand>;

}  // namespace nacre::app
