// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/code_scan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/files.h"
#include "app/level_table.h"
#include "app/sizes.h"
#include "codec/edit_stream.h"

namespace nacre::app {
namespace {

constexpr int kSmallerBases = 4;
/// A goal that the usual mesh cannot reach is tried with that for so much larger a file.
constexpr double kFiner = 6;
/// What a vertex of a simplified mesh costs, about; steps between trials of their number; how many;
/// and how far behind the first may be for another to be worth it.
constexpr double kBitsPerVertex = 30, kVertexRatio = 1.25, kHopelessDb = 1.5;
constexpr int kSimplifiedTrials = 6;
/// Where a file has more bits than this for each vertex of the scan, its own triangles may pay.
constexpr double kBitsForOwnTriangles = 12;

bool has_size(const Goal& goal) {
  return goal.kind == Goal::Kind::kSize || goal.kind == Goal::Kind::kBitsPerInputVertex ||
         goal.kind == Goal::Kind::kBitsPerSemiRegularVertex;
}

/// Whether the mesh is as the user wants it, or as a dump has it.
bool is_mesh_given(const EncodeCommand& command) {
  return command.remesh.semi_regular || command.remesh.levels != 0 ||
         command.remesh.base_vertices != 0 || !command.dump.work_dir.empty() ||
         !command.dump.from.empty();
}

class ScanCoder {
 public:
  ScanCoder(const EncodeCommand& command, Prepared& prepared, const Reference& reference,
            StageClock& clock, Console& console)
      : command_(command),
        prepared_(prepared),
        reference_(reference),
        clock_(clock),
        console_(console) {}

  Result<Coded> run();

 private:
  Result<Coded> code(const SemiRegularMesh& mesh) {
    const Reserve reserve = [&](std::uint64_t target, int levels) {
      const std::size_t table =
          reserved_table_bytes(command_.level_table, command_.profile, levels, target);
      return table +
             (command_.certify ? codec::certified_error_bytes(command_.profile, table > 0) : 0);
    };
    Result<Coded> coded =
        code_for_goal(command_, prepared_.input, mesh, reference_, reserve, console_);
    clock_.finish("encode");
    return coded;
  }
  /// Another mesh and its file; `prepared` changes only if `is_better` than what there was.
  template <class IsBetter>
  Result<bool> attempt(const RemeshSettings& settings, Result<Coded>& coded,
                       const IsBetter& is_better);
  Result<bool> try_smaller_bases(Result<Coded>& coded);
  Result<bool> try_finer_mesh(Result<Coded>& coded);
  Result<bool> try_own_triangles(Result<Coded>& coded);
  Result<bool> try_simplified(Result<Coded>& coded);
  [[nodiscard]] Error unreachable(const Coded& nearest) const;
  [[nodiscard]] Error too_small(const Error& error) const;

