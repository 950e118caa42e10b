// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/code_scan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
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
/// So much is the most that it may bring: to the PSNR, and to that of the maximum error, which is
/// where a mesh misses something.
constexpr double kFinerGainDb = 12, kFinerMaximumGainDb = 4;
/// What a vertex of a simplified mesh costs, about, and at least; the first ratio of trials of
/// their number, and how many trials.
constexpr double kBitsPerVertex = 24, kLeastBitsPerVertex = 17, kVertexRatio = 1.25;
constexpr std::size_t kStrides = 7;
constexpr int kParabolas = 3;
constexpr int kShifts = 8;
constexpr double kShift = 0.99;
constexpr std::array kBeside = {-1, 1, -2, 2, -3, 3};
/// Enough samples to see that a simplified mesh is hopeless, and how near hope it is then, dB.
constexpr std::size_t kFewSamples = 50'000;
constexpr double kHopelessDb = 0.5;
/// What fitting such a mesh to the scan brings, which the first look at one does without.
constexpr double kFitGainDb = 1;
/// Where a file has more bits than this for each vertex of the scan, its own triangles may pay.
constexpr double kBitsForOwnTriangles = 12;

bool has_size(const Goal& goal) {
  return goal.kind == Goal::Kind::kSize || goal.kind == Goal::Kind::kBitsPerInputVertex;
}

void add_remark(const char* remark, Coded& coded) {
  coded.remark = coded.remark.empty() ? remark : fmt::format("{}; {}", coded.remark, remark);
}

/// Whether `other` serves the goal better; a file at all must be there.
bool is_better(const Goal& goal, const Coded& other, const Coded& coded) {
  if (has_size(goal)) return other.distance.psnr_db > coded.distance.psnr_db;
  if (other.reached != coded.reached) return other.reached;
  if (!other.reached) return other.distance.psnr_db > coded.distance.psnr_db;
  return other.encoded.bytes.size() < coded.encoded.bytes.size();
}

/// Whether the mesh is as the user wants it, or as a dump has it.
bool is_mesh_given(const EncodeCommand& command) {
  return command.remesh.semi_regular || command.remesh.levels != 0 ||
         command.remesh.base_vertices != 0 || !command.dump.work_dir.empty() ||
         !command.dump.from.empty();
}

/// Whether a simplified mesh is worth a thought for a file of about so many bytes. Bits per
/// semi-regular vertex want such vertices; and other transforms are for comparisons.
bool may_be_simplified(const EncodeCommand& command, const InputFacts& input, double bytes) {
  return !is_mesh_given(command) && command.goal.kind != Goal::Kind::kBitsPerSemiRegularVertex &&
         command.transform == wavelet::Transform::kButterfly &&
         8 * bytes < kBitsPerVertex * static_cast<double>(input.goal_vertices);
}

/// How near a simplified mesh of as many vertices as `bytes` can pay for is, about; none: there
/// is no such mesh.
std::optional<double> simplified_psnr(const EncodeCommand& command, const Scan& source,
                                      const Reference& reference, double bytes, Console& console) {
  RemeshSettings settings = command.remesh;
  settings.keep_triangles = true;
  settings.few_trials = true;
  settings.base_vertices = std::max(4, static_cast<int>(8 * bytes / kLeastBitsPerVertex));
  RunContext context = console.context();
  context.progress = nullptr;  // other work may go on
  const auto simplified = remesh::remesh(source, remesh_options(settings), context);
  if (!simplified) return std::nullopt;
  const Result<TriangleMesh> mesh = to_triangles(simplified->mesh);
  if (!mesh || !has_area(*mesh)) return std::nullopt;
  metric::Options sampling;
  sampling.samples = kFewSamples;
  const auto distance =
      metric::compare(reference.scan, reference.surface, *mesh, sampling, context);
  if (!distance) return std::nullopt;
  return distance->psnr_db;
}

