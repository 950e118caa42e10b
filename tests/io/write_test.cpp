// SPDX-License-Identifier: GPL-3.0-or-later
#include <bit>
#include <limits>
#include <nlohmann/json.hpp>

#include "io/io_test_support.h"
#include "support/shapes.h"

namespace nacre::io {
namespace {

constexpr MeshFormat kReadableFormats[] = {MeshFormat::kPly, MeshFormat::kObj, MeshFormat::kOff,
                                           MeshFormat::kStl};
constexpr const char* kNames[] = {"a.ply", "a.obj", "a.off", "a.stl", "a.glb"};

const char* name_of(MeshFormat format) { return kNames[static_cast<std::size_t>(format)]; }

/// As floats: the shortest decimal of a float is another double, and the same float.
std::vector<Eigen::Vector3f> as_floats(const std::vector<Vec3>& points) {
  std::vector<Eigen::Vector3f> floats;
  for (const Vec3& p : points) floats.push_back(p.cast<float>());
  return floats;
}

/// Coordinates that are floats, as decoded meshes are once written.
Scan float_torus() {
  Scan mesh = shapes::torus(9, 7);
  // On a binary grid, as gcc 12 wrongly drops the rounding of double -> float -> double in a loop.
  for (Vec3& p : mesh.positions) p = (p * 65536.0).array().round() / 65536.0;
  mesh.positions[0] = {0.1f, -1e-30f, 1e-45f};
  mesh.positions[1] = {16777216.0f, -0.0, 3.4e27f};
  return mesh;
}

TEST(SerializeMesh, FloatsComeBackExactly) {
  const Scan mesh = float_torus();
  for (const MeshFormat format : kReadableFormats) {
    const auto bytes = serialize_mesh(mesh, format);
    ASSERT_TRUE(bytes.has_value()) << bytes.error().message;
    const auto read = read_as(name_of(format), *bytes);
    ASSERT_TRUE(read.has_value()) << read.error().message;
    const Scan& again = (*read).scan;
    const auto positions = as_floats(again.positions), expected = as_floats(mesh.positions);
    ASSERT_EQ(again.triangles.size(), mesh.triangles.size());
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(positions[again.triangles[f][k]], expected[mesh.triangles[f][k]]);
      }
    }
    if (format == MeshFormat::kStl) continue;
    EXPECT_EQ(positions, expected);
    EXPECT_EQ(again.triangles, mesh.triangles);
    if (format == MeshFormat::kPly) {
      EXPECT_EQ(again.positions, mesh.positions);
    }
  }
}

TEST(SerializeMesh, PlyIsFloatWithoutAnOriginAndDoubleWithOne) {
  Scan mesh = shapes::tetrahedron();
  const std::string near = text_of(*serialize_mesh(mesh, MeshFormat::kPly));
  EXPECT_NE(near.find("property float x\n"), std::string::npos);
  EXPECT_EQ(near.size(), near.find("end_header\n") + 11 + 4 * 12 + 4 * 13);
  mesh.origin = {1e6, 0, 0};
  const std::string far = text_of(*serialize_mesh(mesh, MeshFormat::kPly));
  EXPECT_NE(far.find("property double x\n"), std::string::npos);
  EXPECT_EQ(far.size(), far.find("end_header\n") + 11 + 4 * 24 + 4 * 13);
}

TEST(SerializeMesh, PlyCarriesQualityAndColor) {
  const Scan mesh = shapes::tetrahedron();
  const VertexChannels channels{.quality = {0, 0.5, 1, 2},
                                .color = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {255, 0, 128}}};
  const std::string text = text_of(*serialize_mesh(mesh, MeshFormat::kPly, channels));
  const std::size_t body = text.find("end_header\n") + 11;
  ASSERT_EQ(text.size(), body + 4 * 19 + 4 * 13);
  float quality = 0;
  std::memcpy(&quality, text.data() + body + 3 * 19 + 12, 4);
  EXPECT_EQ(quality, 2.0f);
  EXPECT_EQ(text.substr(body + 3 * 19 + 16, 3), std::string("\xFF\x00\x80", 3));
  const auto read = read_as("a.ply", text);
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ((*read).scan.positions, mesh.positions);
  EXPECT_EQ((*read).report.not_carried, (Names{"quality", "red", "green", "blue"}));
}

