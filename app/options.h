// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "app/batch/command.h"
#include "app/picture.h"
#include "codec/codec.h"
#include "remesh/remesh.h"

/// What a command line asks for, as plain values: cli.h makes them, the verbs take them.
namespace nacre::app {

enum class Verbosity : std::uint8_t { kQuiet, kNormal, kVerbose };

enum class ProgressStyle : std::uint8_t {
  kAuto,  ///< a bar on a terminal
  kJson,  ///< a line of JSON a second on stderr, and one when a stage begins
  kNone,
};

/// Options that every verb has.
struct Common {
  Verbosity verbosity = Verbosity::kNormal;
  int threads = 0;         ///< 0: as many as the affinity mask allows
  bool overwrite = false;  ///< -f
  ProgressStyle progress = ProgressStyle::kAuto;
  std::uint64_t max_memory_bytes = 0;  ///< resident size to stop at; 0: none
  bool dry_run = false;                ///< say what it would take, and stop
};

struct RemeshSettings {
  int levels = 0;         ///< 0: chosen from the scan
  int base_vertices = 0;  ///< 0: chosen from the scan
  remesh::RepairPolicy repair = remesh::RepairPolicy::kSafe;
  // Not for the user to set: what the goal asks for. See remesh::Options.
  int least_base_vertices = 0, most_base_vertices = 0;
  std::size_t least_triangles = 0;
  bool keep_triangles = false, few_trials = false;
  /// The input is a base mesh and its 1 to 4 splits, and is coded as it is.
  bool semi_regular = false;
};

/// As the options --repair and --transform have them, and the reports.
[[nodiscard]] constexpr std::string_view name_of(remesh::RepairPolicy policy) {
  constexpr std::array<std::string_view, 4> kNames = {"safe", "strict", "none", "aggressive"};
  return kNames[static_cast<std::size_t>(policy)];
}
[[nodiscard]] constexpr std::string_view name_of(wavelet::Transform transform) {
  return transform == wavelet::Transform::kLoop ? "loop" : "butterfly";
}

/// What the file shall be: exactly one wish per run.
struct Goal {
  enum class Kind : std::uint8_t {
    kQuality,                   ///< 0 .. 100, see goal.h
    kSize,                      ///< bytes of the whole file
    kBitsPerInputVertex,        ///< of the whole file
    kBitsPerSemiRegularVertex,  ///< of the whole file, per vertex of the finest level
    kPsnr,                      ///< dB
    kMaxError,                  ///< two-sided maximum distance, model units
    kMaxErrorPercent,           ///< the same, per cent of the bounding box diagonal
  };
  Kind kind = Kind::kQuality;
  double value = 75;
  bool operator==(const Goal&) const = default;
};

/// The steps of a run that can be written down. A step's folder is named by its place and name:
/// "04-parameterisation". New ones go behind: the places stay.
enum class DumpStage : std::uint8_t {
  kInput,
  kClean,
  kBase,
  kParameterisation,
  kNormalMesh,
  kCoefficients,
  kRdCurves,
  kSteps,
  kSymbols,
  kStream
};
inline constexpr std::array<std::string_view, 10> kDumpStageNames = {
    "input",        "clean",     "base",  "parameterisation", "normal-mesh",
    "coefficients", "rd-curves", "steps", "symbols",          "stream"};
inline constexpr std::size_t kRemeshStages = 5;  ///< the first so many are those of `remesh`

struct DumpSettings {
  std::filesystem::path work_dir;  ///< empty: nothing is written down
  std::array<bool, kDumpStageNames.size()> stages{};
  std::filesystem::path from;      ///< folder of the stage to go on from; empty: from the scan
  std::optional<DumpStage> until;  ///< stop after this stage

  [[nodiscard]] bool wants(DumpStage stage) const {
    return !work_dir.empty() && stages[static_cast<std::size_t>(stage)];
  }
};

/// Whether an encode puts the errors of all levels into the file.
enum class LevelTableMode : std::uint8_t {
  kAuto,  ///< if it takes at most 1 % of the file
  kOn,
  kOff,
};

struct EncodeCommand {
  std::filesystem::path scan, output;
  std::filesystem::path report;  ///< empty: none
  Goal goal;
  bool certify = false;  ///< prove the maximum error and store the bound
  LevelTableMode level_table = LevelTableMode::kAuto;
  codec::Profile profile = codec::Profile::kBest;
  codec::Effort effort = codec::Effort::kNormal;
  wavelet::Transform transform = wavelet::Transform::kButterfly;
  double theta_degrees = 1.0;
  RemeshSettings remesh;
  std::filesystem::path reference;  ///< to measure against instead of the scan; empty: none
  bool has_goal = true;             ///< false: none was named, and the default stands above
  DumpSettings dump;
  std::size_t samples = 500'000;  ///< of the measurement, see metric::Options
  Common common;
};

/// A distance, two-sided: in model units or in per cent of the scan's bounding box diagonal.
struct ErrorGoal {
  double value = 0;
  bool is_percent = false;
};

/// Which level of a stream is wanted: at most one of the three.
struct PrefixChoice {
  int level = -1;                      ///< -1: the finest
  std::optional<std::uint64_t> bytes;  ///< the finest level that so many bytes hold
  std::optional<ErrorGoal> max_error;  ///< the coarsest level that is so near

  [[nodiscard]] bool is_all() const { return level < 0 && !bytes && !max_error; }
};

struct DecodeCommand {
  std::filesystem::path stream, output;
  PrefixChoice choice;
  bool partial = false;  ///< accept a stream cut short
  Common common;
};

struct CutCommand {
  std::filesystem::path stream, output;
  PrefixChoice choice;
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
  bool certify = false;
  double certify_percent = 1;  ///< how far the bounds may be apart, of the value
  bool json = false;
  Common common;
};

struct InfoCommand {
  std::filesystem::path file;
  bool json = false;
  Common common;
};

struct StageCommand {
  std::filesystem::path a, b;  ///< work folders, or folders of stages; b empty: list a
  bool json = false;
  Common common;
};

struct BatchCommand {
  batch::Verb verb;
  Common common;
};

/// --help or --version: print to stdout and leave with 0.
struct PrintText {
  std::string text;
};

using Command = std::variant<PrintText, EncodeCommand, DecodeCommand, RemeshCommand, CompareCommand,
                             InfoCommand, StageCommand, BatchCommand, CutCommand>;

}  // namespace nacre::app