/// The place of the peak of the parabola through three places of a curve, the middle one highest;
/// or half-way to one without a value.
double peak_of_parabola(std::map<double, double>::const_iterator middle) {
  const auto [x, y] = *middle;
  const auto [x0, y0] = *std::prev(middle);
  const auto [x1, y1] = *std::next(middle);
  if (!std::isfinite(y0)) return (x0 + x) / 2;
  if (!std::isfinite(y1)) return (x + x1) / 2;
  const double a = (x - x0) * (y - y1), b = (x1 - x) * (y - y0);
  return a + b > 0 ? x + 0.5 * ((x1 - x) * b - (x - x0) * a) / (a + b) : x;
}

/// Goes along f in strides that double, from `first` to where it falls on either side or to `most`;
/// and then on by parabolas through the highest place and its neighbours.
///
/// Errors   those of f.
template <class F>
Result<void> climb(const F& f, double first, double most, double stride) {
  std::map<double, double> found;
  const auto is_highest_at = [&](double x) -> Result<bool> {
    const Result<double> value = f(x);
    if (!value) return value.error();
    found[x] = *value;
    return std::all_of(found.begin(), found.end(),
                       [&](const auto& other) { return other.second <= *value; });
  };
  if (const auto ok = is_highest_at(first); !ok) return ok.error();
  for (double step : {stride, -stride}) {
    double x = first;
    Result<bool> rises = true;
    for (; *rises && x + step <= most && found.size() < kStrides; step *= 2) {
      x += step;
      rises = is_highest_at(x);
      if (!rises) return rises.error();
    }
    if (found.size() > 2) break;  // the peak is on this side, or around `first`
  }
  for (int i = 0; i < kParabolas; ++i) {
    const auto peak = std::max_element(
        found.begin(), found.end(),
        [](const auto& one, const auto& other) { return one.second < other.second; });
    if (peak == found.begin() || std::next(peak) == found.end()) break;
    const double next = peak_of_parabola(peak);
    if (std::abs(next - peak->first) < stride / 8) break;
    if (const auto ok = is_highest_at(next); !ok) return ok.error();
  }
  return {};
}

class ScanCoder {
 public:
  ScanCoder(const EncodeCommand& command, Prepared& prepared, const Reference& reference,
            std::optional<double> simplified_psnr, StageClock& clock, Console& console)
      : command_(command),
        prepared_(prepared),
        reference_(reference),
        simplified_psnr_(simplified_psnr),
        clock_(clock),
        console_(console) {}

  Result<Coded> run();

 private:
  Result<Coded> code(const SemiRegularMesh& mesh, const Goal& goal,
                     std::size_t useful_bytes = kAnyBytes);
  /// Another mesh and its file; `prepared` changes only if `is_taken` of that file, or of why there
  /// is none. Errors   kCancelled.
  template <class IsTaken>
  Result<bool> attempt(const RemeshSettings& settings, const Goal& goal, Result<Coded>& coded,
                       const IsTaken& is_taken);
  Result<bool> try_smaller_bases(Result<Coded>& coded);
  Result<bool> try_finer_mesh(Result<Coded>& coded);
  Result<bool> try_own_triangles(Result<Coded>& coded);
  Result<bool> try_simplified(Result<Coded>& coded);
  [[nodiscard]] bool may_be_simplified(double bytes) const {
    return app::may_be_simplified(command_, prepared_.input, bytes);
  }
  /// What a goal on an error still wants.
  [[nodiscard]] double short_by_db(const Coded& nearest) const;
  [[nodiscard]] Error unreachable(const Coded& nearest) const;
  [[nodiscard]] Error too_small(const Error& error) const;

  const EncodeCommand& command_;
  Prepared& prepared_;
  Reference reference_;  // with the places that were found on the way
  std::optional<double> simplified_psnr_;
  StageClock& clock_;
  Console& console_;
};

Result<Coded> ScanCoder::code(const SemiRegularMesh& mesh, const Goal& goal,
                              std::size_t useful_bytes) {
  const Reserve reserve = [&](std::uint64_t target, int levels) {
    const std::size_t table =
        reserved_table_bytes(command_.level_table, command_.profile, levels, target);
    return table +
           (command_.certify ? codec::certified_error_bytes(command_.profile, table > 0) : 0);
  };
  EncodeCommand command = command_;
  command.goal = goal;
  Result<Coded> coded =
      code_for_goal(command, prepared_.input, mesh, reference_, reserve, console_, useful_bytes);
  clock_.finish("encode");
  return coded;
}

