// SPDX-License-Identifier: GPL-3.0-or-later
//
// Files cut and changed at every place. The parsers are called on buffers of the exact size, so
// that a sanitizer build sees any read past the end.
#include <random>

#include "io/io_test_support.h"

namespace nacre::io {
namespace {

struct Sample {
  std::string name;
  Result<ReadResult> (*reader)(const Source&);
  std::string bytes;
  bool states_its_size;  ///< so that every cut can be told
};

Result<ReadResult> parse(const Sample& sample, const std::string& bytes) {
  const std::vector<char> exact(bytes.begin(), bytes.end());
  return sample.reader({sample.name, {exact.data(), exact.size()}});
}

std::string ply_sample(bool ascii, bool big) {
  std::string text = "ply\nformat ";
  text += ascii ? "ascii" : big ? "binary_big_endian" : "binary_little_endian";
  text +=
      " 1.0\ncomment x\nelement camera 1\nproperty list uchar short k\nelement vertex 4\n"
      "property double x\nproperty float y\nproperty short z\nproperty uchar red\n"
      "element face 3\nproperty list uchar uint vertex_indices\nproperty float quality\n"
      "element tristrips 1\nproperty list int int vertex_indices\nend_header\n";
  if (ascii) {
    return text +
           "2 7 8\n0 0 0 9\n1 0 0 9\n0 1 0 9\n0 0 1 9\n3 0 2 1 .5\n4 0 1 2 3 .5\n3 1 2 3 .5\n"
           "5 0 1 2 -1 -1\n";
  }
  append(text, std::uint8_t{2});
  for (const int k : {7, 8}) append(text, static_cast<std::int16_t>(k), big);
  for (const Vec3& p : kCorners) {
    append(text, p[0], big);
    append(text, static_cast<float>(p[1]), big);
    append(text, static_cast<std::int16_t>(p[2]), big);
    append(text, std::uint8_t{9});
  }
  for (const std::vector<std::uint32_t>& face :
       {std::vector<std::uint32_t>{0, 2, 1}, {0, 1, 2, 3}, {1, 2, 3}}) {
    append(text, static_cast<std::uint8_t>(face.size()));
    for (const std::uint32_t v : face) append(text, v, big);
    append(text, 0.5f, big);
  }
  for (const std::int32_t v : {5, 0, 1, 2, -1, -1}) append(text, v, big);
  return text;
}

std::vector<Sample> samples() {
  Scan mesh;
  mesh.positions = kCorners;
  mesh.triangles = kFaces;
  return {{"ascii.ply", read_ply, ply_sample(true, false), true},
          {"le.ply", read_ply, ply_sample(false, false), true},
          {"be.ply", read_ply, ply_sample(false, true), true},
          {"a.off", read_off,
           "COFF # c\n4 4 0\n0 0 0 1 1 1\n1 0 0 1\n0 1 0\n0 0 1\n3 0 2 1\n4 0 1 2 3 9 9 9\n3 0 3 "
           "2\n3 1 2 3\n",
           true},
          {"binary.stl", read_stl, text_of(*serialize_mesh(mesh, MeshFormat::kStl)), true},
          {"a.obj", read_obj,
           "# c\nmtllib x\nv 0 0 0\nv 1 0 0 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nf 1/1 3/1 2/1\nf 1 2 "
           "\\\n3 4\nf -3//1 -2//1 -1//1\n",
           false},
          {"ascii.stl", read_stl,
           "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
           "0\nendloop\nendfacet\n"
           "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 "
           "0\nendloop\nendfacet\nendsolid x\n",
           false}};
}

/// Accepted or not, a result keeps the promises of io.h.
void expect_sound(const Result<ReadResult>& result, const std::string& what) {
  if (!result.has_value()) {
    EXPECT_EQ(result.error().code, ErrorCode::kUnreadableFile) << what;
    EXPECT_FALSE(result.error().message.empty()) << what;
    EXPECT_EQ(result.error().message.find('\n'), std::string::npos) << what;
    return;
  }
  const Scan& scan = (*result).scan;
  EXPECT_FALSE(scan.triangles.empty()) << what;
  for (const Triangle& t : scan.triangles) {
    for (const std::uint32_t v : t) ASSERT_LT(v, scan.positions.size()) << what;
  }
  for (const Vec3& p : scan.positions) ASSERT_TRUE(p.allFinite()) << what;
}

TEST(HostileFiles, SamplesAreAcceptedWhole) {
  for (const Sample& sample : samples()) {
    const auto read = parse(sample, sample.bytes);
    ASSERT_TRUE(read.has_value()) << read.error().message;
    expect_sound(read, sample.name);
  }
}

TEST(HostileFiles, EveryTruncation) {
  for (const Sample& sample : samples()) {
    const bool is_text = sample.bytes.find('\0') == std::string::npos;
    for (std::size_t size = 0; size < sample.bytes.size(); ++size) {
      const auto read = parse(sample, sample.bytes.substr(0, size));
      const std::string what = sample.name + " cut to " + std::to_string(size);
      expect_sound(read, what);
      // The last line end of a text, and what states no size, may go unnoticed.
      if (sample.states_its_size && !(is_text && size + 1 == sample.bytes.size())) {
        EXPECT_FALSE(read.has_value()) << what;
      }
    }
  }
}

TEST(HostileFiles, RandomChanges) {
  std::mt19937 random(2026);
  static constexpr std::string_view kLikely = "0123456789-+.eE/# \n\r\t\\\xFF\x80\x7F\x01";
  for (const Sample& sample : samples()) {
    for (int round = 0; round < 3000; ++round) {
      std::string bytes = sample.bytes;
      for (unsigned change = 1 + random() % 4; change > 0 && !bytes.empty(); --change) {
        const std::size_t at = random() % bytes.size();
        const char byte =
            random() % 2 == 0 ? kLikely[random() % kLikely.size()] : static_cast<char>(random());
        switch (random() % 5) {
          case 0:
            bytes[at] = byte;
            break;
          case 1:
            bytes[at] = static_cast<char>(bytes[at] ^ (1 << random() % 8));
            break;
          case 2:
            bytes.insert(at, 1, byte);
            break;
          case 3:
            bytes.erase(at, 1 + random() % 8);
            break;
          default:
            bytes.insert(at, bytes.substr(random() % bytes.size(), random() % 40));
            break;
        }
      }
      expect_sound(parse(sample, bytes), sample.name + " round " + std::to_string(round));
    }
  }
}

TEST(HostileFiles, RandomBytes) {
  std::mt19937 random(7);
  const auto all = samples();
  for (int round = 0; round < 2000; ++round) {
    std::string bytes(random() % 300, '\0');
    for (char& c : bytes) c = static_cast<char>(random());
    for (const Sample& sample : all) expect_sound(parse(sample, bytes), sample.name);
  }
}

TEST(HostileFiles, CountsThatOverflow) {
  // Each count alone is refused before anything is allocated for it; products must not wrap.
  for (const char* count :
       {"4294967294", "4294967295", "4294967296", "4611686018427387904", "9223372036854775807",
        "18446744073709551615", "99999999999999999999"}) {
    const std::string n = count;
    const std::string vertex = "property float x\nproperty float y\nproperty float z\n";
    for (const char* format : {"ascii", "binary_little_endian"}) {
      const std::string head = std::string("ply\nformat ") + format + " 1.0\nelement vertex ";
      const std::string faces = "property list uchar int vertex_indices\nend_header\n";
      EXPECT_FALSE(
          read_ply({"a", head + n + "\n" + vertex + "element face 1\n" + faces}).has_value());
      EXPECT_FALSE(
          read_ply({"a", head + "0\n" + vertex + "element face " + n + "\n" + faces}).has_value());
      EXPECT_FALSE(
          read_ply({"a", head + "0\n" + vertex + "element e " + n + "\nend_header\n"}).has_value());
      EXPECT_FALSE(read_ply({"a", head + "0\n" + vertex + "element e " + n +
                                      "\nproperty list char int8 p\nend_header\n"})
                       .has_value());
    }
    EXPECT_FALSE(read_off({"a", "OFF\n" + n + " 1 0\n0 0 0\n"}).has_value());
    EXPECT_FALSE(read_off({"a", "OFF\n1 " + n + " 0\n0 0 0\n"}).has_value());
    EXPECT_FALSE(read_off({"a", "OFF\n1 1 0\n0 0 0\n" + n + " 0 0 0\n"}).has_value());
  }
}

}  // namespace
}  // namespace nacre::io
