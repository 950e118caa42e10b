// SPDX-License-Identifier: GPL-3.0-or-later
#include "codec/geometry_coder.h"

#include <algorithm>
#include <string>
#include <utility>

#include "base/parallel.h"
#include "codec/renumber.h"

namespace nacre::codec {
namespace {

Vec3 from_frame(const Frame& frame, const Vec3& detail) {
  return frame.normal * detail[0] + frame.tangent1 * detail[1] + frame.tangent2 * detail[2];
}

/// What is left of a part's error, as vectors of model space.
std::vector<Vec3> error_vectors(const Prepared& prepared, const CodedGeometry& coded,
                                std::size_t part) {
  std::vector<Vec3> errors;
  if (part == 0) {
    const auto& positions = prepared.pyramid.base_positions;
    errors.resize(positions.size());
    for (std::size_t i = 0; i < errors.size(); ++i)
      errors[i] = coded.base.decoded[i] - positions[i];
    return errors;
  }
  const CodedBand& band = coded.bands[part - 1];
  errors.resize(band.decoded.size());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    errors[i] = from_frame(coded.frames[part - 1][i], band.decoded[i] - coded.details[part - 1][i]);
  }
  return errors;
}

/// Sum of squares on the finest level of an error made in one part: prediction is linear.
double carried_energy(const Prepared& prepared, const CodedGeometry& coded, std::size_t part) {
  std::vector<Vec3> field = error_vectors(prepared, coded, part);
  const Topology& topology = prepared.topology;
  if (part > 0) {
    const auto kept = topology.level(static_cast<int>(part) - 1).vertex_count;
    field.insert(field.begin(), kept, Vec3::Zero());
  }
  for (int j = static_cast<int>(part); j < topology.level_count(); ++j) {
    const auto points = wavelet::predict(topology, j, field).points;
    field.insert(field.end(), points.begin(), points.end());
  }
  return deterministic_sum<double>(field.size(),
                                   [&](std::size_t i) { return dot(field[i], field[i]); });
}

}  // namespace

std::vector<std::vector<Vec3>> detail_vectors(const Topology& topology,
                                              std::span<const Vec3> positions) {
  std::vector<std::vector<Vec3>> bands;
  for (int j = 0; j < topology.level_count(); ++j) {
    const auto coarse = positions.first(topology.level(j).vertex_count);
    const PredictedLevel prediction = wavelet::predict_level(topology, j, coarse);
    std::vector<Vec3>& vectors = bands.emplace_back(prediction.size());
    parallel_for_each_index(vectors.size(), [&](std::size_t i) {
      vectors[i] = positions[coarse.size() + i] - prediction.point(i);
    });
  }
  return bands;
}

Result<Prepared> prepare(const SemiRegularMesh& mesh, wavelet::Transform transform,
                         std::span<const Vec3> aims) {
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

  Prepared prepared{std::move(*connectivity), std::move(*topology), {}, transform, {}, {}, {}};
  prepared.positions.resize(order->size());
  parallel_for_each_index(
      order->size(), [&](std::size_t i) { prepared.positions[i] = mesh.positions[(*order)[i]]; });
  auto pyramid = wavelet::analyze(prepared.topology, prepared.positions, transform);
  if (!pyramid) return pyramid.error();
  prepared.pyramid = std::move(*pyramid);
  if (transform != wavelet::Transform::kButterfly) return prepared;
  prepared.aims.resize(aims.size());
  for (std::size_t i = 0; i < aims.size(); ++i) prepared.aims[i] = aims[(*order)[i]];
  prepared.vectors = detail_vectors(prepared.topology, prepared.positions);
  return prepared;
}

Result<CodedGeometry> code_geometry(const Prepared& prepared, const Steps& steps,
                                    const BandCoderOptions& options) {
  CodedGeometry coded;
  coded.steps = steps;
  coded.base =
      encode_base(prepared.pyramid.base_positions, prepared.connectivity.decoded, steps[0]);
  Pyramid decoded;
  decoded.base_positions = coded.base.decoded;
  for (int j = 0; j < prepared.topology.level_count(); ++j) {
    const auto band = static_cast<std::size_t>(j);
    std::vector<Vec3> details;
    if (prepared.transform != wavelet::Transform::kButterfly) {
      details = prepared.pyramid.bands[band];
    } else {
      // The decoder's own positions, to the bit: where two axes are nearly tied, a frame can turn
      // on the last one.
      const auto coarse = wavelet::synthesize(prepared.topology, decoded, prepared.transform, j);
      if (!coarse) return coarse.error();
      coded.frames.push_back(wavelet::predict(prepared.topology, j, *coarse).frames);
      details.resize(prepared.vectors[band].size());
      parallel_for_each_index(details.size(), [&](std::size_t i) {
        details[i] = to_frame(coded.frames[band][i], prepared.vectors[band][i]);
      });
    }
    coded.bands.push_back(encode_band(details, steps[band + 1], options));
    coded.details.push_back(std::move(details));
    decoded.bands.push_back(coded.bands.back().decoded);
  }
  const auto positions = wavelet::synthesize(prepared.topology, decoded, prepared.transform);
  if (!positions) return positions.error();
  coded.error = mean_squared_difference(*positions, prepared.positions);
  return coded;
}

std::vector<double> gains_of_errors(const Prepared& prepared, const CodedGeometry& coded,
                                    std::vector<double> gains) {
  const std::size_t count = gains.size();
  const auto error_in = [&](std::size_t part) {  // summed over the part's vertices
    return part == 0 ? coded.base.distortion * static_cast<double>(coded.base.decoded.size())
                     : coded.bands[part - 1].distortion *
                           static_cast<double>(coded.bands[part - 1].decoded.size());
  };
  if (prepared.transform == wavelet::Transform::kButterfly) {
    parallel_for_each_index(
        count,
        [&](std::size_t part) {
          const double error = error_in(part);
          if (!(error > 0)) return;
          const double energy = carried_energy(prepared, coded, part);
          if (energy > 0) gains[part] = energy / error;
        },
        1);
  }
  double sum = 0;
  for (std::size_t part = 0; part < count; ++part) sum += gains[part] * error_in(part);
  const double whole = coded.error * static_cast<double>(prepared.positions.size());
  if (sum > 0 && whole > 0)
    for (double& gain : gains) gain *= whole / sum;
  return gains;
}

}  // namespace nacre::codec