template <class IsTaken>
Result<bool> ScanCoder::attempt(const RemeshSettings& settings, const Goal& goal,
                                Result<Coded>& coded, const IsTaken& is_taken) {
  remesh::Remesh before = std::exchange(prepared_.remesh, {});
  const Result<void> remeshed = remesh_input(prepared_, settings, clock_, console_);
  const std::size_t useful = coded && coded->reached ? coded->encoded.bytes.size() : kAnyBytes;
  Result<Coded> other = remeshed ? code(prepared_.remesh.mesh, goal, useful) : remeshed.error();
  if (!other && other.error().code == ErrorCode::kCancelled) return other.error();
  const bool taken = is_taken(other);
  if (taken) {
    coded = std::move(other);
  } else {
    prepared_.remesh = std::move(before);
  }
  return taken;
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
    const auto smaller = attempt(settings, command_.goal, coded, [&](const Result<Coded>& other) {
      return other || (other.error().code == ErrorCode::kGoalUnreachable &&
                       other.error().where < coded.error().where);
    });
    if (!smaller || !*smaller) return smaller;
  }
  return true;
}

double ScanCoder::short_by_db(const Coded& nearest) const {
  const Goal& goal = command_.goal;
  if (goal.kind == Goal::Kind::kPsnr) return goal.value - nearest.distance.psnr_db;
  return 20 *
         std::log10(nearest.maximum_error() / allowed_error(goal, prepared_.input.bbox_diagonal));
}

Result<bool> ScanCoder::try_finer_mesh(Result<Coded>& coded) {
  const bool is_psnr = command_.goal.kind == Goal::Kind::kPsnr;
  if (short_by_db(*coded) > (is_psnr ? kFinerGainDb : kFinerMaximumGainDb)) return false;
  const InputFacts& input = prepared_.input;
  const double usual = expected_bytes(command_.goal, input.goal_vertices, input.bbox_diagonal);
  return attempt(for_size(command_.remesh, kFiner * usual, input.goal_vertices), command_.goal,
                 coded, [&](const Result<Coded>& other) {
                   return other &&
                          (other->reached || other->distance.psnr_db > coded->distance.psnr_db);
                 });
}

Result<bool> ScanCoder::try_own_triangles(Result<Coded>& coded) {
  RemeshSettings settings = command_.remesh;
  settings.keep_triangles = true;
  const auto taken = attempt(settings, command_.goal, coded, [&](const Result<Coded>& other) {
    return other && is_better(command_.goal, *other, *coded);
  });
  if (taken && *taken)
    add_remark("so near the scan, its own triangles are the cheapest base mesh", *coded);
  return taken;
}

