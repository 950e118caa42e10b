// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <string>

#include "base/parallel.h"
#include "codec/band_coder.h"
#include "codec/codec.h"
#include "codec/rate_control.h"
#include "codec/renumber.h"
#include "codec/stream_format.h"
#include "codec/stream_writer.h"
#include "entropy/connectivity.h"
#include "wavelet/wavelet.h"

namespace nacre::codec {
namespace {

constexpr int kMinBaseBits = 6, kMaxBaseBits = 20;
/// How often the gains are measured anew on the errors the allocation makes.
constexpr int kGainRounds = 2;

/// The mesh in the numbering of its decoder, and its wavelet coefficients.
struct Prepared {
  entropy::EncodedConnectivity connectivity;
  Topology topology;
  std::vector<Vec3> positions;
  Pyramid pyramid;
};

Error cancelled() { return {ErrorCode::kCancelled, "encoding was cancelled", 0}; }

Result<void> check(const SemiRegularMesh& mesh, const EncodeOptions& options) {
  const auto bad = [](const std::string& what, std::size_t where = 0) {
    return Error{ErrorCode::kBadInput, what, where};
  };
  if (options.target_bytes == 0) return bad("no target size is given");
  if (options.base_bits != 0 &&
      (options.base_bits < kMinBaseBits || options.base_bits > kMaxBaseBits))
    return bad("base bits must lie in 6 .. 20");
  if (!(options.theta_degrees >= 0) || options.theta_degrees > 90)
    return bad("the cone's angle must lie in 0 .. 90 degrees");
  if (mesh.base_triangles.empty()) return bad("the mesh has no triangles");
  if (mesh.level_count < 0 || mesh.level_count > kMaxLevels)
    return bad("the mesh has " + std::to_string(mesh.level_count) +
               " levels; 0 .. 15 are possible");
  // Steps of the format end at 2^±200; coordinates keep well clear of both ends.
  constexpr double kLargest = 0x1p150, kSmallest = 0x1p-150;
  double largest = 0;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const double x = std::abs(mesh.positions[i][k]);
      if (!(x <= kLargest))
        return bad("vertex " + std::to_string(i) + " has no usable coordinates", i);
      largest = std::max(largest, x);
    }
  }
  if (largest != 0 && largest < kSmallest) return bad("the mesh is too small to be coded");
  for (int k = 0; k < 3; ++k)
    if (!std::isfinite(mesh.origin[k])) return bad("the origin is not finite");
  return {};
}

Result<Prepared> prepare(const SemiRegularMesh& mesh, const EncodeOptions& options) {
  auto input = Topology::build(mesh.base_triangles, mesh.base_vertex_count, mesh.level_count);
  if (!input) return input.error();
  if (mesh.positions.size() != input->vertex_count()) {
    return Error{ErrorCode::kBadInput,
                 "the mesh has " + std::to_string(mesh.positions.size()) +
                     " positions, its topology " + std::to_string(input->vertex_count()) +
                     " vertices",
                 0};
  }
  auto connectivity = entropy::encode_connectivity(mesh.base_triangles, mesh.base_vertex_count);
  if (!connectivity) return connectivity.error();
  auto topology = Topology::build(connectivity->decoded.triangles,
                                  connectivity->decoded.vertex_count, mesh.level_count);
  if (!topology) return topology.error();
  const auto order = canonical_order(*input, *topology, connectivity->vertex_order);
  if (!order) return order.error();
  std::vector<Vec3> positions(order->size());
  parallel_for_each_index(order->size(),
                          [&](std::size_t i) { positions[i] = mesh.positions[(*order)[i]]; });
  auto pyramid = wavelet::analyze(*topology, positions, options.transform);
  if (!pyramid) return pyramid.error();
  return Prepared{std::move(*connectivity), std::move(*topology), std::move(positions),
                  std::move(*pyramid)};
}

BandCoderOptions coder_options(const EncodeOptions& options) {
  BandCoderOptions coder;
  coder.theta_rad = options.theta_degrees * (M_PI / 180);
  return coder;
}

std::size_t varint_bytes(std::uint64_t value) {
  std::size_t count = 1;
  for (; value >= 0x80; value >>= 7) ++count;
  return count;
}

/// A payload with its checksum and its length field.
std::size_t section_bytes(std::size_t payload) {
  return payload + checksum_bytes(payload) + varint_bytes(payload);
}

