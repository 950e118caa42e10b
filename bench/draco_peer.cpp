// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/draco_peer.h"

#ifdef NACRE_HAS_DRACO
#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#endif

namespace nacre::bench {

#ifdef NACRE_HAS_DRACO

std::optional<std::vector<char>> draco_encode(const Scan& scan, int position_bits, int level) {
  draco::Mesh mesh;
  const auto vertices = static_cast<std::uint32_t>(scan.positions.size());
  mesh.set_num_points(vertices);
  draco::GeometryAttribute position;
  position.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false,
                3 * sizeof(float), 0);
  const int id = mesh.AddAttribute(position, true, vertices);
  for (std::uint32_t v = 0; v < vertices; ++v) {
    const Eigen::Vector3f p = scan.positions[v].cast<float>();
    mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), p.data());
  }
  mesh.SetNumFaces(scan.triangles.size());
  for (std::uint32_t f = 0; f < scan.triangles.size(); ++f) {
    const Triangle& t = scan.triangles[f];
    mesh.SetFace(draco::FaceIndex(f),
                 {draco::PointIndex(t[0]), draco::PointIndex(t[1]), draco::PointIndex(t[2])});
  }
  draco::Encoder encoder;
  encoder.SetSpeedOptions(10 - level, 10 - level);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, position_bits);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeMeshToBuffer(mesh, &buffer).ok()) return std::nullopt;
  return std::vector<char>(buffer.data(), buffer.data() + buffer.size());
}

std::size_t draco_decode(const std::vector<char>& bytes) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
  return mesh.ok() ? mesh.value()->num_points() : 0;
}

#else

std::optional<std::vector<char>> draco_encode(const Scan&, int, int) { return std::nullopt; }
std::size_t draco_decode(const std::vector<char>&) { return 0; }

#endif

}  // namespace nacre::bench