Result<bool> ScanCoder::try_simplified(Result<Coded>& coded) {
  // What a quality leads to is known by now: the same PSNR in fewer bytes is wanted.
  Goal goal = command_.goal;
  if (goal.kind == Goal::Kind::kQuality) goal = {Goal::Kind::kPsnr, coded->distance.psnr_db};
  RemeshSettings settings = command_.remesh;
  settings.keep_triangles = true;
  const auto bytes = static_cast<double>(coded->encoded.bytes.size());
  const double first = std::log(8 * bytes / kBitsPerVertex);
  const double most = std::log(static_cast<double>(prepared_.input.goal_vertices));
  bool taken = false;
  // A worth is the better the larger; it has one peak along the number of vertices.
  const auto worth_of = [&](double log_vertices) -> Result<double> {
    settings.base_vertices = std::max(4, static_cast<int>(std::exp(log_vertices)));
    double worth = -std::numeric_limits<double>::infinity();
    const auto better = attempt(settings, goal, coded, [&](const Result<Coded>& other) {
      if (!other) return false;
      const std::size_t size = other->encoded.bytes.size();
      if (other->reached || size >= coded->encoded.bytes.size())
        worth = has_size(goal) ? other->distance.psnr_db : -static_cast<double>(size);
      return other->reached && is_better(goal, *other, *coded);
    });
    if (!better) return better.error();
    taken = taken || *better;
    return worth;
  };
  if (!simplified_psnr_)
    simplified_psnr_ = simplified_psnr(command_, prepared_.source(), reference_, bytes, console_);
  if (Result<void> go_on = check_cancelled(console_); !go_on) return go_on.error();
  const double hope = kHopelessDb + (settings.few_trials ? 0 : kFitGainDb);
  if (simplified_psnr_.value_or(0) <= coded->distance.psnr_db - hope) return false;
  if (const auto peak = climb(worth_of, first, most, std::log(kVertexRatio)); !peak)
    return peak.error();
  if (!taken) return false;
  // The PSNR of a mesh without levels jumps from step to step; a few vertices less shift that.
  auto vertices = static_cast<double>(prepared_.remesh.mesh.base_vertex_count);
  for (int i = 0; i < kShifts && goal.kind == Goal::Kind::kPsnr &&
                  coded->distance.psnr_db > goal.value + kPsnrTolerance;
       ++i) {
    vertices *= kShift;
    if (const auto shifted = worth_of(std::log(vertices)); !shifted) return shifted.error();
  }
  // And so does that of a size, and how much of it is used: neighbours may be better by chance.
  for (const int i : kBeside) {
    if (!has_size(goal) || settings.few_trials) break;
    if (const auto beside = worth_of(std::log(vertices * std::pow(kShift, i))); !beside)
      return beside.error();
  }
  add_remark("flat and sharp: a simplified mesh without levels is better", *coded);
  return true;
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
  Result<Coded> coded = code(prepared_.remesh.mesh, command_.goal);
  const auto is_unreachable = [&] {
    return !coded && coded.error().code == ErrorCode::kGoalUnreachable;
  };
  if (!coded && !is_unreachable()) return coded;
  if (!is_mesh_given(command_)) {
    if (is_unreachable()) {
      if (const auto tried = try_smaller_bases(coded); !tried) return tried.error();
    }
    if (coded && !coded->reached) {
      if (const auto tried = try_finer_mesh(coded); !tried) return tried.error();
    }
    const double worth =
        kBitsForOwnTriangles / 8 * static_cast<double>(prepared_.input.goal_vertices);
    if (coded && (!coded->reached || static_cast<double>(coded->encoded.bytes.size()) > worth)) {
      if (const auto tried = try_own_triangles(coded); !tried) return tried.error();
    }
    if (coded && coded->reached &&
        may_be_simplified(static_cast<double>(coded->encoded.bytes.size()))) {
      if (const auto tried = try_simplified(coded); !tried) return tried.error();
    }
  }
  if (!coded) return too_small(coded.error());
  if (!coded->reached) return unreachable(*coded);
  if (command_.goal.kind == Goal::Kind::kPsnr && -short_by_db(*coded) > kPsnrTolerance)
    add_remark("no smaller file was found that reaches it", *coded);
  return coded;
}

}  // namespace

RemeshSettings first_settings(const EncodeCommand& command, const InputFacts& input) {
  const double bytes = expected_bytes(command.goal, input.goal_vertices, input.bbox_diagonal);
  return for_size(command.remesh, bytes, input.goal_vertices);
}

std::optional<double> early_simplified_psnr(const EncodeCommand& command, const Prepared& prepared,
                                            const Reference& reference, Console& console) {
  const InputFacts& input = prepared.input;
  const double bytes = expected_bytes(command.goal, input.goal_vertices, input.bbox_diagonal);
  if (!has_size(command.goal) || !may_be_simplified(command, input, bytes)) return std::nullopt;
  return simplified_psnr(command, prepared.source(), reference, bytes, console);
}

Result<Coded> code_scan(const EncodeCommand& command, Prepared& prepared,
                        const Reference& reference, std::optional<double> simplified_psnr,
                        StageClock& clock, Console& console) {
  return ScanCoder(command, prepared, reference, simplified_psnr, clock, console).run();
}

}  // namespace nacre::app