Part base_part(const Prepared& prepared, int base_bits) {
  Part part;
  const auto& positions = prepared.pyramid.base_positions;
  part.vertex_count = positions.size();
  part.may_be_left_out = false;
  part.coarsest_step = step_index_for_bits(positions, base_bits == 0 ? kMinBaseBits : base_bits);
  part.finest_step =
      base_bits == 0 ? step_index_for_bits(positions, kMaxBaseBits) : part.coarsest_step;
  part.has_nothing_to_code = part.finest_step == part.coarsest_step;
  part.measure = [&prepared](int step) {
    const CodedBase base =
        encode_base(prepared.pyramid.base_positions, prepared.connectivity.decoded, step);
    std::size_t bytes = section_bytes(base.payload.size());
    for (const std::int64_t corner : base.corner) bytes += varint_bytes(zigzag(corner));
    return Measured{bytes, base.distortion};
  };
  return part;
}

Part band_part(const Prepared& prepared, std::size_t band, const BandCoderOptions& coder) {
  Part part;
  const auto& details = prepared.pyramid.bands[band];
  part.vertex_count = details.size();
  double largest = 0;
  for (const Vec3& d : details)
    for (int k = 0; k < 3; ++k) largest = std::max(largest, std::abs(d[k]));
  // A component survives the dead zone if it is larger than dead_zone steps. Details below the
  // smallest normal length of the format's range (rounding noise of a flat mesh) are not coded.
  part.has_nothing_to_code = !(largest > 0x1p-190);
  if (!part.has_nothing_to_code) {
    part.coarsest_step = nearest_step_index(largest / coder.dead_zone) - 1;
    // 22 bits per component: beyond that the lattice's range ends.
    part.finest_step = std::max(part.coarsest_step - 22 * kStepsPerOctave, -kMaxStepIndex);
  }
  part.measure = [&details, coder](int step) {
    const CodedBand coded = encode_band(details, step, coder);
    // One byte for the step, which differs little from the coarser band's.
    const std::size_t bytes = coded.payload.empty() ? 0 : section_bytes(coded.payload.size()) + 1;
    return Measured{bytes, coded.distortion};
  };
  return part;
}

/// The geometry at one choice of steps: what is written and what the decoder will see.
struct Coded {
  CodedBase base;
  std::vector<CodedBand> bands;
};

Coded code_at(const Prepared& prepared, const Steps& steps, const BandCoderOptions& coder) {
  Coded coded;
  coded.bands.resize(prepared.pyramid.bands.size());
  parallel_for_each_index(
      steps.size(),
      [&](std::size_t i) {
        if (i == 0) {
          coded.base =
              encode_base(prepared.pyramid.base_positions, prepared.connectivity.decoded, steps[0]);
        } else {
          coded.bands[i - 1] = encode_band(prepared.pyramid.bands[i - 1], steps[i], coder);
        }
      },
      1);
  return coded;
}

std::vector<std::uint8_t> assemble(const SemiRegularMesh& mesh, const Prepared& prepared,
                                   const EncodeOptions& options, const Steps& steps,
                                   const Coded& coded) {
  Header header;
  header.transform = options.transform;
  header.levels = mesh.level_count;
  header.origin = mesh.origin;
  const LevelTopology& base = prepared.topology.level(0);
  header.base_vertices = base.vertex_count;
  header.base_triangles = base.triangles.size();
  header.boundary_edges = 2 * base.edges.size() - 3 * base.triangles.size();
  header.grid_bits = coded.base.grid_bits;
  header.grid_step_index = steps[0];
  header.grid_corner = coded.base.corner;
  std::vector<std::vector<std::uint8_t>> payloads;
  for (std::size_t j = 0; j < coded.bands.size(); ++j) {
    header.bands.push_back({0, steps[j + 1]});
    payloads.push_back(coded.bands[j].payload);
  }
  return write_stream(header, prepared.connectivity.bytes, coded.base.payload, payloads);
}

