// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "app/options.h"
#include "codec/codec.h"
#include "io/io.h"
#include "metric/metric.h"
#include "remesh/remesh.h"

/// What a run did, for people (lines on stderr) and for scripts (JSON, schema "nacre-report/0").
/// Every quality figure in it was measured on what was written.
namespace nacre::app {

/// Wall time and peak memory of consecutive stages.
class StageClock {
 public:
  StageClock();
  /// Ends the stage that began at construction or at the last call.
  void finish(const std::string& stage);
  /// As finish(), listing the parts that the stage measured itself as "stage/part" before it.
  void finish(const std::string& stage, const std::vector<remesh::StageCost>& parts);
  [[nodiscard]] const std::vector<remesh::StageCost>& costs() const { return costs_; }
  [[nodiscard]] double total_seconds() const;

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point begin_, stage_begin_;
  std::vector<remesh::StageCost> costs_;
};

/// Peak resident size of this process so far.
[[nodiscard]] std::size_t peak_resident_bytes();

struct InputFacts {
  std::filesystem::path file;
  io::ReadReport read;
  std::size_t vertices = 0, faces = 0;
  /// What a goal in bits per input vertex counts: the file's vertices; of an STL, which repeats
  /// them per face, the distinct ones.
  std::size_t goal_vertices = 0;
  Vec3 origin = Vec3::Zero();
  double bbox_diagonal = 0;
};
[[nodiscard]] InputFacts input_facts(const std::filesystem::path& file, const io::ReadResult& read);

/// The half of a run that encode and remesh share.
struct RemeshFacts {
  remesh::CleanReport clean;
  std::vector<remesh::BandReport> bands;
  std::vector<remesh::PieceReport> pieces;
  std::size_t base_vertices = 0, base_triangles = 0, vertices = 0, triangles = 0;
  int levels = 0;
};
[[nodiscard]] RemeshFacts remesh_facts(const remesh::Remesh& remesh);

/// Where a run started, if not at the scan.
struct Reentry {
  std::string stage;  ///< "05-normal-mesh"
  std::filesystem::path folder;
  std::vector<std::string> edited;  ///< files that are not as they were dumped
};
/// "from W/02-clean, edited: clean.ply"
[[nodiscard]] std::string describe(const Reentry& from);

/// A level of the file: a prefix of it.
struct LevelFacts {
  std::size_t bytes = 0;
  std::uint64_t vertices = 0, triangles = 0;
  std::optional<double> psnr_db;    ///< as the file's level table has them, if there is one
  std::optional<double> max_error;  ///< certified
};
[[nodiscard]] std::vector<LevelFacts> level_facts(const codec::StreamInfo& info);

struct EncodeRun {
  EncodeCommand command;
  std::optional<Reentry> from = std::nullopt;
  InputFacts input;
  RemeshFacts remesh;
  std::uint64_t target_bytes = 0;
  codec::EncodeReport coded;
  std::vector<LevelFacts> levels;
  metric::Comparison distance;                        ///< scan against decoded file
  std::optional<metric::Certified> certified;         ///< the same, if it was asked for
  std::optional<metric::Comparison> remesh_distance;  ///< scan against the mesh before coding
  std::vector<remesh::StageCost> costs;
  double seconds = 0;
};

struct RemeshRun {
  RemeshCommand command;
  InputFacts input;
  RemeshFacts remesh;
  metric::Comparison distance;
  std::vector<remesh::StageCost> costs;
  double seconds = 0;
  std::optional<Reentry> from = std::nullopt;
};

/// JSON text, indented, with a final line end. Numbers that are not finite become null.
[[nodiscard]] std::string to_json(const EncodeRun& run);
[[nodiscard]] std::string to_json(const RemeshRun& run);
/// What `compare --json` prints; an encode report has the same under "distance".
[[nodiscard]] std::string to_json(const metric::Comparison& comparison,
                                  const std::optional<metric::Certified>& certified = {});

/// "scan.ply 1,204 faces 22.9 kB -> scan.ncr 118 B (194x), max error 0.02 (0.008 %), PSNR 71.3 dB,
/// ..."
[[nodiscard]] std::string summary_line(const EncodeRun& run);
[[nodiscard]] std::string summary_line(const RemeshRun& run);
/// Several lines for a person, without the last line end.
[[nodiscard]] std::string describe(const metric::Comparison& comparison);
[[nodiscard]] std::string describe(const metric::Certified& certified);
/// How much of each surface is how far from the other, a row per half decade.
[[nodiscard]] std::string describe_histogram(const metric::Comparison& comparison);

/// "cleaned: 12 welded vertices, ..."; empty if nothing was changed.
[[nodiscard]] std::string describe_cleaning(const remesh::CleanReport& clean);
/// Bytes of a piece in the base mesh: its share of the triangles and of the vertices. The coder
/// codes all pieces together and cannot tell them apart.
[[nodiscard]] std::size_t base_bytes_estimate(const remesh::PieceReport& piece,
                                              const RemeshFacts& remesh,
                                              const codec::EncodeReport& coded);
/// One line per piece that was not remeshed as usual, the first few of them; with its bytes, once
/// there is a file.
[[nodiscard]] std::vector<std::string> describe_fallbacks(
    const std::vector<remesh::PieceReport>& pieces, const EncodeRun* run = nullptr);
/// One line per stage, for -v.
[[nodiscard]] std::vector<std::string> describe_costs(const std::vector<remesh::StageCost>& costs);

/// The larger of the two one-sided maxima.
[[nodiscard]] double max_error(const metric::Comparison& comparison);

}  // namespace nacre::app