TEST(SerializeMesh, TextIsShortAndHasNoLocale) {
  Scan mesh = {{{0.1, 0, -2}, {1e-7, 1, 0}, {0.30000001192092896, 1e20, 0}}, {{0, 1, 2}}};
  EXPECT_EQ(text_of(*serialize_mesh(mesh, MeshFormat::kObj)),
            "# written by nacre\nv 0.1 0 -2\nv 1e-07 1 0\nv 0.3 1e+20 0\nf 1 2 3\n");
  EXPECT_EQ(text_of(*serialize_mesh(mesh, MeshFormat::kOff)),
            "OFF\n3 1 0\n0.1 0 -2\n1e-07 1 0\n0.3 1e+20 0\n3 0 1 2\n");
}

TEST(SerializeMesh, StlHasUnitFacetNormals) {
  Scan mesh = shapes::octahedron();
  mesh.triangles.push_back({0, 0, 1});  // no area, no normal
  const auto bytes = *serialize_mesh(mesh, MeshFormat::kStl);
  ASSERT_EQ(bytes.size(), 84u + 50 * 9);
  EXPECT_NE(text_of(bytes).substr(0, 5), "solid");
  EXPECT_NE(text_of(bytes).substr(0, 80).find("nacre"), std::string::npos);
  for (std::size_t f = 0; f < 9; ++f) {
    std::array<float, 3> normal;
    std::memcpy(normal.data(), bytes.data() + 84 + 50 * f, 12);
    const Triangle& t = mesh.triangles[f];
    for (int k = 0; k < 3; ++k) {
      const double sum =
          mesh.positions[t[0]][k] + mesh.positions[t[1]][k] + mesh.positions[t[2]][k];
      EXPECT_FLOAT_EQ(normal[static_cast<std::size_t>(k)],
                      f == 8 ? 0.0f : static_cast<float>(sum / std::sqrt(3.0)));
    }
  }
}

std::uint32_t word_at(const std::vector<std::uint8_t>& bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, 4);
  return value;
}

/// Checks what the specification demands of these few properties, and returns the mesh.
Scan parse_glb(const std::vector<std::uint8_t>& bytes) {
  Scan mesh;
  EXPECT_EQ(text_of(bytes).substr(0, 4), "glTF");
  EXPECT_EQ(word_at(bytes, 4), 2u);
  EXPECT_EQ(word_at(bytes, 8), bytes.size());
  const std::size_t json_bytes = word_at(bytes, 12);
  EXPECT_EQ(text_of(bytes).substr(16, 4), "JSON");
  EXPECT_EQ(json_bytes % 4, 0u);
  const std::size_t bin = 20 + json_bytes;
  EXPECT_EQ(text_of(bytes).substr(bin + 4, 4), std::string("BIN\0", 4));
  EXPECT_EQ(bin + 8 + word_at(bytes, bin), bytes.size());
  EXPECT_EQ(word_at(bytes, bin) % 4, 0u);

  const auto json =
      nlohmann::json::parse(bytes.begin() + 20, bytes.begin() + static_cast<std::ptrdiff_t>(bin));
  EXPECT_EQ(json["asset"]["version"], "2.0");
  const auto& node =
      json["nodes"]
          [json["scenes"][json["scene"].get<std::size_t>()]["nodes"][0].get<std::size_t>()];
  if (node.contains("translation")) {
    for (int k = 0; k < 3; ++k) mesh.origin[k] = node["translation"][static_cast<std::size_t>(k)];
  }
  const auto& primitive = json["meshes"][node["mesh"].get<std::size_t>()]["primitives"][0];
  EXPECT_EQ(primitive["mode"], 4);
  EXPECT_EQ(json["buffers"][0]["byteLength"], word_at(bytes, bin));
  const auto data_of = [&](const nlohmann::json& accessor, std::size_t value_bytes, int target) {
    const auto& view = json["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    EXPECT_EQ(view["target"], target);
    EXPECT_EQ(view["byteOffset"].get<std::size_t>() % 4, 0u);
    EXPECT_EQ(view["byteLength"], accessor["count"].get<std::size_t>() * value_bytes);
    EXPECT_LE(view["byteOffset"].get<std::size_t>() + view["byteLength"].get<std::size_t>(),
              word_at(bytes, bin));
    return bytes.data() + bin + 8 + view["byteOffset"].get<std::size_t>();
  };
  const auto& positions = json["accessors"][primitive["attributes"]["POSITION"].get<std::size_t>()];
  EXPECT_EQ(positions["componentType"], 5126);
  EXPECT_EQ(positions["type"], "VEC3");
  const std::uint8_t* at = data_of(positions, 12, 34962);
  Vec3 low = Vec3::Constant(INFINITY), high = -low;
  for (std::size_t v = 0; v < positions["count"]; ++v, at += 12) {
    std::array<float, 3> p;
    std::memcpy(p.data(), at, 12);
    mesh.positions.emplace_back(p[0], p[1], p[2]);
    low = low.cwiseMin(mesh.positions.back());
    high = high.cwiseMax(mesh.positions.back());
  }
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(positions["min"][k].get<float>(), low[static_cast<Eigen::Index>(k)]);
    EXPECT_EQ(positions["max"][k].get<float>(), high[static_cast<Eigen::Index>(k)]);
  }
  const auto& indices = json["accessors"][primitive["indices"].get<std::size_t>()];
  EXPECT_EQ(indices["componentType"], 5125);
  EXPECT_EQ(indices["type"], "SCALAR");
  at = data_of(indices, 4, 34963);
  mesh.triangles.resize(indices["count"].get<std::size_t>() / 3);
  std::memcpy(mesh.triangles.data(), at, 12 * mesh.triangles.size());
  return mesh;
}

