// SPDX-License-Identifier: GPL-3.0-or-later
//
// One number, the fineness, decides a file: log2(diagonal / step) for profile best, log2(bytes) for
// the others, which know no other goal than a size. PSNR grows with it by 3 to 6 dB a unit, the
// maximum error falls about as fast but less evenly; so the search is along a line.
#include "app/goal_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "app/aims.h"
#include "app/files.h"
#include "app/remesh_stage.h"
#include "app/sizes.h"
#include "codec/comparators.h"
#include "codec/decode.h"

namespace nacre::app {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Where within kPsnrTolerance the search aims, dB.
constexpr double kAim = 0.04;
constexpr double kUsualSlope = 4.2;  // dB per unit of fineness
constexpr double kLeastStride = 0.1, kMostStride = 3;
/// Downwards strides grow at most so fast.
constexpr double kStrideGrowth = 4;
constexpr int kMostTrials = 16;
/// Brackets narrower than this are not searched any further, for a PSNR, and for a maximum error,
/// which leaps; without levels there is one step only, of 32 in an octave, and nothing between.
constexpr double kNarrow = 1.0 / 256, kNarrowOfMaximum = 1.0 / 32, kStepWithoutLevels = 1.0 / 32,
                 kNarrowWithoutLevels = 1.5 * kStepWithoutLevels;
/// A unit of fineness that gains less than this, dB: the mesh itself is what is left.
constexpr double kLeastSlope = 0.15;
constexpr int kMostStalls = 2;
/// This far from the goal a single one is enough, dB; not without levels, where a coarse step may
/// happen to do better than a finer one.
constexpr double kFarDb = 3;
/// No mesh has use for finer steps than this.
constexpr double kFinest = 40;
/// What choosing cheap points of the grid instead of the nearest loses, dB: 2.6 and 8 where a bit
/// is worth half and twice as much, fandisk.
constexpr double kCheapPlacesDb = 2;
/// A corner of a cube of one step against its mean.
constexpr double kRoundingMaximumPerRms = 3;
/// Samples miss the very maximum; so the first aim is this much below the goal, dB.
constexpr double kMissed = 0.1;
/// What is usual of the maximum is said with less certainty, and small files are made sooner: the
/// search starts so many units of fineness below, and its strides are at least so long.
constexpr double kBelowUsual = 2, kLeastStrideOfMaximum = 0.5;
constexpr int kMostProofs = 8;
/// From a file whose proof failed to the next trial.
constexpr double kStrideAfterProof = 0.05;

/// A file may stay this much below its size; else there is nothing more to code.
constexpr double kUnused = 1.0 / 200;

/// An error here is the coder's fault, not the stream's.
Result<TriangleMesh> decode_again(const codec::Encoded& encoded) {
  const Result<SemiRegularMesh> decoded = codec::decode(encoded.bytes, decoding_options());
  Result<TriangleMesh> mesh = decoded ? to_triangles(*decoded) : decoded.error();
  if (mesh) return mesh;
  return Error{ErrorCode::kNoConvergence,
               fmt::format("the coded scan does not decode ({}); please report this scan",
                           mesh.error().message)};
}

double decibels(double ratio) { return 20 * std::log10(ratio); }

/// Makes files of one mesh.
class Coder {
 public:
  Coder(const EncodeCommand& command, const SemiRegularMesh& mesh, const Reference& reference,
        Console& console)
      : command_(command), mesh_(mesh), reference_(reference), console_(console) {
    options_.profile = command.profile;
    options_.effort = command.effort;
    options_.transform = command.transform;
    options_.theta_degrees = command.theta_degrees;
    if (has_steps() && options_.transform == wavelet::Transform::kButterfly)
      aims_ = aims_between(mesh, reference);
    options_.aims = aims_;
  }

