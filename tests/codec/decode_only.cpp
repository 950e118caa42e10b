// SPDX-License-Identifier: Apache-2.0
//
// Decodes a stream with nothing but nacre_decode linked, and prints the mesh's counts and a hash of
// its positions' bits: equal in every build. Usage: decode_only FILE [LEVEL]
#include <bit>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "codec/decode.h"

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: decode_only FILE [LEVEL]\n");
    return 2;
  }
  std::FILE* file = std::fopen(argv[1], "rb");
  if (file == nullptr) {
    std::perror(argv[1]);
    return 3;
  }
  std::vector<std::uint8_t> bytes;
  for (int c = std::fgetc(file); c != EOF; c = std::fgetc(file))
    bytes.push_back(static_cast<std::uint8_t>(c));
  std::fclose(file);

  nacre::codec::DecodeOptions options;
  if (argc > 2) options.max_level = std::atoi(argv[2]);
  const auto mesh = nacre::codec::decode(bytes, options);
  if (!mesh) {
    std::fprintf(stderr, "%s: %s\n", argv[1], mesh.error().message.c_str());
    return 7;
  }
  std::uint64_t hash = 14695981039346656037ull;  // FNV-1a over the little-endian doubles
  for (const nacre::Vec3& p : mesh->positions) {
    for (int k = 0; k < 3; ++k) {
      const auto bits = std::bit_cast<std::uint64_t>(p[k]);
      for (int i = 0; i < 8; ++i) hash = (hash ^ ((bits >> (8 * i)) & 0xFF)) * 1099511628211ull;
    }
  }
  std::printf("%d levels, %zu vertices, positions %016llx\n", mesh->level_count,
              mesh->positions.size(), static_cast<unsigned long long>(hash));
  return 0;
}