/// Squared error on the finest mesh per squared error in each part, for the very errors that this
/// choice of steps makes: each part alone is replaced by its decoded self and synthesised.
Result<std::vector<double>> gains_of_errors(const Prepared& prepared, const EncodeOptions& options,
                                            const Coded& coded, std::vector<double> gains) {
  std::vector<Result<void>> outcome(gains.size());
  parallel_for_each_index(
      gains.size(),
      [&](std::size_t i) {
        const double distortion = i == 0 ? coded.base.distortion : coded.bands[i - 1].distortion;
        if (!(distortion > 0)) return;
        Pyramid pyramid = prepared.pyramid;
        (i == 0 ? pyramid.base_positions : pyramid.bands[i - 1]) =
            i == 0 ? coded.base.decoded : coded.bands[i - 1].decoded;
        const std::size_t count =
            i == 0 ? pyramid.base_positions.size() : pyramid.bands[i - 1].size();
        const auto positions = wavelet::synthesize(prepared.topology, pyramid, options.transform);
        if (!positions) {
          outcome[i] = positions.error();
          return;
        }
        const double energy = mean_squared_difference(*positions, prepared.positions) *
                              static_cast<double>(positions->size());
        gains[i] = energy / (distortion * static_cast<double>(count));
      },
      1);
  for (const auto& o : outcome)
    if (!o) return o.error();
  return gains;
}

Result<std::vector<alloc::Band>> make_bands(
    const Measurements& measurements, const std::vector<std::vector<alloc::Sample>>& samples) {
  std::vector<alloc::Band> bands;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Part& part = measurements.parts()[i];
    auto curve = alloc::RateDistortionCurve::fit(samples[i]);
    if (!curve) return curve.error();
    bands.push_back({part.vertex_count, part.gain, std::move(*curve)});
  }
  return bands;
}

/// Everything that is settled once the steps are.
struct Outcome {
  Steps steps;
  Coded coded;
  std::vector<std::uint8_t> bytes;
  double lambda = 0;
};

class Encoder {
 public:
  Encoder(const SemiRegularMesh& mesh, const EncodeOptions& options, const RunContext& context,
          const Prepared& prepared)
      : mesh_(mesh),
        options_(options),
        context_(context),
        prepared_(prepared),
        coder_(coder_options(options)),
        measurements_(make_parts()) {}

  Result<Encoded> run();

 private:
  std::vector<Part> make_parts() const;
  Result<Outcome> solve();
  /// The budget for the parts that makes the whole file as large as it may be.
  Result<Outcome> solve_for_file_size();
  Outcome build(const Steps& steps, double lambda) const;
  [[nodiscard]] EncodeReport report(const Outcome& outcome) const;
  [[nodiscard]] double predicted(const Steps& steps) const;

  const SemiRegularMesh& mesh_;
  const EncodeOptions& options_;
  const RunContext& context_;
  const Prepared& prepared_;
  BandCoderOptions coder_;
  Measurements measurements_;
  std::vector<std::vector<alloc::Sample>> samples_;
  RateProblem problem_;
};

std::vector<Part> Encoder::make_parts() const {
  std::vector<Part> parts;
  parts.push_back(base_part(prepared_, options_.base_bits));
  for (std::size_t j = 0; j < prepared_.pyramid.bands.size(); ++j)
    parts.push_back(band_part(prepared_, j, coder_));
  const auto gains = wavelet::regular_gains(prepared_.topology.level_count(), options_.transform);
  for (std::size_t i = 0; i < parts.size(); ++i) parts[i].gain = gains.energy[i];
  return parts;
}

Outcome Encoder::build(const Steps& steps, double lambda) const {
  Outcome outcome{steps, code_at(prepared_, steps, coder_), {}, lambda};
  outcome.bytes = assemble(mesh_, prepared_, options_, steps, outcome.coded);
  return outcome;
}

Result<Outcome> Encoder::solve_for_file_size() {
  // The header's size depends on what it says, by a few bytes: correct the budget until the file
  // fits. Every measurement is kept, so another round costs next to nothing.
  constexpr int kMaxRounds = 6;
  std::size_t budget = problem_.budget_bytes;
  for (int round = 0; round < kMaxRounds; ++round) {
    RateProblem problem = problem_;
    problem.budget_bytes = budget;
    auto solution = search_slope(measurements_, problem);
    if (!solution) return solution.error();
    fill_budget(measurements_, budget, solution->steps);
    Outcome outcome = build(solution->steps, solution->lambda);
    if (outcome.bytes.size() <= options_.target_bytes) return outcome;
    const std::size_t excess = outcome.bytes.size() - options_.target_bytes;
    if (excess >= budget) break;
    budget -= excess;
  }
  return Error{ErrorCode::kGoalUnreachable, "the header leaves no room", 0};
}