  [[nodiscard]] bool has_steps() const { return options_.profile == codec::Profile::kBest; }
  /// Without levels the step is that of the coordinates.
  [[nodiscard]] bool is_rounded_only() const { return has_steps() && mesh_.level_count == 0; }
  [[nodiscard]] double diagonal() const { return reference_.surface.bbox_diagonal(); }

  Result<Coded> of_size(std::uint64_t bytes) const {
    codec::EncodeOptions options = options_;
    options.target_bytes = bytes;
    return code(options);
  }
  Result<Coded> of_step(double step) const {
    codec::EncodeOptions options = options_;
    options.step = step;
    return code(options);
  }
  Result<Coded> of_fineness(double fineness) const {
    if (has_steps()) return of_step(diagonal() * std::exp2(-fineness));
    return of_size(static_cast<std::uint64_t>(std::exp2(fineness)));
  }
  /// The PSNR that is left when nothing but rounding errs, by up to half a step each way, and
  /// vertices that go where they cost little.
  [[nodiscard]] double rounding_psnr(double fineness) const {
    return decibels(std::sqrt(12)) - kCheapPlacesDb + fineness * decibels(2);
  }
  /// The fineness that usually leads to a PSNR.
  [[nodiscard]] double usual_fineness(double psnr_db) const {
    if (is_rounded_only()) return (psnr_db - rounding_psnr(0)) / decibels(2);
    const double step = usual_step(psnr_db);
    return has_steps() ? -std::log2(step) : std::log2(usual_bytes(step));
  }

 private:
  Result<Coded> code(const codec::EncodeOptions& options) const {
    Result<codec::Encoded> encoded = codec::encode(mesh_, options, console_.context());
    if (!encoded) return in_file(encoded.error(), command_.scan);
    if (options.target_bytes != 0 && encoded->bytes.size() > options.target_bytes) {
      return Error{
          ErrorCode::kNoConvergence,
          fmt::format("{}: coded to {} bytes, over the {} asked for", command_.scan.string(),
                      encoded->bytes.size(), options.target_bytes)};
    }
    Result<Coded> coded = measured(command_, std::move(encoded), reference_, console_);
    if (!coded) return coded;
    coded->options = options;
    coded->options.aims = {};  // which end with this coder
    return coded;
  }

  const EncodeCommand& command_;
  const SemiRegularMesh& mesh_;
  const Reference& reference_;
  Console& console_;
  codec::EncodeOptions options_;
  std::vector<Vec3> aims_;
};

/// What a search is after, in dB.
struct Measure {
  double (*of)(const Coded&);
  double ahead_db;      ///< by how much the PSNR is usually above it
  double least_stride;  ///< while there is no bracket
  double narrow;        ///< finenesses closer together make about the same file
  double least_share;   ///< of a bracket, that a trial takes away: the more, the less even it is
  bool is_exact;        ///< a larger file that is nearer to the goal is better
};

Measure of_psnr(const Coder& coder) {
  return {[](const Coded& coded) { return coded.distance.psnr_db; }, 0,   kLeastStride,
          coder.is_rounded_only() ? kNarrowWithoutLevels : kNarrow,  0.1, true};
}

/// The PSNR of the maximum error.
Measure of_maximum(const Coder& coder) {
  const bool is_rounded_only = coder.is_rounded_only();
  return {[](const Coded& coded) {
            const double maximum = coded.maximum_error();
            return maximum > 0 ? decibels(coded.distance.bbox_diagonal / maximum) : kInfinity;
          },
          decibels(is_rounded_only ? kRoundingMaximumPerRms : kUsualMaximumPerRms),
          kLeastStrideOfMaximum,
          is_rounded_only ? kNarrowWithoutLevels : kNarrowOfMaximum,
          0.3,
          false};
}

/// The smallest file of at least so many dB.
class LineSearch {
 public:
  /// It ends where a file of `useful_bytes` does not reach the goal.
  LineSearch(const Coder& coder, const Measure& measure, std::size_t useful_bytes, Console& console)
      : coder_(coder), measure_(measure), useful_bytes_(useful_bytes), console_(console) {}

