// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <limits>

#include "io/bytes.h"
#include "io/write.h"

namespace nacre::io {
namespace {

constexpr std::size_t kStlFacetBytes = 50;
constexpr std::size_t kStlHeaderBytes = 80;

/// Coordinates as they stand in the file: with the origin, in float where that is zero.
class Coordinates {
 public:
  explicit Coordinates(const TriangleMesh& mesh) : mesh_(mesh), wide_(!mesh.origin.isZero(0.0)) {}
  [[nodiscard]] bool are_double() const { return wide_; }
  [[nodiscard]] Vec3 absolute(std::size_t v) const {
    return wide_ ? Vec3(mesh_.positions[v] + mesh_.origin) : mesh_.positions[v];
  }
  /// Shortest decimals that read back as the same float, or double.
  void put_text(std::vector<std::uint8_t>& out, std::size_t v) const {
    const Vec3 p = absolute(v);
    for (int k = 0; k < 3; ++k) {
      if (k > 0) out.push_back(' ');
      if (wide_) {
        put_number(out, p[k]);
      } else {
        put_number(out, static_cast<float>(p[k]));
      }
    }
  }

 private:
  const TriangleMesh& mesh_;
  bool wide_;
};

std::vector<std::uint8_t> write_ply(const TriangleMesh& mesh, const VertexChannels& channels) {
  const Coordinates coordinates(mesh);
  const std::string type = coordinates.are_double() ? "double" : "float";
  std::string header = "ply\nformat binary_little_endian 1.0\ncomment written by nacre\n";
  header += "element vertex " + std::to_string(mesh.positions.size()) + "\n";
  for (const char* axis : {"x", "y", "z"}) header += "property " + type + " " + axis + "\n";
  if (!channels.quality.empty()) header += "property float quality\n";
  if (!channels.color.empty()) {
    for (const char* name : {"red", "green", "blue"}) {
      header += std::string("property uchar ") + name + "\n";
    }
  }
  header += "element face " + std::to_string(mesh.triangles.size()) + "\n";
  header += "property list uchar int vertex_indices\nend_header\n";

  std::vector<std::uint8_t> out;
  out.reserve(header.size() + mesh.positions.size() * (coordinates.are_double() ? 31 : 19) +
              mesh.triangles.size() * 13);
  put_text(out, header);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vec3 p = coordinates.absolute(v);
    for (int k = 0; k < 3; ++k) {
      if (coordinates.are_double()) {
        put_value(out, p[k]);
      } else {
        put_value(out, static_cast<float>(p[k]));
      }
    }
    if (!channels.quality.empty()) put_value(out, channels.quality[v]);
    if (!channels.color.empty()) put_value(out, channels.color[v]);
  }
  for (const Triangle& t : mesh.triangles) {
    out.push_back(3);
    put_value(out, t);
  }
  return out;
}

std::vector<std::uint8_t> write_obj(const TriangleMesh& mesh) {
  const Coordinates coordinates(mesh);
  std::vector<std::uint8_t> out;
  put_text(out, "# written by nacre\n");
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    put_text(out, "v ");
    coordinates.put_text(out, v);
    out.push_back('\n');
  }
  for (const Triangle& t : mesh.triangles) {
    out.push_back('f');
    for (const std::uint32_t v : t) {
      out.push_back(' ');
      put_number(out, std::uint64_t{v} + 1);
    }
    out.push_back('\n');
  }
  return out;
}

std::vector<std::uint8_t> write_off(const TriangleMesh& mesh) {
  const Coordinates coordinates(mesh);
  std::vector<std::uint8_t> out;
  put_text(out, "OFF\n" + std::to_string(mesh.positions.size()) + " " +
                    std::to_string(mesh.triangles.size()) + " 0\n");
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    coordinates.put_text(out, v);
    out.push_back('\n');
  }
  for (const Triangle& t : mesh.triangles) {
    out.push_back('3');
    for (const std::uint32_t v : t) {
      out.push_back(' ');
      put_number(out, v);
    }
    out.push_back('\n');
  }
  return out;
}