Result<Outcome> Encoder::solve() {
  samples_ = sample_parts(measurements_, problem_.budget_bytes, context_);
  if (context_.cancelled()) return cancelled();
  for (int round = 0;; ++round) {
    auto bands = make_bands(measurements_, samples_);
    if (!bands) return bands.error();
    problem_.bands = std::move(*bands);
    auto outcome = solve_for_file_size();
    if (!outcome || round == kGainRounds) return outcome;
    if (context_.cancelled()) return cancelled();
    std::vector<double> gains;
    for (const Part& part : measurements_.parts()) gains.push_back(part.gain);
    auto measured = gains_of_errors(prepared_, options_, outcome->coded, std::move(gains));
    if (!measured) return measured.error();
    measurements_.set_gains(*measured);
    context_.report("allocating", static_cast<double>(round + 1) / (kGainRounds + 1));
  }
}

double Encoder::predicted(const Steps& steps) const {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Part& part = measurements_.parts()[i];
    const auto vertices = static_cast<double>(part.vertex_count);
    const double bits = 8.0 * static_cast<double>(measurements_.at(i, steps[i]).bytes) / vertices;
    sum += vertices * part.gain * problem_.bands[i].curve.distortion(bits);
    count += vertices;
  }
  return sum / count;
}

EncodeReport Encoder::report(const Outcome& outcome) const {
  EncodeReport report;
  const auto sized = [](const std::vector<std::uint8_t>& payload) {
    return payload.size() + checksum_bytes(payload.size());
  };
  report.bytes = outcome.bytes.size();
  report.bytes_base_connectivity = sized(prepared_.connectivity.bytes);
  report.bytes_base_positions = sized(outcome.coded.base.payload);
  report.bytes_base = report.bytes_base_connectivity + report.bytes_base_positions;
  report.bytes_header = report.bytes - report.bytes_base;
  report.base_bits = outcome.coded.base.grid_bits;
  report.levels = mesh_.level_count;
  report.lambda = outcome.lambda;
  report.predicted_distortion = predicted(outcome.steps);
  for (std::size_t j = 0; j < outcome.coded.bands.size(); ++j) {
    const CodedBand& coded = outcome.coded.bands[j];
    BandReport band;
    band.vertices = coded.decoded.size();
    band.gain = measurements_.parts()[j + 1].gain;
    band.step = coded.payload.empty() ? 0 : step_size(outcome.steps[j + 1]);
    band.bits = 8.0 * static_cast<double>(sized(coded.payload));
    band.normal_only_fraction = coded.normal_only_fraction;
    band.distortion = coded.distortion;
    band.samples = samples_[j + 1];
    report.bytes_header -= sized(coded.payload);
    report.bands.push_back(std::move(band));
  }
  return report;
}

Result<Encoded> Encoder::run() {
  // The smallest possible file: no bands, the coarsest grid.
  const Steps least = [&] {
    Steps steps;
    for (const Part& part : measurements_.parts())
      steps.push_back(part.may_be_left_out ? kNotCoded : part.coarsest_step);
    return steps;
  }();
  const std::size_t smallest = build(least, 0).bytes.size();
  if (smallest > options_.target_bytes) {
    return Error{ErrorCode::kGoalUnreachable,
                 "the base mesh alone takes " + std::to_string(smallest) + " bytes, " +
                     std::to_string(options_.target_bytes) + " were asked for",
                 smallest};
  }
  problem_.budget_bytes = options_.target_bytes - (smallest - measurements_.bytes(least));
  auto outcome = solve();
  if (!outcome) return outcome.error();
  Encoded encoded;
  encoded.report = report(*outcome);
  encoded.bytes = std::move(outcome->bytes);
  const auto decoded =
      decode(encoded.bytes, {-1, std::numeric_limits<std::uint64_t>::max(), false});
  if (!decoded) return decoded.error();
  encoded.report.measured_distortion =
      mean_squared_difference(decoded->positions, prepared_.positions);
  return encoded;
}

}  // namespace

Result<Encoded> encode(const SemiRegularMesh& mesh, const EncodeOptions& options,
                       const RunContext& context) {
  if (const auto ok = check(mesh, options); !ok) return ok.error();
  try {
    const auto prepared = prepare(mesh, options);
    if (!prepared) return prepared.error();
    if (context.cancelled()) return cancelled();
    return Encoder(mesh, options, context, *prepared).run();
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kLimitExceeded, "not enough memory to encode the mesh", 0};
  }
}

}  // namespace nacre::codec