  struct End {
    double fineness, db;
  };
  /// From a first guess; `below` is known not to reach the goal. `reached` says whether it worked;
  /// if not, the result is the nearest.
  Result<Coded> run(double goal, double fineness, std::optional<End> below = std::nullopt);

 private:
  [[nodiscard]] double next(double goal) const;
  void note(Coded trial, double fineness, double db, double goal);

  const Coder& coder_;
  Measure measure_;
  std::size_t useful_bytes_;
  Console& console_;
  std::optional<End> below_, above_;  // nearest finenesses that do not and that do reach the goal
  /// The last stride downwards, and the slope there: where the mesh is all that errs, it is flat.
  double stride_ = kMostStride, slope_ = kUsualSlope;
  std::optional<Coded> best_, nearest_;
  int stalls_ = 0;  ///< in a row
};

double LineSearch::next(double goal) const {
  const double aim = goal + kAim;
  if (below_ && above_) {
    const double share = (aim - below_->db) / std::max(above_->db - below_->db, 1e-9);
    const double gap = above_->fineness - below_->fineness;
    const double unit = coder_.is_rounded_only() ? kStepWithoutLevels : 0;
    const double least = std::max(measure_.least_share * gap, unit);
    return below_->fineness + std::clamp(share * gap, least, std::max(gap - least, least));
  }
  if (below_)
    return std::min(below_->fineness + std::clamp((aim - below_->db) / kUsualSlope,
                                                  measure_.least_stride, kMostStride),
                    kFinest);
  const double least = measure_.least_stride;
  const double most = std::max(least, std::min(kMostStride, kStrideGrowth * stride_));
  return above_->fineness - std::clamp((above_->db - aim) / slope_, least, most);
}

void LineSearch::note(Coded trial, double fineness, double db, double goal) {
  if (db >= goal) {
    if (above_ && !below_ && fineness < above_->fineness) {
      stride_ = above_->fineness - fineness;
      slope_ = std::clamp((above_->db - db) / stride_, kLeastSlope, kUsualSlope);
    }
    if (!above_ || fineness < above_->fineness) above_ = End{fineness, db};
    const auto rank = [&](const Coded& coded) {
      const bool is_off = measure_.is_exact && measure_.of(coded) > goal + kPsnrTolerance;
      return std::pair(is_off, coded.encoded.bytes.size());
    };
    if (!best_ || rank(trial) < rank(*best_)) best_ = std::move(trial);
    return;
  }
  if (!above_ && below_ && fineness > below_->fineness) {
    const double slope = (db - below_->db) / (fineness - below_->fineness);
    const bool stalls = slope < kLeastSlope && goal - db > slope;
    const bool is_hopeless = goal - db > kFarDb && !coder_.is_rounded_only();
    stalls_ = stalls ? stalls_ + (is_hopeless ? kMostStalls : 1) : 0;
  }
  // Where rounding is not what errs, finer steps are of no use.
  if (!above_ && coder_.is_rounded_only() && goal - db > kFarDb &&
      coder_.rounding_psnr(fineness) - (db + measure_.ahead_db) > 2 * kFarDb)
    stalls_ = kMostStalls;
  if (!below_ || fineness > below_->fineness) below_ = End{fineness, db};
  if (!nearest_ || db > measure_.of(*nearest_)) nearest_ = std::move(trial);
}

Result<Coded> LineSearch::run(double goal, double fineness, std::optional<End> below) {
  below_ = below;
  for (int i = 0; i < kMostTrials && stalls_ < kMostStalls; ++i) {
    if (Result<void> go_on = check_cancelled(console_); !go_on) return go_on.error();
    Result<Coded> trial = coder_.of_fineness(fineness);
    if (!trial && trial.error().code == ErrorCode::kGoalUnreachable) {
      // Too small for the base mesh: what it needs is the least there is.
      fineness = std::log2(static_cast<double>(trial.error().where) + 0.5);
      trial = coder_.of_fineness(fineness);
    }
    if (!trial) return trial.error();
    const double db = measure_.of(*trial);
    console_.detail(fmt::format("trial {}: {} -> {:.2f} dB of {:.2f}", i + 1,
                                format_bytes(trial->encoded.bytes.size()), db, goal));
    const std::size_t bytes = trial->encoded.bytes.size();
    const bool is_smallest = best_ && !below_ && bytes == best_->encoded.bytes.size();
    note(std::move(*trial), fineness, db, goal);
    if (db >= goal && (db <= goal + kPsnrTolerance || is_smallest)) break;
    if (db < goal && bytes >= useful_bytes_) break;
    if (below_ && above_ && above_->fineness - below_->fineness < measure_.narrow) break;
    if (below_ && !above_ && below_->fineness >= kFinest) break;
    fineness = next(goal) + (stalls_ > 0 && !above_ ? 1 : 0);
  }
  if (best_) return std::move(*best_);
  nearest_->reached = false;
  return std::move(*nearest_);
}

Result<Coded> reach_psnr(const Coder& coder, double goal, std::size_t useful_bytes,
                         Console& console) {
  LineSearch search(coder, of_psnr(coder), useful_bytes, console);
  Result<Coded> coded = search.run(goal, coder.usual_fineness(goal));
  if (!coded || coded->reached) return coded;
  coded->remark = fmt::format("{:.2f} dB of the {:g} asked for", coded->distance.psnr_db, goal);
  return coded;
}

Result<Coded> reach_maximum(const Coder& coder, Reference& reference, double goal,
                            std::size_t useful_bytes, Console& console) {
  const Measure measure = of_maximum(coder);
  double aim = decibels(coder.diagonal() / goal) + kMissed;
  double fineness = coder.usual_fineness(aim + measure.ahead_db);
  if (!coder.is_rounded_only()) fineness -= kBelowUsual;
  Result<Coded> coded = Error{ErrorCode::kNoConvergence, "no trial"};
  std::optional<LineSearch::End> below;
  for (int proof = 0; proof < kMostProofs; ++proof) {
    LineSearch search(coder, measure, useful_bytes, console);
    coded = search.run(aim, fineness, below);
    if (!coded || !coded->reached) break;
    Result<metric::Certified> certified = certify(reference, *coded, console, goal);
    if (!certified) return certified.error();
    if (certified->upper() <= goal) {
      coded->certified = std::move(*certified);
      return coded;
    }
    console.detail(fmt::format("the maximum is {:.4g} somewhere, searching on",
                               std::max(certified->lower(), goal)));
    // A place on the scan can be looked at next time. One on the decoded surface will be elsewhere;
    // and a bound is loose where it gave up: what was met beyond the goal is not.
    if (certified->a_to_b.lower > goal) reference.places.push_back(certified->a_to_b.lower_at);
    aim += std::max(decibels(std::max(certified->b_to_a.lower, goal) / goal), kMissed);
    if (!coder.has_steps()) continue;
    const double met = std::max(coded->maximum_error(), certified->lower());
    fineness = std::log2(coder.diagonal() / coded->options.step);
    below = {fineness, std::min(decibels(coder.diagonal() / met), aim)};
    fineness += kStrideAfterProof;
  }
  if (!coded) return coded;
  coded->reached = false;
  coded->remark = fmt::format("a maximum error of {:.4g} where {:.4g} was asked for",
                              coded->maximum_error(), goal);
  return coded;
}

Result<Coded> reach_size(const Coder& coder, std::uint64_t bytes, std::size_t reserved) {
  Result<Coded> coded = coder.of_size(bytes > reserved ? bytes - reserved : 1);
  if (!coded) {
    if (coded.error().code != ErrorCode::kGoalUnreachable) return coded;
    Error error = coded.error();
    error.where += reserved;
    return error;
  }
  coded->size_limit = bytes;
  const std::size_t size = coded->encoded.bytes.size() + reserved;
  if (static_cast<double>(size) < (1 - kUnused) * static_cast<double>(bytes))
    coded->remark = fmt::format("{} is all that this mesh can use", format_bytes(size));
  return coded;
}

std::uint64_t bytes_of(double bits_per_vertex, std::size_t vertices) {
  constexpr double kMost = 1e18;  // fits std::uint64_t
  const double bytes = std::floor(bits_per_vertex * static_cast<double>(vertices) / 8);
  return static_cast<std::uint64_t>(std::clamp(bytes, 1.0, kMost));
}

}  // namespace

