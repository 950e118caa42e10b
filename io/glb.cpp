// SPDX-License-Identifier: Apache-2.0
//
// glTF 2.0 specification, section 4 (GLB) and 5 (properties): a 12-byte header, a JSON chunk padded
// with spaces, a binary chunk padded with zeros, all of 4-byte alignment.
#include <algorithm>
#include <array>
#include <limits>
#include <string>

#include "io/bytes.h"

namespace nacre::io {
namespace {

constexpr std::uint32_t kMagic = 0x46546C67;      // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kBinChunk = 0x004E4942;   // "BIN\0"
constexpr std::size_t kHeadersBytes = 12 + 8 + 8;

template <class T>
std::string json_vector(const std::array<T, 3>& values) {
  std::vector<std::uint8_t> text;
  for (const T& value : values) {
    text.push_back(text.empty() ? '[' : ',');
    put_number(text, value);
  }
  return std::string(text.begin(), text.end()) + "]";
}

std::string json(const TriangleMesh& mesh, std::size_t position_bytes, std::size_t index_bytes) {
  // Of the floats as stored: a validator compares them for equality.
  std::array<float, 3> low, high;
  low.fill(std::numeric_limits<float>::max());
  high.fill(std::numeric_limits<float>::lowest());
  for (const Vec3& p : mesh.positions) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto x = static_cast<float>(p[static_cast<Eigen::Index>(k)]);
      low[k] = std::min(low[k], x);
      high[k] = std::max(high[k], x);
    }
  }
  const std::string positions = std::to_string(position_bytes);
  std::string text = R"({"asset":{"version":"2.0","generator":"nacre"},"scene":0,)";
  text += R"("scenes":[{"nodes":[0]}],"nodes":[{"mesh":0)";
  if (!mesh.origin.isZero(0.0)) {
    const std::array<double, 3> origin = {mesh.origin[0], mesh.origin[1], mesh.origin[2]};
    text += R"(,"translation":)" + json_vector(origin);
  }
  text += R"(}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"mode":4}]}],)";
  text += R"("buffers":[{"byteLength":)" + std::to_string(position_bytes + index_bytes) + "}],";
  text += R"("bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":)" + positions;
  text += R"(,"target":34962},{"buffer":0,"byteOffset":)" + positions + R"(,"byteLength":)";
  text += std::to_string(index_bytes) + R"(,"target":34963}],)";
  text += R"("accessors":[{"bufferView":0,"componentType":5126,"count":)";
  text += std::to_string(mesh.positions.size()) + R"(,"type":"VEC3","min":)" + json_vector(low);
  text += R"(,"max":)" + json_vector(high) + R"(},{"bufferView":1,"componentType":5125,"count":)";
  text += std::to_string(3 * mesh.triangles.size()) + R"(,"type":"SCALAR"}]})";
  return text;
}

}  // namespace

Result<std::vector<std::uint8_t>> write_glb(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) {
    return Error{ErrorCode::kBadInput, "GLB cannot hold a mesh without triangles; write PLY", 0};
  }
  // Both are multiples of 4, so the binary chunk needs no padding.
  const std::size_t position_bytes = 12 * mesh.positions.size();
  const std::size_t index_bytes = 12 * mesh.triangles.size();
  std::string text = json(mesh, position_bytes, index_bytes);
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const std::size_t total = kHeadersBytes + text.size() + position_bytes + index_bytes;
  if (total > std::numeric_limits<std::uint32_t>::max()) {
    return Error{
        ErrorCode::kLimitExceeded,
        std::to_string(total) + " bytes are more than GLB's 4 GiB; write PLY or a coarser level",
        0};
  }
  std::vector<std::uint8_t> out;
  out.reserve(total);
  put_value(out, kMagic);
  put_value(out, std::uint32_t{2});
  put_value(out, static_cast<std::uint32_t>(total));
  put_value(out, static_cast<std::uint32_t>(text.size()));
  put_value(out, kJsonChunk);
  put_text(out, text);
  put_value(out, static_cast<std::uint32_t>(position_bytes + index_bytes));
  put_value(out, kBinChunk);
  for (const Vec3& p : mesh.positions) {
    for (int k = 0; k < 3; ++k) put_value(out, static_cast<float>(p[k]));
  }
  for (const Triangle& t : mesh.triangles) put_value(out, t);
  return out;
}

}  // namespace nacre::io