TEST(SerializeMesh, GlbIsWellFormed) {
  Scan mesh = float_torus();
  const Scan read = parse_glb(*serialize_mesh(mesh, MeshFormat::kGlb));
  EXPECT_EQ(read.positions, mesh.positions);
  EXPECT_EQ(read.triangles, mesh.triangles);
  EXPECT_TRUE(read.origin.isZero(0.0));
  mesh.origin = {448262.123456, 5412345.654321, -0.1};
  const Scan far = parse_glb(*serialize_mesh(mesh, MeshFormat::kGlb));
  EXPECT_EQ(far.positions, mesh.positions);
  EXPECT_EQ(far.origin, mesh.origin);
}

TEST(SerializeMesh, RefusesWhatItCannotSay) {
  const auto code_of = [](const Scan& mesh, MeshFormat format,
                          const VertexChannels& channels = {}) {
    const auto bytes = serialize_mesh(mesh, format, channels);
    return bytes.has_value() ? ErrorCode::kCancelled : bytes.error().code;
  };
  for (const MeshFormat format : kReadableFormats) {
    Scan mesh = shapes::tetrahedron();
    EXPECT_EQ(code_of(mesh, format, {.quality = {1.0f}, .color = {}}), ErrorCode::kBadInput);
    EXPECT_EQ(code_of(mesh, format, {.quality = {}, .color = {{1, 2, 3}}}), ErrorCode::kBadInput);
    mesh.triangles[1][2] = 4;
    EXPECT_EQ(code_of(mesh, format), ErrorCode::kBadInput);
    EXPECT_EQ(serialize_mesh(mesh, format).error().where, 1u);
    mesh = shapes::tetrahedron();
    mesh.positions[2][1] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(code_of(mesh, format), ErrorCode::kBadInput);
    mesh.positions[2][1] = 1e39;
    EXPECT_EQ(code_of(mesh, format), ErrorCode::kBadInput);
    EXPECT_EQ(serialize_mesh(mesh, format).error().where, 2u);
  }
  EXPECT_EQ(code_of(Scan{}, MeshFormat::kGlb), ErrorCode::kBadInput);
}

TEST(MeshFormat, ByExtension) {
  EXPECT_EQ(*mesh_format("a/b.ply"), MeshFormat::kPly);
  EXPECT_EQ(*mesh_format("B.OBJ"), MeshFormat::kObj);
  EXPECT_EQ(*mesh_format("c.x.Off"), MeshFormat::kOff);
  EXPECT_EQ(*mesh_format("d.stl"), MeshFormat::kStl);
  EXPECT_EQ(*mesh_format("e.glb"), MeshFormat::kGlb);
  for (const char* name : {"f", "f.gltf", "ply", ".ply"}) {
    const auto format = mesh_format(name);
    ASSERT_FALSE(format.has_value()) << name;
    EXPECT_EQ(format.error().code, ErrorCode::kBadInput);
    EXPECT_NE(format.error().message.find(".ply .obj .off .stl .glb"), std::string::npos);
  }
}

}  // namespace
}  // namespace nacre::io