double Coded::maximum_error() const {
  return std::max(distance.a_to_b.maximum, distance.b_to_a.maximum);
}

codec::DecodeOptions decoding_options() {
  codec::DecodeOptions options;
  options.comparators = codec::decode_comparator_bands;
  return options;
}

Result<Coded> measured(const EncodeCommand& command, Result<codec::Encoded> encoded,
                       const Reference& reference, Console& console) {
  if (!encoded) return encoded.error();
  const Result<TriangleMesh> decoded = decode_again(*encoded);
  if (!decoded) return in_file(decoded.error(), command.scan);
  Coded coded;
  coded.encoded = std::move(*encoded);
  if (!has_area(*decoded)) {  // all of it in one place: of no quality at all
    coded.distance.bbox_diagonal = reference.surface.bbox_diagonal();
    coded.distance.a_to_b.maximum = coded.distance.bbox_diagonal;
    return coded;
  }
  metric::Options sampling;
  sampling.samples = command.samples;
  sampling.places = reference.places;
  Result<metric::Comparison> distance =
      metric::compare(reference.scan, reference.surface, *decoded, sampling, console.context());
  if (!distance) return surface_error(distance.error(), command.scan);
  coded.distance = std::move(*distance);
  return coded;
}

Result<metric::Certified> certify(const Reference& reference, const Coded& coded, Console& console,
                                  double give_up_above) {
  const Result<TriangleMesh> decoded = decode_again(coded.encoded);
  if (!decoded) return decoded.error();
  metric::CertifyOptions options;
  options.give_up_above = give_up_above;
  return metric::certified_distance(reference.scan, reference.surface, *decoded, options,
                                    console.context());
}