  const EncodeCommand& command_;
  Prepared& prepared_;
  const Reference& reference_;
  StageClock& clock_;
  Console& console_;
};

template <class IsBetter>
Result<bool> ScanCoder::attempt(const RemeshSettings& settings, Result<Coded>& coded,
                                const IsBetter& is_better) {
  remesh::Remesh before = std::exchange(prepared_.remesh, {});
  if (Result<void> ok = remesh_input(prepared_, settings, clock_, console_); !ok) return ok.error();
  Result<Coded> other = code(prepared_.remesh.mesh);
  if (!other && other.error().code != ErrorCode::kGoalUnreachable) return other.error();
  const bool better = is_better(other);
  if (better) {
    coded = std::move(other);
  } else {
    prepared_.remesh = std::move(before);
  }
  return better;
}

Result<bool> ScanCoder::try_smaller_bases(Result<Coded>& coded) {
  const double target = command_.goal.kind == Goal::Kind::kSize
                            ? command_.goal.value
                            : expected_bytes(command_.goal, prepared_.input.goal_vertices, 1);
  for (int i = 0; i < kSmallerBases && !coded; ++i) {
    const auto needed = static_cast<double>(coded.error().where);
    const auto now = static_cast<double>(prepared_.remesh.mesh.base_vertex_count);
    RemeshSettings settings = command_.remesh;
    settings.base_vertices =
        std::max(4, static_cast<int>(now * std::clamp(0.8 * target / needed, 0.1, 0.8)));
    const auto smaller = attempt(settings, coded, [&](const Result<Coded>& other) {
      return other || other.error().where < coded.error().where;
    });
    if (!smaller || !*smaller) return smaller;
  }
  return true;
}

Result<bool> ScanCoder::try_finer_mesh(Result<Coded>& coded) {
  const InputFacts& input = prepared_.input;
  const double usual = expected_bytes(command_.goal, input.goal_vertices, input.bbox_diagonal);
  return attempt(for_size(command_.remesh, kFiner * usual, input.goal_vertices), coded,
                 [&](const Result<Coded>& other) {
                   return other &&
                          (other->reached || other->distance.psnr_db > coded->distance.psnr_db);
                 });
}

Result<bool> ScanCoder::try_own_triangles(Result<Coded>& coded) {
  RemeshSettings settings = command_.remesh;
  settings.keep_triangles = true;
  const auto taken = attempt(settings, coded, [&](const Result<Coded>& other) {
    if (!other) return false;
    if (has_size(command_.goal)) return other->distance.psnr_db > coded->distance.psnr_db;
    if (other->reached != coded->reached) return other->reached;
    if (!other->reached) return other->distance.psnr_db > coded->distance.psnr_db;
    return other->encoded.bytes.size() < coded->encoded.bytes.size();
  });
  if (taken && *taken && coded->remark.empty())
    coded->remark = "so near the scan, its own triangles are the cheapest base mesh";
  return taken;
}

Result<bool> ScanCoder::try_simplified(Result<Coded>& coded) {
  const double semi_regular = coded->distance.psnr_db;
  const double first = 8 * static_cast<double>(coded->size_limit) / kBitsPerVertex;
  double vertices = first, factor = kVertexRatio;
  bool taken = false;
  for (int i = 0; i < kSimplifiedTrials; ++i) {
    RemeshSettings settings = command_.remesh;
    settings.keep_triangles = true;
    settings.base_vertices = static_cast<int>(std::max(vertices, 4.0));
    if (static_cast<double>(settings.base_vertices) >=
        static_cast<double>(prepared_.input.goal_vertices))
      break;
    double psnr = 0;
    const auto better = attempt(settings, coded, [&](const Result<Coded>& other) {
      psnr = other ? other->distance.psnr_db : 0;
      return other && psnr > coded->distance.psnr_db;
    });
    if (!better) return better;
    if (*better) coded->remark = "flat and sharp: a simplified mesh without levels is better";
    taken = taken || *better;
    if (i == 0 && psnr < semi_regular - kHopelessDb) break;
    // More vertices while that is better; then fewer than at first.
    if (i > 0 && !*better) {
      if (factor < 1 || i > 1) break;
      factor = 1 / kVertexRatio;
      vertices = first;
    }
    vertices *= factor;
  }
  return taken;
}

Error ScanCoder::unreachable(const Coded& nearest) const {
  Goal goal = command_.goal;
  if (goal.kind == Goal::Kind::kPsnr) {
    goal.value = std::floor(nearest.distance.psnr_db * 10) / 10;
  } else {
    const double share = 1.05 * nearest.maximum_error() / prepared_.input.bbox_diagonal;
    const double unit = std::pow(10, std::floor(std::log10(100 * share)) - 2);
    goal = {Goal::Kind::kMaxErrorPercent, std::ceil(100 * share / unit) * unit};
  }
  return {ErrorCode::kGoalUnreachable,
          fmt::format("{}: {}; nearest is {} at {}{}", command_.scan.string(), nearest.remark,
                      option_of(goal), format_bytes(nearest.encoded.bytes.size()),
                      is_mesh_given(command_) ? ", or leave --levels, --base-vertices and "
                                                "--work-dir to nacre"
                                              : "")};
}

Error ScanCoder::too_small(const Error& error) const {
  const Goal nearest{Goal::Kind::kSize, static_cast<double>(error.where)};
  return {error.code, fmt::format("{}; nearest is {}", error.message, option_of(nearest)),
          error.where};
}

Result<Coded> ScanCoder::run() {
  Result<Coded> coded = code(prepared_.remesh.mesh);
  const auto is_unreachable = [&] {
    return !coded && coded.error().code == ErrorCode::kGoalUnreachable;
  };
  if (!coded && !is_unreachable()) return coded;
  if (!is_mesh_given(command_)) {
    if (is_unreachable()) {
      if (const auto tried = try_smaller_bases(coded); !tried) return tried.error();
    }
    if (coded && has_size(command_.goal) && command_.transform == wavelet::Transform::kButterfly) {
      if (const auto tried = try_simplified(coded); !tried) return tried.error();
    }
    if (coded && !coded->reached) {
      if (const auto tried = try_finer_mesh(coded); !tried) return tried.error();
    }
    const double worth =
        kBitsForOwnTriangles / 8 * static_cast<double>(prepared_.input.goal_vertices);
    if (coded && (!coded->reached || static_cast<double>(coded->encoded.bytes.size()) > worth)) {
      if (const auto tried = try_own_triangles(coded); !tried) return tried.error();
    }
  }
  if (!coded) return too_small(coded.error());
  if (!coded->reached) return unreachable(*coded);
  return coded;
}

}  // namespace

RemeshSettings first_settings(const EncodeCommand& command, const InputFacts& input) {
  const double bytes = expected_bytes(command.goal, input.goal_vertices, input.bbox_diagonal);
  return for_size(command.remesh, bytes, input.goal_vertices);
}

Result<Coded> code_scan(const EncodeCommand& command, Prepared& prepared,
                        const Reference& reference, StageClock& clock, Console& console) {
  return ScanCoder(command, prepared, reference, clock, console).run();
}

}  // namespace nacre::app