/// Of the positions relative to the origin, so that a large one costs no precision here.
Vec3 facet_normal(const TriangleMesh& mesh, const Triangle& t) {
  const Vec3& a = mesh.positions[t[0]];
  const Vec3 normal = cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a);
  const double length = norm(normal);
  return length > 0.0 ? Vec3(normal / length) : Vec3(Vec3::Zero());
}

Result<std::vector<std::uint8_t>> write_stl(const TriangleMesh& mesh) {
  if (mesh.triangles.size() > std::numeric_limits<std::uint32_t>::max()) {
    return Error{ErrorCode::kLimitExceeded,
                 std::to_string(mesh.triangles.size()) +
                     " triangles are more than STL's 32-bit count can say; write PLY",
                 0};
  }
  const Coordinates coordinates(mesh);
  std::vector<std::uint8_t> out;
  out.reserve(kStlHeaderBytes + 4 + mesh.triangles.size() * kStlFacetBytes);
  // Not "solid ...", which readers take for the start of an ascii file.
  put_text(out, "binary STL written by nacre");
  out.resize(kStlHeaderBytes, ' ');
  put_value(out, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const Triangle& t : mesh.triangles) {
    const Vec3 normal = facet_normal(mesh, t);
    for (int k = 0; k < 3; ++k) put_value(out, static_cast<float>(normal[k]));
    for (const std::uint32_t v : t) {
      const Vec3 p = coordinates.absolute(v);
      for (int k = 0; k < 3; ++k) put_value(out, static_cast<float>(p[k]));
    }
    put_value(out, std::uint16_t{0});
  }
  return out;
}

/// What only a caller's mistake can cause; checked once here, for all formats.
Result<void> check(const TriangleMesh& mesh, const VertexChannels& channels) {
  const std::size_t count = mesh.positions.size();
  if (count >= kNone) {
    return Error{ErrorCode::kLimitExceeded, std::to_string(count) + " vertices exceed 32-bit ids",
                 count};
  }
  if ((!channels.quality.empty() && channels.quality.size() != count) ||
      (!channels.color.empty() && channels.color.size() != count)) {
    return Error{
        ErrorCode::kBadInput,
        "a vertex channel has not one entry for each of " + std::to_string(count) + " vertices",
        count};
  }
  for (std::size_t v = 0; v < count; ++v) {
    const Vec3 p = mesh.positions[v] + mesh.origin;
    for (int k = 0; k < 3; ++k) {
      if (std::abs(p[k]) <= std::numeric_limits<float>::max()) continue;
      return Error{ErrorCode::kBadInput, "vertex " + std::to_string(v) + " does not fit a float",
                   v};
    }
  }
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const Triangle& t = mesh.triangles[f];
    if (std::max({t[0], t[1], t[2]}) < count) continue;
    return Error{ErrorCode::kBadInput, "triangle " + std::to_string(f) + " names a missing vertex",
                 f};
  }
  return {};
}

}  // namespace

Result<MeshFormat> mesh_format(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  if (extension == ".ply") return MeshFormat::kPly;
  if (extension == ".obj") return MeshFormat::kObj;
  if (extension == ".off") return MeshFormat::kOff;
  if (extension == ".stl") return MeshFormat::kStl;
  if (extension == ".glb") return MeshFormat::kGlb;
  return Error{
      ErrorCode::kBadInput,
      file.string() + ": the name ends in none of .ply .obj .off .stl .glb; change the ending", 0};
}

Result<std::vector<std::uint8_t>> serialize_mesh(const TriangleMesh& mesh, MeshFormat format,
                                                 const VertexChannels& channels) {
  if (Result<void> checked = check(mesh, channels); !checked) return checked.error();
  switch (format) {
    case MeshFormat::kPly:
      return write_ply(mesh, channels);
    case MeshFormat::kObj:
      return write_obj(mesh);
    case MeshFormat::kOff:
      return write_off(mesh);
    case MeshFormat::kStl:
      return write_stl(mesh);
    case MeshFormat::kGlb:
      return write_glb(mesh);
  }
  return Error{ErrorCode::kBadInput, "unknown mesh format", 0};
}

}  // namespace nacre::io