Result<Coded> code_for_goal(const EncodeCommand& command, const InputFacts& input,
                            const SemiRegularMesh& mesh, Reference& reference,
                            const Reserve& reserve, Console& console, std::size_t useful_bytes) {
  const Coder coder(command, mesh, reference, console);
  const Goal& goal = command.goal;
  const auto of_size = [&](std::uint64_t bytes) {
    return reach_size(coder, bytes, reserve(bytes, mesh.level_count));
  };
  switch (goal.kind) {
    case Goal::Kind::kSize:
      return of_size(static_cast<std::uint64_t>(goal.value));
    case Goal::Kind::kBitsPerInputVertex:
      return of_size(bytes_of(goal.value, input.goal_vertices));
    case Goal::Kind::kBitsPerSemiRegularVertex:
      return of_size(bytes_of(goal.value, mesh.positions.size()));
    case Goal::Kind::kQuality:
      if (coder.has_steps()) return coder.of_step(coder.diagonal() * step_of_quality(goal.value));
      return reach_psnr(coder, usual_psnr_db(step_of_quality(goal.value)), useful_bytes, console);
    case Goal::Kind::kPsnr:
      return reach_psnr(coder, goal.value, useful_bytes, console);
    case Goal::Kind::kMaxError:
    case Goal::Kind::kMaxErrorPercent:
      return reach_maximum(coder, reference, allowed_error(goal, coder.diagonal()), useful_bytes,
                           console);
  }
  return Error{ErrorCode::kBadInput, "unknown goal"};
}

}  // namespace nacre::app
